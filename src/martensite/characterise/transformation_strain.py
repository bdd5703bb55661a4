"""Transformation strain against stress: constant, or the saturating form of the Lagoudas law.

    H(σ) = H_min + (H_sat - H_min)(1 - exp[-k (σ - σ_crit)]) above σ_crit, else H_min

The saturating form needs `LEAST_STRESSES` stresses and must justify its two further parameters. With S the sum of
squared residuals and ν degrees of freedom, the F-test of two additional terms has the closed form

    p = (S_saturating/S_constant)^(ν/2) < 5 %.

σ_crit is zero, and free only if at least `FEWEST_CRITICAL` stresses show it at the same level. A negative H_min is
fixed at zero. k is sought where the largest stress is between `LEAST_RATE` and `MOST_RATE` times 1/k. At the lower end
the strain shows no saturation, and there are no intervals.

Source: Lagoudas et al. (2012), Int. J. Plasticity 32–33, equation for H(σ).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL, two_sided_probability
from martensite.base.errors import DataError, SolveError
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.regression import fit_residuals, root_mean_square

LEAST_STRESSES = 4
"""Number of different stresses from which the saturating form is tried."""
FEWEST_CRITICAL = 6
"""Number of different stresses from which a critical stress is tried."""
LEAST_RATE, MOST_RATE = 0.5, 50.0
RATES = 200
PLACES = 60
"""Number of values of k, and of σ_crit, on the first grid."""
NAMES = ("low", "high", "rate", "crit")
"""H_min, H_sat, k and σ_crit, in the order of `saturating_strain`."""


@dataclass(frozen=True)
class StrainFit:
    """Transformation strain as a function of stress."""

    form: str
    """`constant` or `saturating`."""
    mean: MeasuredValue
    """Mean over the stresses [-]."""
    H_min: MeasuredValue
    """[-]; the mean for `constant`."""
    H_sat: MeasuredValue
    """[-]; the mean for `constant`."""
    H_k: MeasuredValue | None
    """[1/Pa]; None for `constant`."""
    sigma_crit: MeasuredValue | None
    """[Pa]; None if fixed at 0."""
    deviation: float
    """Root mean square of the residuals [-]."""

    def value(self, stress: float) -> float:
        """Return H [-] at a stress [Pa]."""
        if self.H_k is None:
            return self.mean.value
        crit = 0.0 if self.sigma_crit is None else self.sigma_crit.value
        return saturating_strain(self.H_min.value, self.H_sat.value, self.H_k.value, crit, stress)

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all numbers by name, for JSON."""
        entries: dict[str, Any] = {"form": self.form, "deviation": self.deviation}
        for name in ("mean", "H_min", "H_sat", "H_k", "sigma_crit"):
            estimate = getattr(self, name)
            entries[name] = None if estimate is None else estimate.to_dict(level)
        return entries


@dataclass(frozen=True)
class _Shape:
    """Parameters of the saturating form, and their sum of squares."""

    low: float
    high: float
    rate: float
    crit: float
    squares: float


def saturating_strain(low: float, high: float, rate: float, crit: float, stress: float) -> float:
    """Return H_min + (H_sat - H_min)(1 - exp[-k (σ - σ_crit)]) above σ_crit, else H_min [-]."""
    return low - (high - low) * math.expm1(-rate * max(stress - crit, 0.0))


def fit_transformation_strain(stresses: Sequence[float], strains: Sequence[float]) -> StrainFit:
    """Fit the transformation strain [-] as a function of stress [Pa].

    Raises:
        DataError: the data are empty, or differ in length.
    """
    if not strains or len(stresses) != len(strains):
        raise DataError(
            f"There must be one transformation strain per stress, but there are {len(strains)} and {len(stresses)}."
        )
    mean = _mean_strain(strains)
    squares = math.fsum((h - mean.value) ** 2 for h in strains)
    levels = len(set(stresses))
    if levels >= LEAST_STRESSES and max(stresses) > 0.0:
        shape = _search_grid(stresses, strains, [0.0])
        spare = len(strains) - 3
        if shape.high > shape.low and _is_worthwhile(shape.squares, squares, spare):
            return _refine_shape(stresses, strains, _try_critical(stresses, strains, shape, levels), mean)
    deviation = math.sqrt(squares / len(strains))
    return StrainFit("constant", mean, mean, mean, None, None, deviation)


def _mean_strain(strains: Sequence[float]) -> MeasuredValue:
    count = len(strains)
    mean = math.fsum(strains) / count
    if count == 1:
        return MeasuredValue(mean, math.nan, 0)
    squares = math.fsum((h - mean) ** 2 for h in strains)
    return MeasuredValue(mean, math.sqrt(squares / (count - 1) / count), count - 1)


