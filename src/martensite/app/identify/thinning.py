"""Curves with fewer points: every so many rows, or those that keep the shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

MOST_CORNERS = 400
"""Points that are drawn of a curve."""


def find_envelope(numbers: Sequence[float], most: int = MOST_CORNERS) -> list[int]:
    """Rows of a long column that keep its lows and highs."""
    import numpy as np

    count = len(numbers)
    if count <= most:
        return list(range(count))
    values = np.asarray(numbers, float)
    rows = {0, count - 1}
    for part in np.array_split(np.arange(count), most // 2):
        seen = part[np.isfinite(values[part])]
        if len(seen):
            rows |= {int(seen[values[seen].argmin()]), int(seen[values[seen].argmax()])}
    return sorted(rows)


def find_corners(times: Sequence[float], values: Sequence[float], most: int = 150) -> list[int]:
    """Rows between which straight lines come nearest to a curve (Douglas and Peucker, 1973).

    The row that is farthest from the lines so far is added until `most` are kept, or all others
    are nearer than a thousandth of the range.
    """
    import numpy as np

    t, y = np.asarray(times, float), np.asarray(values, float)
    near = 1e-3 * float(np.ptp(y)) or 1.0
    chosen, pieces = {0, len(t) - 1}, [_find_farthest(t, y, 0, len(t) - 1)]
    while pieces and len(chosen) < most:
        pieces.sort(key=lambda piece: piece[0])
        distance, row, first, last = pieces.pop()
        if distance <= near:
            break
        chosen.add(row)
        pieces += [_find_farthest(t, y, a, b) for a, b in ((first, row), (row, last)) if b - a > 1]
    return sorted(chosen)


def _find_farthest(t: Any, y: Any, first: int, last: int) -> tuple[float, int, int, int]:
    """Distance and row of what is farthest from the line between two rows."""
    import numpy as np

    inside = slice(first, last + 1)
    line = np.interp(t[inside], [t[first], t[last]], [y[first], y[last]])
    apart = np.abs(y[inside] - line)
    return float(apart.max()), first + int(apart.argmax()), first, last
