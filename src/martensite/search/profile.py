"""Profile likelihood: interval of one parameter with all others refitted.

With C(x) the least sum of squared weighted residuals for a parameter fixed at x, the interval contains all x with

    C(x) - C_min ≤ t(level, n - p)² C_min/(n - p)      noise estimated from the fit (F-test)
    C(x) - C_min ≤ z(level)² noise²                    noise known (χ² of one degree of freedom)

(Raue and others (2009), Bioinformatics 25). For a linear model this is the interval from the Jacobian, value ± t error.
Otherwise it may be asymmetric or unbounded. The profile proceeds outward from the optimum, with steps that change
√(C - C_min) by about a quarter of its limit. The crossing of the limit is interpolated in √(C - C_min), which is linear
for a linear model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from statistics import NormalDist
from typing import Any, Literal

from martensite.base.confidence import LEVEL, Interval, student_quantile
from martensite.base.errors import ParameterError, SolveError
from martensite.search.quantity_text import format_quantity

Solve = Callable[[dict[int, float], Sequence[float]], tuple[Sequence[float], float]]
"""Refit with some fixed parameters: (fixed values by index, start) -> (all parameters, cost C)."""
MOST_REFITS = 40
"""Largest number of refits on each side before the limit is passed."""
_CROSSING = 20
_PART = 0.25
_MANY = 10_000
_CLOSE = 1e-4
_IMPROVED = 1e-3
_RETRIES = 3


Reason = Literal["limit", "bound", "failed", "refits"]


@dataclass(frozen=True)
class ProfilePoint:
    """Refit with a fixed parameter."""

    at: float
    """Value of the parameter [SI]."""
    excess: float
    """Cost minus the cost of the optimum, C - C_min."""
    values: tuple[float, ...]
    """All parameters, on the scale of the profile steps."""


@dataclass(frozen=True)
class ProfileEnd:
    """End of the profile on one side."""

    at: float
    """Last value within the limit [SI]."""
    reason: Reason
    """Stop reason: `limit` for an end of the interval; `bound`, `failed` or `refits` for an open side."""


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
    points: tuple[ProfilePoint, ...]
    """All refits and the optimum, in ascending order."""
    below: ProfileEnd
    above: ProfileEnd
    better: ProfilePoint | None
    """Refit that is better than the optimum by more than a thousandth of the limit, if any."""

    @property
    def interval(self) -> Interval:
        """Return the confidence interval; infinite on an open side."""
        low = self.below.at if self.below.reason == "limit" else -math.inf
        high = self.above.at if self.above.reason == "limit" else math.inf
        return low, high

    @property
    def sentence(self) -> str:
        """Return the interval, or the reason for an open side, in everyday units."""
        share, value_text = f"{100.0 * self.level:g} %", format_quantity(self.value, self.unit)
        low, high = (format_quantity(end.at, self.unit) for end in (self.below, self.above))
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
            at = format_quantity(self.better.at, self.unit)
            warning = f" A better fit was found at {at}: the fit was not at its optimum; repeat it."
        return f"`{self.name}` = {value_text}, {words}.{warning}"

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name and the interval, for JSON."""
        return asdict(self) | {"interval": list(self.interval), "sentence": self.sentence}

    def _open(self, side: Literal["lower", "upper"]) -> str:
        end = self.below if side == "lower" else self.above
        at = format_quantity(end.at, self.unit)
        if end.reason == "bound":
            return f"the data give no {side} limit within the bounds (to {at})"
        why = "fits beyond it fail" if end.reason == "failed" else "the walk was stopped there"
        return f"no {side} limit was found as far as {at}; {why}"


def walk_profile(
    solve: Solve,
    values: Sequence[float],
    cost: float,
    place: int,
    *,
    low: float,
    high: float,
    freedom: int | None = None,
    noise: float | None = None,
    level: float = LEVEL,
    step: float | None = None,
    most: int = MOST_REFITS,
    to_value: Callable[[float], float] = float,
    name: str = "parameter",
    unit: str = "1",
) -> Profile:
    """Compute the profile of one parameter from the optimum to both sides.

    Args:
        solve: refit of the other parameters, may raise `SolveError`.
        values: parameters at the optimum.
        cost: sum of squared residuals at the optimum.
        place: index of the parameter in `values`.
        low: lower bound of the parameter.
        high: upper bound of the parameter.
        freedom: degrees of freedom, n - p, for noise estimated from the fit.
        noise: standard deviation of a weighted residual, if known.
        level: level of the interval.
        step: first step, about a standard error, by default a fiftieth of the bounds.
        most: largest number of refits on each side before the limit is passed.
        to_value: increasing map from the scale of the profile to SI.
        name: name of the parameter, for its sentence.
        unit: SI unit of the parameter.

    Raises:
        ParameterError: neither or both of `freedom` and `noise` are given, the optimum is out of bounds, or an
            estimated noise is 0.
    """
    _check_walk(values, place, low, high, step, most)
    limit = _compute_limit(cost, freedom, noise, level)
    size = 0.02 * (high - low) if step is None else step
    walk = _Walk(solve, tuple(values), cost, place, limit, most)
    below, above = walk.outward(low, -size), walk.outward(high, size)
    walked = sorted((*walk.points, ProfilePoint(values[place], 0.0, tuple(values))), key=lambda p: p.at)
    points = tuple(replace(point, at=to_value(point.at)) for point in walked)
    low_end, high_end = (replace(end, at=to_value(end.at)) for end in (below, above))
    least = min(points, key=lambda point: point.excess)
    better = least if least.excess < -_IMPROVED * limit else None
    return Profile(name, unit, to_value(values[place]), level, limit, points, low_end, high_end, better)


