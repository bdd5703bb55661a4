"""The profile of one parameter, its interval, and both in words."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

from martensite.base.confidence import Interval
from martensite.search.words import quantity

Reason = Literal["limit", "bound", "failed", "refits"]


@dataclass(frozen=True)
class Point:
    """One refit with the parameter held."""

    at: float
    """Value of the parameter [SI]."""
    excess: float
    """Cost above that of the optimum, C - C_min."""
    values: tuple[float, ...]
    """All parameters, on the scale on which they were walked."""


@dataclass(frozen=True)
class End:
    """Where the walk to one side ended."""

    at: float
    """Last value within the limit [SI]."""
    reason: Reason
    """`limit`: passed, an end of the interval; else it is open: at the search `bound`, where
    refits `failed`, or after as many `refits` as were allowed."""


@dataclass(frozen=True)
class Profile:
    """Profile likelihood of one parameter."""

    name: str
    unit: str
    value: float
    """At the optimum [SI]."""
    level: float
    limit: float
    """C - C_min at the ends of the interval."""
    points: tuple[Point, ...]
    """All refits and the optimum, by rising value."""
    below: End
    above: End
    better: Point | None
    """A refit that is better than the optimum by more than a thousandth of the limit, if any."""

    @property
    def interval(self) -> Interval:
        """Confidence interval; infinite on a side that is open."""
        low = self.below.at if self.below.reason == "limit" else -math.inf
        high = self.above.at if self.above.reason == "limit" else math.inf
        return low, high

    @property
    def sentence(self) -> str:
        """The interval, or why it is open, in everyday units."""
        share, shown = f"{100.0 * self.level:g} %", quantity(self.value, self.unit)
        low, high = (quantity(end.at, self.unit) for end in (self.below, self.above))
        below, above = self.below.reason == "limit", self.above.reason == "limit"
        if below and above:
            words = f"{share} interval {low} to {high}"
        elif below:
            words = f"{share} interval above {low}, open: {self._open('upper')}"
        elif above:
            words = f"{share} interval below {high}, open: {self._open('lower')}"
        else:
            words = f"open: {self._open('lower')}, and {self._open('upper')}"
        warning = ""
        if self.better is not None:
            at = quantity(self.better.at, self.unit)
            warning = f" A better fit was found at {at}: the fit was not at its optimum; repeat it."
        return f"`{self.name}` = {shown}, {words}.{warning}"

    def to_dict(self) -> dict[str, Any]:
        """All fields by name and the interval, for JSON."""
        return asdict(self) | {"interval": list(self.interval), "sentence": self.sentence}

    def _open(self, side: Literal["lower", "upper"]) -> str:
        end = self.below if side == "lower" else self.above
        at = quantity(end.at, self.unit)
        if end.reason == "bound":
            return f"the data give no {side} limit within the bounds (to {at})"
        why = "fits beyond it fail" if end.reason == "failed" else "the walk was stopped there"
        return f"no {side} limit was found as far as {at}; {why}"
