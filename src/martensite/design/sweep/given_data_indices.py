"""Sensitivity indices from any sample.

    first       variance of the means of classes of a parameter, over the variance
    delta       mean shift of the distribution of the measure for a known parameter, from 0 to 1; needs no variance
                (Borgonovo (2007), Reliab. Eng. Syst. Saf. 92)
    slope, rank slope
                standardised regression coefficients of the parameters, and of their ranks, with a sign
                (Saltelli et al. (2008), Global Sensitivity Analysis, ch. 1)

Classes have equally many runs, as in SALib. Delta is equation 26 of Plischke, Borgonovo and Smith (2013), Eur. J. Oper.
Res. 226, with Gaussian kernels of Silverman's width. Delta and first order have 95 % intervals and a reduced bias by
bootstrap (equation 30 there). Few runs give few classes, and first orders that are too small for a measure that rises
and falls. Slopes show linear or monotonic effects only.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.float64]
MOST_DELTA, MOST_FIRST = 1000, 20_000
"""Largest numbers of runs for an index, drawn at random."""
DRAWS = 24
"""Bootstrap samples."""
GRID = 100
NORMAL_95 = 1.959963984540054
SAME_SPREAD = 1e-12
"""Relative spread below which values are equal."""
LINEAR = 0.7
"""Explained fraction of the variance below which a regression gets a remark."""


@dataclass(frozen=True, eq=False)
class SensitivityIndex:
    """Sensitivity index of each axis."""

    values: Numbers
    wide: Numbers
    """Half the 95 % interval; NaN if unknown."""

    @classmethod
    def unknown(cls, width: int) -> SensitivityIndex:
        """Return undefined indices, for a constant measure."""
        return cls(np.full(width, np.nan), np.full(width, np.nan))

    def words(self, place: int) -> str:
        """Return an index with half its interval as text."""
        value, wide = float(self.values[place]), float(self.wide[place])
        number = "none" if math.isnan(value) else f"{value:.3f}"
        return number if math.isnan(wide) else f"{number} ± {wide:.3f}"


def is_spread(values: Numbers) -> bool:
    """Return true if values differ by more than rounding errors."""
    return bool(np.ptp(values) > SAME_SPREAD * np.max(np.abs(values), initial=0.0))


def estimate_indices(x: Numbers, y: Numbers, seed: int = 0) -> tuple[dict[str, SensitivityIndex], list[str]]:
    """Return the indices of a measure (runs,) over parameters (runs, axes), and sentences on them."""
    width = x.shape[1]
    names = ("delta", "first", "rank slope", "slope")
    if not is_spread(y):
        return {name: SensitivityIndex.unknown(width) for name in names}, []
    rng = np.random.default_rng(seed)
    x, y = _shuffle_runs(x, y, rng)
    rank_slope, monotonic = fit_slopes(rank_columns(x), rank_columns(y))
    slope, linear = fit_slopes(x, y)
    indices = {
        "delta": _estimate_axes(estimate_delta, x[:MOST_DELTA], y[:MOST_DELTA], rng),
        "first": _estimate_axes(estimate_first_order, x[:MOST_FIRST], y[:MOST_FIRST], rng),
        "rank slope": rank_slope,
        "slope": slope,
    }
    share = max(monotonic, linear)
    if share >= LINEAR:
        return indices, []
    return indices, [f"Slopes explain {100.0 * share:.0f} % of the variance: do not judge by them alone."]


def _shuffle_runs(x: Numbers, y: Numbers, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
    """Return the runs in random order, which distributes equal values over classes."""
    order = rng.permutation(len(y))
    return x[order], y[order]


def _estimate_axes(
    estimate: Callable[[Numbers, Numbers], float], x: Numbers, y: Numbers, rng: np.random.Generator
) -> SensitivityIndex:
    """Return a bias-reduced index of every axis, with half its interval."""
    rows: list[tuple[float, float]] = []
    for one in x.T:
        if not is_spread(one):
            rows.append((math.nan, math.nan))
            continue
        draws = (rng.integers(len(y), size=len(y)) for _ in range(DRAWS))
        estimates = np.array([estimate(one[runs], y[runs]) for runs in draws])
        value = 2.0 * estimate(one, y) - float(np.mean(estimates))
        rows.append((value, NORMAL_95 * float(np.std(estimates, ddof=1))))
    return SensitivityIndex(*np.array(rows).T)


def estimate_first_order(x: Numbers, y: Numbers) -> float:
    """Return the variance of the means of classes of x, over the variance of y."""
    if not is_spread(y):
        return 0.0
    means = ((float(np.mean(part)), len(part)) for part in _split_classes(x, y))
    middle = float(np.mean(y))
    return sum(n * (mean - middle) ** 2 for mean, n in means) / (len(y) * float(np.var(y)))


def estimate_delta(x: Numbers, y: Numbers) -> float:
    """Return the mean of half the area between the densities of y and of its classes."""
    if not is_spread(y):
        return 0.0
    grid = np.linspace(float(np.min(y)), float(np.max(y)), GRID)
    whole = _estimate_density(y, grid)

    def area(part: Numbers) -> float:
        if not is_spread(part):  # a peak without width, of which there may be one in the whole
            return 2.0 * float(np.mean(y != part[0]))
        return float(np.trapezoid(np.abs(whole - _estimate_density(part, grid)), grid))

    return sum(len(part) * area(part) for part in _split_classes(x, y)) / (2 * len(y))


def _estimate_density(y: Numbers, grid: Numbers) -> Numbers:
    wide = float(np.std(y, ddof=1)) * (0.75 * len(y)) ** -0.2
    kernels = np.exp(-0.5 * ((grid - y[:, None]) / wide) ** 2)
    return np.mean(kernels, axis=0) / (wide * math.sqrt(2.0 * math.pi))


def _split_classes(x: Numbers, y: Numbers) -> list[Numbers]:
    """Return y in classes of x of equal size, as SALib does."""
    count = len(y)
    power = 2.0 / (7.0 + math.tanh((1500.0 - count) / 500.0))
    ends = np.linspace(0.0, count, round(min(math.ceil(count**power), 48)) + 1)
    return np.split(y[np.argsort(x, kind="stable")], ends[1:-1].astype(int))


# ---------------------------------------------------------------- regression


def rank_columns(values: Numbers) -> Numbers:
    """Return the ranks in every column; equal values have their mean rank."""
    return import_module("scipy.stats").rankdata(values, axis=0)


def fit_slopes(x: Numbers, y: Numbers) -> tuple[SensitivityIndex, float]:
    """Return the standardised regression coefficients of y on x (runs, axes), and the explained variance."""
    wide = np.std(x, axis=0)
    a = (x - np.mean(x, axis=0)) / np.where(wide > 0.0, wide, 1.0)
    b = (y - np.mean(y)) / np.std(y)
    slopes = np.linalg.lstsq(a, b, rcond=None)[0]
    rest = b - a @ slopes
    share = 1.0 - float(rest @ rest) / len(b)
    free = max(len(b) - len(slopes) - 1, 1)
    errors = np.sqrt(np.diag(np.linalg.pinv(a.T @ a)) * float(rest @ rest) / free)
    return SensitivityIndex(slopes, NORMAL_95 * errors), share
