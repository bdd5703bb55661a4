"""Common functions of waveforms: lists of edges, numbering of intervals, blending of two levels.

The times at which a signal jumps are written once, as a function of their number, and both
the list of edges and the value at a time go by that function. So an edge and the value
beside it can never disagree by a rounding error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from martensite.base.errors import ParameterError

MOST_EDGES = 5_000_000


def select_inside(times: Iterable[float], duration: float) -> list[float]:
    """Return the ascending times in (0, duration), each once [s]."""
    kept: list[float] = []
    last = 0.0
    for time in times:
        if last < time < duration:
            kept.append(time)
            last = time
    return kept


def require_countable(owner: str, edges: float, duration: float) -> None:
    """Raise `ParameterError` if a run of `duration` [s] holds more edges than can be stepped."""
    if edges > MOST_EDGES:
        raise ParameterError(
            f"Waveform `{owner}` has about {edges:.3g} edges in {duration:.6g} s, but at most "
            f"{MOST_EDGES:,} are allowed; choose a lower frequency or a shorter duration."
        )


def find_interval(time: float, guess: float, start: Callable[[int], float]) -> int:
    """Return the number k with start(k) ≤ time < start(k + 1), looked for next to a guess of it."""
    k = int(guess)
    while start(k + 1) <= time:
        k += 1
    while start(k) > time:
        k -= 1
    return k


def blend_levels(first: float, last: float, share: float) -> float:
    """Return the level at a fraction of the way from `first` to `last`, never outside the two."""
    if share <= 0.0:
        return first
    if share >= 1.0:
        return last
    low, high = min(first, last), max(first, last)
    return min(max(first + share * (last - first), low), high)


def blend_arrays(first: Any, last: Any, share: Any) -> Any:
    """`blend` over arrays: the same numbers."""
    import numpy as np

    low, high = np.minimum(first, last), np.maximum(first, last)
    inner = np.clip(first + share * (last - first), low, high)
    return np.select([share <= 0.0, share >= 1.0], [first, last], inner)


def require_order(owner: str, low: float, high: float) -> None:
    """Raise `ParameterError` if the lower level of an oscillation is above the higher one."""
    if low > high:
        raise ParameterError(
            f"Parameter `low` of `{owner}` must be at most `high`, but low = {low:.6g} and high = {high:.6g}."
        )
