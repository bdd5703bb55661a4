"""Restarts: what a run keeps so that another one goes on from there, and runs that are made from restart to restart.

A run with restarts is made in legs, one after the other, in each of its passes: a leg begins with the state and the
ranges in which the one before ended, and with nothing else. So a run that begins with the state kept at a restart
repeats, pass by pass, the legs that follow in the run that kept it, in all bits. Decision 049 says what that is worth.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, pairwise, zip_longest
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.kernels import floats
from martensite.kernels.nested import name_numbers
from martensite.simulate.marching import Marched, MarchPlan, Row

RANGES = {
    **dict.fromkeys(("fraction", "martensite", "plus", "minus"), (0.0, 1.0)),
    "oriented": (-1.0, 1.0),
    "temperature": (0.0, 1e5),
}
"""Last part of the name of a number of a state -> its range: phase fractions, and temperatures [K]."""
RANGE_TOLERANCE = 1e-6
"""Distance beyond these ranges that counts as rounding."""
WHERE, AT, PERIOD = "[initial]", "at", "period"
"""Table of a scenario for the start of a run, and its keys."""
EQUILIBRIUM, CYCLE = "equilibrium", "settled cycle"
"""Starts that are searched for, values of the key `at`."""
SAME = 1e-12
"""Fraction of a duration by which two times are the same."""


class PassState(NamedTuple):
    """State of one of the passes of a run."""

    state: Row
    """All that the system remembers."""
    low: Row = ()
    """Lowest of what is judged, until then; empty for a run that begins."""
    high: Row = ()
    gap: Row = ()
    """Largest difference of the judged outputs to the pass before, until then; empty for the first pass."""
    ripple: float = 0.0
    residual: float = 0.0


REST = PassState(())
"""State of a pass of a run that begins by itself."""


@dataclass(frozen=True)
class Restart:
    """A time at which a run may be gone on with."""

    time: float = 0.0
    """[s]"""
    passes: tuple[PassState, ...] = ()
    """Passes: one of a run on given steps, at least two of a run to a tolerance, each to a finer tolerance."""

    @property
    def state(self) -> Row:
        """Return all that the system remembers, of the last pass; empty for a system at home and at rest."""
        return self.passes[-1].state if self.passes else ()

    def at_time_zero(self) -> Restart:
        """Return the state at the time 0, without the history of the run."""
        return Restart(0.0, tuple(PassState(one.state) for one in self.passes[-1:]))


HOME = Restart()
"""Default start of a run."""


def list_samples(duration: float, samples: int, begin: float) -> list[float]:
    """Return the samples [s] of a whole run of a `duration` [s] from where a run begins on, and its beginning.

    Raises:
        InputError: it begins when it should have ended.
    """
    whole: list[float] = (duration * np.arange(samples) / (samples - 1)).tolist()
    if begin == 0.0:
        return whole
    if not begin < duration * (1.0 - SAME):
        raise InputError(
            f"The run continues at {begin:.6g} s, but ends at {duration:.6g} s, counted from 0; give a longer duration."
        )
    return [begin, *whole[bisect_left(whole, begin + SAME * duration) :]]


def place_stops(asked: Sequence[float], times: Sequence[float]) -> list[float]:
    """Return the wanted restarts [s], each moved to a sample within rounding; past restarts are removed.

    Raises:
        InputError: one lies outside of the run.
    """
    found: list[float] = []
    hair = SAME * times[-1]
    for time in sorted(asked):
        if not 0.0 < time < times[-1] - hair:
            raise InputError(
                f"A restart at {time:.6g} s is not within the run, which ends at {times[-1]:.6g} s; "
                "its final state is always saved."
            )
        if time <= times[0] + hair:
            continue
        near = times[bisect_left(times, time - hair)]
        found.append(near if near - time <= hair else time)
    return sorted(set(found))


def find_restart(known: Sequence[Restart], at: float | None = None) -> Restart:
    """Return the restart at a time [s]; by default the last.

    Raises:
        InputError: nothing was kept then; the message gives the nearest time.
    """
    if not known:
        raise InputError("That run saved no state: it failed, was a batch, or had external controllers.")
    if at is None:
        return known[-1]
    nearest = min(known, key=lambda one: abs(one.time - at))
    if abs(nearest.time - at) > 1e-9 * max(abs(at), nearest.time):
        raise InputError(
            f"No state was saved at {at:.6g} s; the nearest is at {nearest.time:.6g} s. "
            "A run saves its final state, and states at the times of `restart` in its [run]."
        )
    return nearest


def name_state(system: AbstractSystem) -> list[str]:
    """Return the names of all numbers of a state of a system, in order."""
    return name_numbers(system.init(floats, *(0.0 if one.unit != "K" else 300.0 for one in system.drives())))


def require_names(system: AbstractSystem, names: Sequence[str]) -> None:
    """Raise `InputError` if a state with numbers of these names is not one of a system."""
    own = name_state(system)
    if list(names) != own:
        other = next((a for a, b in zip_longest(names, own) if a != b), None)
        raise InputError(
            "That run was of another system: the states differ"
            f"{f' from `{other}` on' if other else ''}. Continue with the same elements, laws and mechanism."
        )


def require_sound(names: Sequence[str], restart: Restart) -> None:
    """Raise `InputError` if a restart, whose state has numbers of these names, is damaged.

    A state must have all its numbers, all finite, with temperatures above 0 K and phase fractions within their ranges.
    """
    for one in restart.passes:
        if len(one.state) != len(names):
            raise _describe_damage(restart, f"it has {len(one.state)} numbers, but the system has {len(names)}")
        for name, value in zip(names, one.state, strict=True):
            low, high = RANGES.get(name.rpartition(".")[2], (-math.inf, math.inf))
            if not (math.isfinite(value) and low - RANGE_TOLERANCE <= value <= high + RANGE_TOLERANCE):
                span = f"between {low:g} and {high:g}" if math.isfinite(low) else "finite"
                raise _describe_damage(restart, f"`{name}` must be {span}, but is {value:g}")


def _describe_damage(restart: Restart, reason: str) -> InputError:
    return InputError(
        f"The state at {restart.time:.6g} s is damaged: {reason}. Make the run that kept it again, and go on from that."
    )


@dataclass
class Relay:
    """Makes the passes of a run leg by leg, and keeps where each pass is at every restart."""

    march: Callable[[MarchPlan], Marched]
    begin: Restart
    stops: Sequence[float]
    """[s], ascending."""
    made: list[tuple[Marched, list[Marched]]] = field(default_factory=list[tuple[Marched, list[Marched]]])
    """Every pass, and its legs."""

    def __call__(self, plan: MarchPlan) -> Marched:
        """One more pass, all of it on one runtime: `auto` may change it between legs, and rows of runtimes differ."""
        legs, rows = self._make_legs(plan)
        if len({leg.used for leg in legs}) > 1:
            legs, rows = self._make_legs(plan)
        whole = join_legs(legs, rows, self._begin(len(self.made)))
        for one in (*(earlier for earlier, _ in self.made), *(leg for leg in legs if leg is not whole)):
            one.rows = []  # those of one pass are enough to hold
        self.made.append((whole, legs))
        return whole

    def _make_legs(self, plan: MarchPlan) -> tuple[list[Marched], Any]:
        """Return the legs of a pass, and the rows of all of them."""
        before = self._begin(len(self.made))
        at = before or REST
        legs, parts = list[Marched](), list[Any]()
        for times, sampled in cut_times(plan.times, self.stops):
            begins = len(times) == len(plan.times) and at == REST
            placed = plan if begins else replace(plan, times=times, start=at.state, extremes=(at.low, at.high))
            legs.append(self.march(placed))
            leg = legs[-1]
            parts.append(leg.rows[int(len(legs) > 1) : None if sampled or len(leg.rows) < len(times) else -1])
            if len(leg.rows) < len(times) or leg.status.failed:
                break
            at = at._replace(state=leg.state, low=leg.extremes[0], high=leg.extremes[1])
        return legs, join_rows(parts)

    def _begin(self, number: int) -> PassState | None:
        """Return the start of a pass, or of the finest pass before if there were fewer; None at the default start."""
        known = self.begin.passes
        return known[min(number, len(known) - 1)] if known else None

    def list_restarts(self, compared: Sequence[float]) -> list[Restart]:
        """Return the restarts, if passes were compared at the given times [s]; empty for a run that stopped early."""
        if self.made[-1][0].status.failed:
            return []
        times = [*self.stops, compared[-1]]
        return [Restart(time, tuple(self._keep(leg, time, compared))) for leg, time in enumerate(times)]

    def _keep(self, leg: int, time: float, compared: Sequence[float]) -> list[PassState]:
        """Return the states of the passes at the end of a leg [s], without passes that stopped early."""
        found = list[PassState]()
        for number, (whole, legs) in enumerate(self.made):
            if whole.status.failed:
                continue
            before = self._begin(number) or REST
            parts, (low, high) = legs[: leg + 1], legs[leg].extremes
            gap = whole.find_largest_gap(before.gap, bisect_right(compared[-len(whole.gaps) :], time))
            worst = [max([getattr(before, n), *(getattr(p, n) for p in parts)]) for n in ("ripple", "residual")]
            found.append(PassState(legs[leg].state, low, high, gap, *worst))
        return found


def cut_times(times: Sequence[float], stops: Sequence[float]) -> list[tuple[list[float], bool]]:
    """The samples of every leg [s], both ends included, and whether its end is a sample of the run."""
    if not stops:
        return [(list(times), True)]
    found = list[tuple[list[float], bool]]()
    for begin, end in pairwise([times[0], *stops, times[-1]]):
        inside = list(times[bisect_left(times, begin) : bisect_left(times, end)])
        inside = inside if inside and inside[0] == begin else [begin, *inside]
        found.append(([*inside, end], times[bisect_left(times, end)] == end))
    return found


def join_rows(parts: Sequence[Any]) -> Any:
    """Return the rows of several legs together: an array, or a list of runs on floats."""
    if all(isinstance(one, np.ndarray) for one in parts):
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
    return list(chain.from_iterable(parts))


def join_legs(legs: Sequence[Marched], rows: Any, before: PassState | None) -> Marched:
    """Return a pass from its legs, after what was before it; its energies are those of its legs."""
    last = legs[-1]
    if len(legs) == 1 and before is None:
        return last
    worst = max(legs, key=lambda one: one.status)
    low, high = last.extremes
    ranges = tuple(b - a for a, b in zip(low, high, strict=True))
    end = last if last.status.failed or not worst.status else worst
    return replace(
        last,
        rows=rows,
        ranges=ranges,
        status=worst.status,
        time=end.time,
        steps=sum(one.steps for one in legs),
        rejected=sum(one.rejected for one in legs),
        longest=max(one.longest for one in legs),
        ripple=max([*(one.ripple for one in legs), before.ripple if before else 0.0]),
        residual=sum(one.residual for one in legs) + (before.residual if before else 0.0),
        put_in=sum(one.put_in for one in legs),
        lost=sum(one.lost for one in legs),
        accounts=tuple(map(sum, zip(*(one.accounts for one in legs), strict=True))),
        record=join_rows([one.record for one in legs]),
        gap=before.gap if before else (),
    )
