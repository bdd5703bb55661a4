"""Straight lines of strain over temperature, and the preparation of their rows.

Rows are sorted by temperature, one per temperature. Lines are least squares without outliers. Three consecutive lines
have the least sum of squares of all divisions in three. A running median removes single spikes, and isotonic regression
(pool adjacent violators) removes disorder. Both methods have no width to choose and keep monotone values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

MOST_ROWS = 2000
"""Largest number of rows; a longer branch is averaged in cells of equal temperature width."""
FEWEST = 3
"""Least number of rows of a line."""
OUTLYING = 3.5
"""Robust standard deviations beyond which a row is an outlier."""
MANY = 10
"""Number of rows from which outliers are removed."""
EXACT = 1e-12
"""Largest strain deviation of a row on a line [-]."""
_DEVIATION = 1.4826
"""Standard deviation over the median of the magnitudes, of normal noise."""


@dataclass(frozen=True)
class StraightLine:
    """Straight line of strain over temperature, with its range of rows."""

    at: float
    """Mean temperature of its rows [K]."""
    level: float
    """Strain there [-]."""
    slope: float
    """[1/K]"""
    span: tuple[float, float]
    """Lowest and highest temperature of its rows [K]."""
    rows: int
    scatter: float
    """Standard deviation of the rows about the line [-]."""

    def value(self, temperature: Any) -> Any:
        """Return the strain [-] at a temperature [K], or at an array of them."""
        return self.level + self.slope * (temperature - self.at)

    def meets(self, other: StraightLine) -> float:
        """Return the temperature [K] at the intersection with another line; infinite for a parallel."""
        steeper = self.slope - other.slope
        return self.at + (other.value(self.at) - self.level) / steeper if steeper else math.inf

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers by name, for JSON."""
        return {
            "temperature": self.at,
            "strain": self.level,
            "slope": self.slope,
            "span": list(self.span),
            "rows": self.rows,
            "scatter": self.scatter,
        }


def fit_line(temperatures: Any, strains: Any, rows: slice = slice(None)) -> StraightLine:
    """Return the least-squares line through some rows; with ten or more, without outliers."""
    kelvin, strain = temperatures[rows], strains[rows]
    inliers = np.ones(kelvin.size, dtype=bool)
    while True:
        at, level = float(kelvin[inliers].mean()), float(strain[inliers].mean())
        off = kelvin[inliers] - at
        slope = float(off @ strain[inliers] / (off @ off))
        left = np.abs(strain - level - slope * (kelvin - at))
        robust = OUTLYING * _DEVIATION * float(np.median(left[inliers]))
        near = inliers & (left <= max(robust, EXACT))
        if kelvin.size < MANY or near.all() or near.sum() in (inliers.sum(), *range(MANY)):
            break
        inliers = near
    scatter = math.sqrt(float(np.mean(left[inliers] ** 2)))
    span = float(kelvin[inliers][0]), float(kelvin[inliers][-1])
    return StraightLine(at, level, slope, span, int(inliers.sum()), scatter)


def fit_three_lines(kelvin: Any, strain: Any) -> tuple[StraightLine, StraightLine, StraightLine]:
    """Return the three consecutive lines with the least sum of squares.

    There must be three times `FEWEST` rows, in the order of temperature.
    """
    x, y = kelvin - kelvin.mean(), strain - strain.mean()
    columns = (np.ones_like(x), x, y, x * x, x * y, y * y)
    sums = [np.concatenate([[0.0], np.cumsum(c)]) for c in columns]
    # of the rows from i up to, but without, j at [i, j]
    n, sx, sy, sxx, sxy, syy = (s[None, :] - s[:, None] for s in sums)
    enough = n >= FEWEST
    n = np.where(enough, n, 1.0)
    spread = np.where(enough, sxx - sx * sx / n, 1.0)
    left = syy - sy * sy / n - (sxy - sx * sy / n) ** 2 / spread
    left = np.where(enough, left, np.inf)
    total = left[0][:, None] + left + left[:, -1][None, :]
    first, second = np.unravel_index(int(np.argmin(total)), total.shape)
    pieces = slice(None, first), slice(first, second), slice(second, None)
    cold, steep, hot = (fit_line(kelvin, strain, piece) for piece in pieces)
    return cold, steep, hot


# ---------------------------------------------------------------- preparation of rows


def sort_by_temperature(temperatures: Any, strains: Any) -> tuple[Any, Any]:
    """Return the rows in the order of temperature, one per temperature, at most `MOST_ROWS`."""
    kelvin, place = np.unique(np.asarray(temperatures, np.float64), return_inverse=True)
    strain = np.bincount(place, np.asarray(strains, np.float64)) / np.bincount(place)
    return average_cells(kelvin, strain, MOST_ROWS) if kelvin.size > MOST_ROWS else (kelvin, strain)


def average_cells(kelvin: Any, strain: Any, cells: int) -> tuple[Any, Any]:
    """Return means over cells of equal width, which keep straight lines straight."""
    place = ((kelvin - kelvin[0]) / (kelvin[-1] - kelvin[0]) * cells).astype(int)
    place = np.minimum(place, cells - 1)
    count = np.bincount(place, minlength=cells)
    filled = count > 0
    means = (np.bincount(place, c, cells)[filled] / count[filled] for c in (kelvin, strain))
    return next(means), next(means)


def smooth_median(values: Any) -> Any:
    """Return the running median of five, with repeated values beyond the ends."""
    padded = np.pad(values, 2, mode="edge")
    return np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)


def fit_isotonic(values: Any) -> Any:
    """Return the nearest non-decreasing values in least squares (isotonic regression)."""
    from scipy.optimize import isotonic_regression

    return isotonic_regression(values).x
