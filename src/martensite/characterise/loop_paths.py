"""Path of a loop: turning points, cycles, and scatter of its drive column.

A rate-independent law depends on the path of the drive alone, above all on its turning points. Jitter in this column
causes spurious loops. Each leg between turning points is therefore smoothed by local parabolas. Generalised
cross-validation chooses their width (Craven and Wahba (1979), Numerische Mathematik 31).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

PARTIAL = 0.1
"""Least fraction of the range spanned by a leg."""
CLEAR = 8.0
"""Least span of a leg, in standard deviations of the scatter."""
FULL = 0.8
"""Fraction of the range spanned by each leg of a full cycle."""
EXACT = 2e-4
"""Scatter over range below which a column is not smoothed."""
HALVES = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
"""Tried half-widths of the windows [rows]."""
PARABOLA = 2.25
"""Variance in the middle of a local parabola, times the rows of its window, over the variance of a row."""
NORMAL = 1.4826
"""Standard deviation of a normal distribution divided by its median absolute deviation."""


@dataclass(frozen=True)
class LoopPath:
    """Smoothed drive column of a loop, with its legs."""

    drive: Any
    """(rows,), smoothed along each leg with scatter."""
    turns: tuple[int, ...]
    """Rows at which the drive turns, with the first and the last row."""
    scatter: float
    """Standard deviation of the removed jitter [unit of the drive]; 0 without smoothing."""
    window: int
    """Rows of the narrowest window; 0 without smoothing."""

    @property
    def error(self) -> float:
        """Return the standard error of the smoothed drive in the narrowest window [unit of the drive]."""
        return self.scatter * math.sqrt(PARABOLA / self.window) if self.window else 0.0

    @property
    def legs(self) -> list[tuple[int, int]]:
        """Return the first and the last row of each leg."""
        return list(pairwise(self.turns))

    @property
    def is_repeated(self) -> bool:
        """Return whether all legs but the first and the last span the whole range."""
        spans = [abs(self.drive[b] - self.drive[a]) for a, b in self.legs]
        return min(spans[1:-1] or spans) >= FULL * float(np.ptp(self.drive))

    @property
    def cycles(self) -> list[tuple[int, int]]:
        """Return the first and the last row of each pair of legs, counted from the last one."""
        rows = self.turns[(len(self.turns) - 1) % 2 :: 2]
        return list(pairwise(rows))


def trace_loop(drive: Any) -> LoopPath:
    """Return the path of a drive column of a loop, (rows,), without missing samples."""
    x = np.asarray(drive, float)
    span, scatter = float(np.ptp(x)), estimate_scatter(x)
    inner = find_turns(x.tolist(), max(PARTIAL * span, CLEAR * scatter))
    turns = tuple(dict.fromkeys([0, *inner[1:-1], len(x) - 1]))
    if scatter <= EXACT * span:
        return LoopPath(x, turns, 0.0, 0)
    smooth, wide = smooth_legs(x, turns)
    return LoopPath(smooth, turns, scatter if wide else 0.0, wide)


def find_turns(values: Sequence[float], least: float) -> list[int]:
    """Return the rows at which a column turns by at least an amount, with both ends of these legs."""
    turns: list[int] = []
    rising: bool | None = None
    low = high = 0
    for row, value in enumerate(values):
        low = row if value < values[low] else low
        high = row if value > values[high] else high
        if not rising and value - values[low] >= least:
            turns.append(low)
            rising, high = True, row
        elif rising is not False and values[high] - value >= least:
            turns.append(high)
            rising, low = False, row
    return [*turns, high if rising else low] if turns else []


def estimate_scatter(values: Any) -> float:
    """Return the standard deviation of white scatter in a smooth column, by its second differences."""
    bends = np.diff(np.asarray(values, float), 2)
    return NORMAL * float(np.median(np.abs(bends))) / math.sqrt(6.0) if bends.size else 0.0


def smooth_legs(values: Any, turns: Sequence[int]) -> tuple[Any, int]:
    """Return a column smoothed leg by leg, and the rows of the narrowest window."""
    total, count, windows = np.zeros(len(values)), np.zeros(len(values)), list[int]()
    for first, last in pairwise(turns):
        smooth, wide = smooth_rows(values[first : last + 1])
        total[first : last + 1] += smooth
        count[first : last + 1] += 1.0
        windows.append(wide)
    return total / count, min(windows)


def smooth_rows(values: Any) -> tuple[Any, int]:
    """Return local parabolas through some rows with the window of least generalised cross-validation, and its rows."""
    best_trial = min(_try_windows(values), key=lambda one: one[0], default=(0.0, values, 0))
    return best_trial[1], best_trial[2]


def _try_windows(values: Any) -> Iterator[tuple[float, Any, int]]:
    for half in HALVES:
        wide = 2 * half + 1
        if wide > len(values):
            return
        powers = np.linspace(-1.0, 1.0, wide)[:, None] ** np.arange(3)
        hat = powers @ np.linalg.pinv(powers)
        smooth = np.concatenate(
            [hat[:half] @ values[:wide], np.convolve(values, hat[half], "valid"), hat[half + 1 :] @ values[-wide:]]
        )
        levers = (2.0 * hat.diagonal()[:half].sum() + (len(values) - 2 * half) * hat[half, half]) / len(values)
        yield float(np.mean((smooth - values) ** 2)) / (1.0 - levers) ** 2, smooth, wide


def measure_arc(path: LoopPath, values: Any) -> Any:
    """Return the path length to each row, (rows,), in the plane of drive and a measured column.

    Both are divided by their range; the scatter of the measured column adds no length.
    """
    y = np.asarray(values, float)
    y = smooth_legs(y, path.turns)[0] if estimate_scatter(y) > EXACT * float(np.ptp(y)) else y
    steps = [np.diff(one) / (float(np.ptp(one)) or 1.0) for one in (path.drive, y)]
    return np.concatenate([[0.0], np.cumsum(np.hypot(*steps))])