def _compute_limit(cost: float, freedom: int | None, noise: float | None, level: float) -> float:
    if (freedom is None) == (noise is None):
        raise ParameterError("A profile takes either `freedom` or `noise`, not both or neither.")
    if freedom is not None:
        limit = cost * student_quantile(level, min(freedom, _MANY)) ** 2 / freedom
    else:
        limit = ((noise or 0.0) * NormalDist().inv_cdf(0.5 + 0.5 * level)) ** 2
    if not 0.0 < limit < math.inf:
        raise ParameterError("The noise of a profile must be above 0; give `noise` if C is 0.")
    return limit


@dataclass
class _Walk:
    solve: Solve
    values: tuple[float, ...]
    cost: float
    place: int
    limit: float
    most: int
    points: list[ProfilePoint] = field(default_factory=list[ProfilePoint])

    def outward(self, bound: float, step: float) -> ProfileEnd:
        """Step to one side until the limit is passed, or the bound is reached."""
        inner, failed, refits = ProfilePoint(self.values[self.place], 0.0, self.values), 0, 0
        while inner.at != bound:
            if refits >= self.most:
                return ProfileEnd(inner.at, "refits")
            at = inner.at + step
            at = bound if (at - bound) * step >= 0.0 else at
            point, refits = self._point(at, inner), refits + 1
            if point is None:
                if failed == _RETRIES:
                    return ProfileEnd(inner.at, "failed")
                step, failed = 0.25 * (at - inner.at), failed + 1
            elif point.excess > self.limit:
                return self._crossing(inner, point)
            else:
                step *= self._stretch(inner, point)
                inner = point
        return ProfileEnd(bound, "bound")

    def _stretch(self, inner: ProfilePoint, outer: ProfilePoint) -> float:
        """Return the factor on the step, from half to double."""
        gained = self._root(outer) - self._root(inner)
        return min(max(_PART / gained, 0.5), 2.0) if gained > 0.0 else 2.0

    def _crossing(self, inner: ProfilePoint, outer: ProfilePoint) -> ProfileEnd:
        below, above = self._root(inner) - 1.0, self._root(outer) - 1.0
        at, side = outer.at, 0
        for _ in range(_CROSSING):
            at = inner.at + below / (below - above) * (outer.at - inner.at)
            point = self._point(at, inner)
            if point is None:
                return ProfileEnd(inner.at, "failed")
            gap = self._root(point) - 1.0
            if abs(gap) <= _CLOSE:
                break
            if gap < 0.0:
                inner, below, above = point, gap, above * (0.5 if side < 0 else 1.0)
            else:
                outer, above, below = point, gap, below * (0.5 if side > 0 else 1.0)
            side = -1 if gap < 0.0 else 1
        return ProfileEnd(at, "limit")

    def _root(self, point: ProfilePoint) -> float:
        """Return √(C - C_min) as a fraction of its limit."""
        return math.sqrt(max(point.excess, 0.0) / self.limit)

    def _point(self, at: float, start: ProfilePoint) -> ProfilePoint | None:
        """Return the profile at one value; None for a failed refit."""
        first = (*start.values[: self.place], at, *start.values[self.place + 1 :])
        try:
            values, cost = self.solve({self.place: at}, first)
        except SolveError:
            return None
        if not math.isfinite(cost):
            return None
        self.points.append(ProfilePoint(at, cost - self.cost, tuple(map(float, values))))
        return self.points[-1]


def _check_walk(values: Sequence[float], place: int, low: float, high: float, step: float | None, most: int) -> None:
    if not 0 <= place < len(values):
        raise ParameterError(f"There is no parameter {place} among {len(values)}.")
    if not low <= values[place] <= high or low == high:
        raise ParameterError(
            f"The optimum must lie within the bounds of its parameter, but {values[place]:g} is "
            f"not within {low:g} to {high:g}."
        )
    if most < 1 or (step is not None and not step > 0.0):
        raise ParameterError("Arguments `step` and `most` of a profile must be above 0.")