def _is_worthwhile(squares: float, constant: float, spare: int) -> bool:
    """Return whether two further terms are significant at the level of all intervals."""
    return constant > 0.0 and (squares / constant) ** (0.5 * spare) < 1.0 - LEVEL


def _try_critical(stresses: Sequence[float], strains: Sequence[float], shape: _Shape, levels: int) -> _Shape:
    """Return the shape with a critical stress, if there are enough stresses and it is significant."""
    if levels < FEWEST_CRITICAL:
        return shape
    highest = sorted(set(stresses))[-3]
    places = [highest * (k + 1) / PLACES for k in range(PLACES)]
    critical = _search_grid(stresses, strains, places)
    spare = len(strains) - 4
    if critical.squares == 0.0:
        return critical if shape.squares > 0.0 else shape
    t = math.sqrt(max(shape.squares / critical.squares - 1.0, 0.0) * spare)
    return critical if two_sided_probability(t, spare) < 1.0 - LEVEL else shape


def _search_grid(stresses: Sequence[float], strains: Sequence[float], places: Sequence[float]) -> _Shape:
    """Return the best of many values of k and σ_crit; H_min and H_sat follow by least squares."""
    ratio = MOST_RATE / LEAST_RATE
    rates = LEAST_RATE * ratio ** np.linspace(0.0, 1.0, RATES) / max(stresses)
    beyond = np.maximum(np.asarray(stresses) - np.asarray(places)[:, None], 0.0)
    shares = -np.expm1(-rates[:, None, None] * beyond)
    h = np.asarray(strains, np.float64)
    mean = shares.mean(axis=2, keepdims=True)
    off = shares - mean
    gain = (off @ h) / (off * off).sum(axis=2)
    low = h.mean() - gain * mean[..., 0]
    # without a negative H_min
    bare = (shares @ h) / (shares * shares).sum(axis=2)
    low, gain = np.where(low < 0.0, 0.0, low), np.where(low < 0.0, bare, gain)
    squares = ((low[..., None] + gain[..., None] * shares - h) ** 2).sum(axis=2)
    best = np.unravel_index(int(np.argmin(squares)), squares.shape)
    rate, place = (int(index) for index in best)
    low, gain, left = (float(column[rate, place]) for column in (low, gain, squares))
    return _Shape(low, low + gain, float(rates[rate]), float(places[place]), left)


# ---------------------------------------------------------------- refinement of the best grid point


def _refine_shape(stresses: Sequence[float], strains: Sequence[float], shape: _Shape, mean: MeasuredValue) -> StrainFit:
    """Return the fit nearest to a shape, with standard errors; the shape itself without a fit."""
    solved = None
    if shape.rate > 1.001 * LEAST_RATE / max(stresses):
        solved = _solve_shape(stresses, strains, shape)
    estimates = solved or {n: MeasuredValue(getattr(shape, n), math.nan, 0) for n in NAMES}
    values = [estimates[name].value for name in NAMES]
    pairs = zip(stresses, strains, strict=True)
    left = [saturating_strain(*values, stress=s) - h for s, h in pairs]
    low, high, rate, crit = (estimates[name] for name in NAMES)
    return StrainFit("saturating", mean, low, high, rate, crit if shape.crit else None, root_mean_square(left))


def _solve_shape(stresses: Sequence[float], strains: Sequence[float], shape: _Shape) -> dict[str, MeasuredValue] | None:
    """Return all free parameters by least squares; None without convergence in their range."""
    # zeros of the shape are fixed; the others are scaled by about their size
    units = {"low": shape.high, "high": shape.high, "rate": shape.rate, "crit": shape.crit}
    free = [name for name in NAMES if getattr(shape, name)]

    def unpack(shares: Sequence[float]) -> dict[str, float]:
        pairs = zip(free, shares, strict=True)
        return dict.fromkeys(NAMES, 0.0) | {name: units[name] * share for name, share in pairs}

    def residuals(shares: tuple[float, ...]) -> list[float]:
        numbers = unpack(shares)
        pairs = zip(stresses, strains, strict=True)
        return [(saturating_strain(*numbers.values(), stress=s) - h) / shape.high for s, h in pairs]

    try:
        fit = fit_residuals(residuals, [getattr(shape, name) / units[name] for name in free])
    except SolveError:
        return None
    numbers, top = unpack(fit.values), max(stresses)
    if numbers["low"] < 0.0:
        return _solve_shape(stresses, strains, replace(shape, low=0.0))
    inside = LEAST_RATE <= numbers["rate"] * top <= MOST_RATE
    if not (inside and numbers["low"] < numbers["high"] and 0.0 <= numbers["crit"] < top):
        return None
    pairs = zip(free, fit.estimates, strict=True)
    fitted = {name: estimate.scaled(units[name]) for name, estimate in pairs}
    return dict.fromkeys(NAMES, MeasuredValue(0.0)) | fitted
