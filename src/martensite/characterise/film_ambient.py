"""Film coefficients fitted together with the ambient temperature, and their sensitivity to it.

Each point has a temperature θ and a flux q = h (θ - a). If h is a polynomial of degree n in θ
and the ambient a is free, then

    q = (h₀ + … + h_n θⁿ)(θ - a) = c₀ + c₁ θ + … + c_{n+1} θ^{n+1}

is a polynomial of degree n + 1 with leading coefficient h_n and a zero at θ = a. The joint fit of h and a is thus
linear least squares. The confidence region of a contains every a at which the fitted q could be zero (Fieller's
argument),

    c(a)² ≤ t² vᵀ C v,    v = (1, a, a², …),    C the covariance of c,

and its ends are roots of a polynomial. Of several parts, the part about the best a is used. The region is unbounded if
the interval of h_n includes zero. Temperatures have noise of one size; fluxes are exact.

For a given ambient, h moves with it by dh/da = h/(θ - a), most at the coldest point. A slope of h over θ and a shift of
a therefore compensate in part. The sensitivities of q to the level of h, to its slope and to a give the confounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL, Interval, student_quantile
from martensite.characterise.film_coefficient import ABSOLUTE_ZERO, FORMS, FilmFit, FilmPoints, fit_film_points
from martensite.characterise.regression import LinearFit, fit_noisy_abscissae


@dataclass(frozen=True)
class FreeAmbient:
    """Film coefficient of a given degree, fitted together with the ambient temperature."""

    degree: int
    """Degree of h in the temperature."""
    flux: LinearFit
    """Fitted flux [W/m²], of degree `degree` + 1."""
    coldest: float
    """Coldest point [°C]: the ambient lies below."""

    @property
    def leading(self) -> float:
        """Return the highest coefficient of h: h₀, h₁ or h₂."""
        return self.flux.values[-1]

    def leading_interval(self, level: float = LEVEL) -> Interval:
        """Return the confidence interval of the highest coefficient of h."""
        return self.flux.interval(self.degree + 1, level)

    @property
    def ambient(self) -> float:
        """Return the ambient temperature [°C] of the best fit; NaN if the flux has no zero below the points."""
        below = [root for root in _real_roots(np.roots(self.flux.values[::-1])) if root < self.coldest]
        return max(below, default=math.nan)

    def ambient_interval(self, level: float = LEVEL) -> Interval:
        """Return the confidence interval of the ambient [°C], cut off at the coldest point and at 0 K."""
        from numpy.polynomial import Polynomial

        if not self.flux.freedom:
            return ABSOLUTE_ZERO, self.coldest
        c, covariance = np.asarray(self.flux.values), np.asarray(self.flux.covariance)
        # coefficients of vᵀ C v as a polynomial in a are sums over antidiagonals
        spread = [np.trace(covariance[:, ::-1], k) for k in range(len(c) - 1, -len(c), -1)]
        allowed = student_quantile(level, self.flux.freedom) ** 2 * np.asarray(spread)
        outside = Polynomial(np.convolve(c, c) - allowed)
        edges = [e for e in _real_roots(outside.roots()) if ABSOLUTE_ZERO < e < self.coldest]
        ends = sorted({ABSOLUTE_ZERO, self.coldest, *edges})
        parts = [(a, b) for a, b in pairwise(ends) if outside(0.5 * (a + b)) <= 0.0]
        return self._choose_part(_join_intervals(parts))

    def _choose_part(self, parts: list[Interval]) -> Interval:
        """Return the part with the best ambient; the union of all parts without a best ambient."""
        best_parts = [part for part in parts if part[0] <= self.ambient <= part[1]] or parts
        return (best_parts[0][0], best_parts[-1][1]) if best_parts else (math.nan, math.nan)

    def is_bounded(self, level: float = LEVEL) -> bool:
        """Return whether there is a best ambient with a complete interval."""
        low, high = self.ambient_interval(level)
        return math.isfinite(self.ambient) and ABSOLUTE_ZERO < low and high < self.coldest

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        return {
            "degree": self.degree,
            "leading": self.leading,
            "leading_interval": list(self.leading_interval(level)),
            "ambient_degC": self.ambient,
            "ambient_interval_degC": list(self.ambient_interval(level)),
            "bounded": self.is_bounded(level),
        }


def fit_free_ambient(points: FilmPoints, degree: int) -> FreeAmbient | None:
    """Fit h of a given degree together with the ambient; None for too few points."""
    if len(set(points.temperatures_degC)) < degree + 2:
        return None
    powers = tuple(range(degree + 2))
    flux = fit_noisy_abscissae(points.temperatures_degC, points.fluxes, powers)
    return FreeAmbient(degree, flux, min(points.temperatures_degC))


def _join_intervals(parts: list[Interval]) -> list[Interval]:
    """Merge touching intervals."""
    joined: list[Interval] = []
    for low, high in parts:
        if joined and joined[-1][1] == low:
            joined[-1] = joined[-1][0], high
        else:
            joined.append((low, high))
    return joined


def _real_roots(roots: Any) -> list[float]:
    """Return the real roots."""
    return [float(r.real) for r in roots if abs(r.imag) <= 1e-9 * max(abs(r), 1.0)]


AMBIENT_SHIFT = 1e-3
"""Shift of the ambient [K] of a derivative."""
SHIFTS = (-2.5, -1.0, 0.0, 1.0, 2.5)
"""Differences of the tried ambient temperatures from the given one [K]."""


@dataclass(frozen=True)
class AtAmbient:
    """Points and their straight line for another ambient."""

    points: FilmPoints
    line: FilmFit

    @property
    def mean(self) -> float:
        """Return the mean film coefficient [W/(m² K)]."""
        return sum(self.points.h) / len(self.points)

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        return self.points.to_dict() | {"mean": self.mean, "linear": self.line.to_dict(level)}


def shift_ambients(points: FilmPoints, shifts: tuple[float, ...] = SHIFTS) -> list[AtAmbient]:
    """Return the points and their lines at ambient temperatures that differ by `shifts` [K].

    Ambient temperatures that are not below the coldest point are omitted.
    """
    coldest = min(points.temperatures_degC)
    ambients = [points.ambient + shift for shift in shifts]
    moved = [points.at_ambient(a) for a in ambients if ABSOLUTE_ZERO <= a < coldest]
    return [AtAmbient(p, fit_film_points(p, FORMS["linear"])) for p in moved]


def film_per_kelvin(points: FilmPoints) -> tuple[float, ...]:
    """Return dh/dT_a = h/(T - T_a) of every point [W/(m² K²)]."""
    pairs = zip(points.temperatures_degC, points.h, strict=True)
    return tuple(h / (at - points.ambient) for at, h in pairs)


def slope_per_kelvin(points: FilmPoints) -> float:
    """Return the derivative of the slope of h(T) with respect to the ambient [W/(m² K³)]."""
    low, high = (_fit_slope(points, points.ambient + shift) for shift in (-AMBIENT_SHIFT, AMBIENT_SHIFT))
    return (high - low) / (2.0 * AMBIENT_SHIFT)


def _fit_slope(points: FilmPoints, ambient: float) -> float:
    """Return the slope of the straight line through h at another ambient [°C]."""
    return fit_noisy_abscissae(points.temperatures_degC, points.fluxes, FORMS["linear"], ambient).values[1]


def find_level_ambient(points: FilmPoints) -> float:
    """Return the ambient temperature [°C] at which the straight line through h is level; NaN if none."""
    from scipy.optimize import root_scalar

    coldest = min(points.temperatures_degC)

    slope = partial(_fit_slope, points)
    low, high = ABSOLUTE_ZERO, coldest - 1e-6
    if slope(low) <= 0.0 or slope(high) >= 0.0:
        return math.nan
    return root_scalar(slope, bracket=(low, high), xtol=1e-12).root


@dataclass(frozen=True)
class Confounding:
    """Confounding of the ambient, the level and the slope of h at the points."""

    correlation: float
    """Correlation of the estimates of slope and ambient; ±1 if they cannot be separated."""
    condition: float
    """Condition number of the scaled sensitivities; 1 if they are independent."""


def find_confounding(points: FilmPoints) -> Confounding:
    """Compute the sensitivities of the flux to level and slope of h and to the ambient, at the fitted line."""
    at = np.asarray(points.temperatures_degC)
    line = fit_film_points(points, FORMS["linear"])
    over = at - points.ambient
    film = np.asarray([line.film(float(t)) for t in at])
    columns = np.stack([over, (at - at.mean()) * over, -film], axis=1)
    columns /= np.linalg.norm(columns, axis=0)
    sizes = np.linalg.svd(columns, compute_uv=False)
    if len(at) < 3 or sizes[-1] <= np.finfo(float).eps * sizes[0]:
        return Confounding(math.nan, math.inf)
    covariance = np.linalg.inv(columns.T @ columns)
    both = covariance[1, 2] / math.sqrt(covariance[1, 1] * covariance[2, 2])
    return Confounding(float(both), float(sizes[0] / sizes[-1]))
