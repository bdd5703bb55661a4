"""Coordinate (compass) search: a slow but simple minimum without derivatives.

From the best point so far every parameter in turn is tried one step up, then one step down, and
the first improvement is kept. After a round with an improvement the step doubles, after one
without it halves; the search has stalled when the step is below `stop`. Steps are shares of the
search ranges, and points beyond a bound are moved onto it. Convergence to a stationary point:
Kolda, Lewis and Torczon (2003), SIAM Review 45; in a narrow valley across the axes the steps
become short and the search stalls before the minimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from martensite.base.errors import ParameterError

Cost = Callable[[tuple[float, ...]], float]
"""Cost of a point; infinite or NaN where a run fails."""
Progress = Callable[[tuple[float, ...], float, int], None]
"""Called after every evaluation with the best point, its cost and the number of evaluations."""
STEP, STOP, CAP = 0.1, 1e-3, 3000
LONGEST = 0.5
"""Step beyond which it does not double."""


@dataclass(frozen=True)
class CoordinateSearch:
    """Where a coordinate search has arrived."""

    values: tuple[float, ...]
    cost: float
    evaluations: int
    history: tuple[tuple[int, float], ...]
    """(evaluations, cost) at each improvement, and at the end."""
    reason: Literal["stalled", "cap", "interrupted"]
    """Why it stopped: steps below `stop`, as many evaluations as allowed, or by the user."""
    step: float
    """Last step, as a share of the ranges."""

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


def coordinate_search(
    cost: Cost,
    start: Sequence[float],
    low: Sequence[float],
    high: Sequence[float],
    *,
    step: float = STEP,
    stop: float = STOP,
    cap: int = CAP,
    progress: Progress | None = None,
) -> CoordinateSearch:
    """Search for the least cost within bounds.

    A KeyboardInterrupt, from the keyboard or from `progress`, ends the search and keeps the best.

    Args:
        cost: to be made small.
        start: first point, within the bounds.
        low: lower bounds.
        high: upper bounds.
        step: first step, as a share of each range.
        stop: step below which the search has stalled.
        cap: number of evaluations at most.
        progress: called after every evaluation.

    Raises:
        ParameterError: bounds are not in order, the start not within them, or steps not above 0.
    """
    _check(start, low, high, step, stop, cap)
    bottom, top, first = (tuple(map(float, row)) for row in (low, high, start))
    search = _Search(cost, bottom, top, stop, cap, progress, first, step)
    reason: Literal["stalled", "cap", "interrupted"]
    try:
        reason = search.run()
    except KeyboardInterrupt:
        reason = "interrupted"
    history = [*search.history, (search.evaluations, search.cost)]
    return CoordinateSearch(
        search.best, search.cost, search.evaluations, tuple(dict.fromkeys(history)), reason,
        search.step,
    )  # fmt: skip


@dataclass
class _Search:
    function: Cost
    low: tuple[float, ...]
    high: tuple[float, ...]
    stop: float
    cap: int
    progress: Progress | None
    best: tuple[float, ...]
    step: float
    cost: float = math.inf
    evaluations: int = 0
    history: list[tuple[int, float]] = field(default_factory=list[tuple[int, float]])

    def run(self) -> Literal["stalled", "cap"]:
        """Rounds over all parameters until the steps are short."""
        self._better(self.best)
        while self.step >= self.stop:
            improved = [self._moved(place) for place in range(len(self.best))]
            if self.evaluations >= self.cap:
                return "cap"
            self.step = min(2.0 * self.step, LONGEST) if any(improved) else 0.5 * self.step
        return "stalled"

    def _moved(self, place: int) -> bool:
        """Whether a step up or down along one axis was an improvement."""
        size = self.step * (self.high[place] - self.low[place])
        at = self.best[place]
        for moved in (min(at + size, self.high[place]), max(at - size, self.low[place])):
            if self.evaluations >= self.cap:
                return False
            point = (*self.best[:place], moved, *self.best[place + 1 :])
            if moved != at and self._better(point):
                return True
        return False

    def _better(self, point: tuple[float, ...]) -> bool:
        """Evaluate a point and keep it if it is the best."""
        value = self.function(point)
        self.evaluations += 1
        if better := value < self.cost:
            self.best, self.cost = point, value
            self.history.append((self.evaluations, value))
        if self.progress is not None:
            self.progress(self.best, self.cost, self.evaluations)
        return better


def _check(
    start: Sequence[float],
    low: Sequence[float],
    high: Sequence[float],
    step: float,
    stop: float,
    cap: int,
) -> None:
    if not 0 < len(start) == len(low) == len(high):
        raise ParameterError(
            "Start and bounds must be equally many, at least one, but are "
            f"{len(start)}, {len(low)} and {len(high)}."
        )
    for at, least, most in zip(start, low, high, strict=True):
        if not (least < most and least <= at <= most):
            raise ParameterError(
                f"A search must start within its bounds, but {at:g} is not within "
                f"{least:g} to {most:g}."
            )
    if not 0.0 < stop <= step or cap < 1:
        raise ParameterError(
            f"Steps must be above 0 and evaluations allowed, but `step` is {step:g}, "
            f"`stop` {stop:g}, `cap` {cap}."
        )
