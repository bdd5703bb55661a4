"""Edges, numbered intervals, and interpolation between two levels.

Edges and values use the same function of the interval number, so rounding never makes them disagree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from martensite.base.errors import ParameterError

MOST_EDGES = 5_000_000


def select_inside(times: Iterable[float], duration: float) -> list[float]:
    """Return the ascending times in (0, duration) [s] without repetition."""
    selected = [0.0]
    for time in times:
        if selected[-1] < time < duration:
            selected.append(time)
    return selected[1:]


def require_countable(owner: str, edges: float, duration: float) -> None:
    """Raise `ParameterError` if a run of `duration` [s] has too many edges."""
    if edges > MOST_EDGES:
        raise ParameterError(
            f"Waveform `{owner}` has about {edges:.3g} edges in {duration:.6g} s, but at most "
            f"{MOST_EDGES:,} are allowed; choose a lower frequency or a shorter duration."
        )


def find_interval(time: float, guess: float, start: Callable[[int], float]) -> int:
    """Return the k with start(k) ≤ time < start(k + 1), searched from a guess."""
    k = int(guess)
    while start(k + 1) <= time:
        k += 1
    while start(k) > time:
        k -= 1
    return k


def blend_levels(first: float, last: float, share: float) -> float:
    """Interpolate from `first` to `last` at a fraction, limited to this range."""
    if share <= 0.0:
        return first
    if share >= 1.0:
        return last
    low, high = min(first, last), max(first, last)
    return min(max(first + share * (last - first), low), high)


def blend_arrays(first: Any, last: Any, share: Any) -> Any:
    """Return `blend_levels` of arrays."""
    import numpy as np

    low, high = np.minimum(first, last), np.maximum(first, last)
    inner = np.clip(first + share * (last - first), low, high)
    return np.select([share <= 0.0, share >= 1.0], [first, last], inner)


def require_order(owner: str, low: float, high: float) -> None:
    """Raise `ParameterError` if `low` is above `high`."""
    if low > high:
        raise ParameterError(
            f"Parameter `low` of `{owner}` must be at most `high`, but low = {low:.6g} and high = {high:.6g}."
        )
