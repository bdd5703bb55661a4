"""Near misses of the surfaces on which a law forgets its branch.

With `history = "resume"` a path that touches the start of the opposite transformation forgets its branch. The result
jumps there: no integrator can decide a touch that is smaller than its error. `ForkWatch` finds the closest decision of
a run among its accepted half steps:

- A path that turns before the surface keeps the branch. If it then enters the strip of the branch, the difference to a
  path that forgot the branch grows with the progress in that strip.
- A path that turns behind the surface forgets the branch. The depth is the largest distance behind the surface before
  the branch is resumed.

Only decisions that change the martensite fraction count. `forks.c` implements the same algorithm in C.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from martensite.physics.laws.base import Fork

COUNTS = 33.0
"""Smallest relevant change of a fraction, in step tolerances of its range: about the tolerance of a run."""

ROUNDED = 1e-9
"""Rounding error of a distance before a surface [K]."""


class LawFork(NamedTuple):
    """Position of a branch that a law may forget among the outputs."""

    fraction: int
    """Index of its martensite fraction in the judged outputs."""
    temperature: int
    """Index of its temperature in the judged outputs."""
    stress: int
    weight: float
    """Weight of the law in these outputs."""


class Decision(NamedTuple):
    """Closest decision of a run about a forgotten branch."""

    margin: float = math.inf
    """Distance from the surface [K]; negative if the path reached it."""
    time: float = 0.0
    """[s]"""
    change: float = 0.0
    """Change of the martensite fraction at the point of the law by the other decision [-]."""
    place: int = -1
    """Index of the fork among those of the system; -1 without a decision."""
    branch: float = 0.0
    """Direction of the branch: +1 forward, -1 reverse."""


NO_DECISION = Decision()


def describe_decision(decision: Decision, error: float, port: str) -> str:
    """Return a warning for a decision that the error [K] of the run may change, at the element of a port, if named."""
    forward = decision.branch > 0.0
    direct, opposite = ("forward", "reverse") if forward else ("reverse", "forward")
    surface = f"the start of the {opposite} transformation ({'A_s' if forward else 'M_s'})"
    where = f"t = {decision.time:.6g} s{f', element `{port}`' if port else ''}"
    met = "misses" if decision.margin >= 0.0 else "passes"
    return (
        f"Warning: at {where}, the path {met} {surface} by {abs(decision.margin):.1e} K, and the error of the run is "
        f"up to {error:.1e} K. There the law forgets the interrupted {direct} transformation, so the martensite "
        f"fraction may be wrong by up to {decision.change:.2g}; the stated error includes this. "
        'Give a smaller tolerance, change the drive or the load a little, or use `history = "return-point"` of the law.'
    )


def read_decision(numbers: Sequence[float]) -> Decision:
    """Return the decision from its numbers in C."""
    margin, time, change, place, branch = numbers
    return Decision(margin, time, change, int(place), branch)


class OpenDecision(NamedTuple):
    """Decision whose effect is not yet known."""

    margin: float
    time: float
    branch: float
    rest: float
    bound: float
    entry: float = 0.0
    """Distance of the last point before the surface, at most 0 [K]."""
    ratio: float = 1.0
    """Bound of the other branch over the bound of the branch in progress."""

    def find_change(self, bound: float) -> float:
        """Return the difference of the remaining fractions of both branches."""
        other = self.ratio * bound
        return min(self.rest, other) - self.rest * other / self.bound


class WatchedFork:
    """Branch of a law with its last two points and its open decisions."""

    def __init__(self) -> None:
        self.last, self.time, self.older = Fork(0.0, 0.0, 0.0, 0.0, 0.0), 0.0, -math.inf
        self.near: OpenDecision | None = None
        """Decision of the branch in progress."""
        self.ended_decision: OpenDecision | None = None
        """Decision of the branch that the surface ended."""

    def see(self, time: float, now: Fork, least: float) -> OpenDecision | None:
        """Add a point [s] and return the decision of the branch in progress; `least` is the relevant change."""
        last = self.last
        lost = last.rest - last.rest * last.rest / last.bound if last.bound > 0.0 else 0.0
        here = OpenDecision(last.other, self.time, last.branch, last.rest, last.bound)
        same = now.branch == last.branch
        if not same:
            self._end_branch(now, here if last.branch and now.branch and lost > least else None)
        elif lost > least and self._turns(now) and (self.near is None or last.other < abs(self.near.margin)):
            self.near = here
        if self.ended_decision:
            self.ended_decision = self.ended_decision._replace(
                margin=min(self.ended_decision.margin, now.own - self.ended_decision.entry)
            )
        self.older = last.other if same and now.branch else -math.inf
        self.last, self.time = now, time
        return self.near

    def _turns(self, now: Fork) -> bool:
        """Return whether the path turned at the last point before the surface."""
        return self.older >= self.last.other > -ROUNDED and now.other > self.last.other

    def _end_branch(self, now: Fork, ended: OpenDecision | None) -> None:
        """Resume the decision of the branch that begins, and open a decision of the branch that ends."""
        decision = self.ended_decision
        resumes = decision is not None and decision.branch == now.branch
        self.near = decision._replace(ratio=decision.bound / decision.rest) if decision and resumes else None
        self.ended_decision = ended and ended._replace(margin=0.0, entry=min(ended.margin, 0.0))


class ForkWatch:
    """Search for the closest decision of a run."""

    def __init__(self, count: int) -> None:
        self.watched = [WatchedFork() for _ in range(count)]
        self.closest = NO_DECISION

    def see(self, time: float, numbers: Sequence[float], allowed: Sequence[float]) -> None:
        """Add a point [s] of the run with its forks, and the smallest relevant change of each fraction."""
        size = len(Fork._fields)
        for place, (one, least) in enumerate(zip(self.watched, allowed, strict=True)):
            now = Fork(*numbers[size * place : size * place + size])
            near = one.see(time, now, least)
            change = near.find_change(now.bound) if near else 0.0
            if near and change > least and abs(near.margin) <= abs(self.closest.margin):
                closest = self.closest
                again = near.time == closest.time and place == closest.place
                largest = max(change, closest.change) if again else change
                self.closest = Decision(near.margin, near.time, largest, place, near.branch)
