"""Coordinate (compass) search: a slow but simple minimisation without derivatives.

Each parameter in turn moves one step up, then one step down from the best point, and the first improvement is kept. The
step doubles after a round with an improvement, and halves otherwise. The search ends when the step is below `stop`.
Parameters and steps are fractions of the search ranges; points beyond a bound are moved onto it. Convergence to a
stationary point: Kolda, Lewis and Torczon (2003), SIAM Review 45. In a narrow oblique valley the search stalls before
the minimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from martensite.base.errors import ParameterError

Cost = Callable[[tuple[float, ...]], float]
"""Cost of a point; infinite or NaN for a failed run."""
LONGEST = 0.5
"""Largest step that can double."""


@dataclass
class CoordinateSearch:
    """Search with its best point."""

    function: Cost
    best: tuple[float, ...]
    step: float
    """Last step, as a fraction of the ranges."""
    stop: float
    limit: int
    cost: float = math.inf
    evaluations: int = 0

    def run(self) -> Literal["stalled", "cap"]:
        """Run rounds over all parameters until the steps are short, or the limit of evaluations is reached."""
        self._improves(self.best)
        while self.step >= self.stop:
            improved = [self._advance(place) for place in range(len(self.best))]
            if self.evaluations >= self.limit:
                return "cap"
            self.step = min(2.0 * self.step, LONGEST) if any(improved) else 0.5 * self.step
        return "stalled"

    def _advance(self, place: int) -> bool:
        """Return whether a step up or down along one axis was an improvement."""
        at = self.best[place]
        for moved in (min(at + self.step, 1.0), max(at - self.step, 0.0)):
            if self.evaluations >= self.limit:
                return False
            point = (*self.best[:place], moved, *self.best[place + 1 :])
            if moved != at and self._improves(point):
                return True
        return False

    def _improves(self, point: tuple[float, ...]) -> bool:
        """Evaluate a point and keep it if it is the best."""
        value = self.function(point)
        self.evaluations += 1
        if better := value < self.cost:
            self.best, self.cost = point, value
        return better


def search_coordinates(
    cost: Cost, start: Sequence[float], *, step: float = 0.1, stop: float = 1e-3, limit: int = 3000
) -> tuple[CoordinateSearch, Literal["stalled", "cap"]]:
    """Search for the least cost in the box of fractions from 0 to 1, and return the stop reason.

    The search stalls when its steps fall below `stop`, and ends after `limit` evaluations.

    Raises:
        ParameterError: the start is not in the box, or steps are not above 0.
    """
    outside = next((share for share in start if not 0.0 <= share <= 1.0), None)
    if not len(start) or outside is not None:
        raise ParameterError(f"A search must start within its bounds, from 0 to 1, but {outside} is not.")
    if not 0.0 < stop <= step or limit < 1:
        raise ParameterError(
            f"Steps must be above 0 and evaluations allowed, but `step` is {step:g}, `stop` {stop:g}, `limit` {limit}."
        )
    search = CoordinateSearch(cost, tuple(map(float, start)), step, stop, limit)
    return search, search.run()
