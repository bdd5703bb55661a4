"""Restarts: states from which another run can continue.

Each pass of a run with restarts consists of consecutive legs. A leg starts only with the final state and ranges of
the previous leg. A run from a restart therefore repeats the later legs of the original run in all bits, pass by
pass (decision 049).
"""

from __future__ import annotations

import math
import operator
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import chain, pairwise, zip_longest
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.kernels import floats
from martensite.kernels.nested import name_numbers
from martensite.simulate.forks import Decision
from martensite.simulate.marching import MarchPlan, MarchResult, Row

RANGES = {
    **dict.fromkeys(("fraction", "martensite", "plus", "minus"), (0.0, 1.0)),
    "oriented": (-1.0, 1.0),
    "temperature": (0.0, 1e5),
}
"""Valid ranges of states by the last part of their names: phase fractions, and temperatures [K]."""
RANGE_TOLERANCE = 1e-6
"""Accepted rounding error beyond these ranges."""
WHERE, AT, PERIOD = "[initial]", "at", "period"
"""Scenario table for the start of a run, and its keys."""
EQUILIBRIUM, CYCLE = "equilibrium", "settled cycle"
"""Values of the key `at` that need a search."""
SAME = 1e-12
"""Fraction of a duration within which two times are equal."""


class PassState(NamedTuple):
    """State of one pass of a run."""

    state: Row
    """State variables of the system."""
    low: Row = ()
    """Minimum of earlier judged outputs; empty at the start of a run."""
    high: Row = ()
    gap: Row = ()
    """Largest earlier difference of judged outputs from the previous pass; empty for the first pass."""
    ripple: float = 0.0
    residual: float = 0.0


REST = PassState(())
"""Initial state of a pass without a restart."""


@dataclass(frozen=True)
class Restart:
    """Time and states from which a run can continue."""

    time: float = 0.0
    """[s]"""
    passes: tuple[PassState, ...] = ()
    """States of all passes: one for given steps, else at least two with decreasing tolerance."""

    @property
    def state(self) -> Row:
        """Return the state of the last pass; empty for the assembled equilibrium."""
        return self.passes[-1].state if self.passes else ()

    def at_time_zero(self) -> Restart:
        """Return the state at time 0, without the history of the run."""
        return Restart(0.0, tuple(PassState(one.state) for one in self.passes[-1:]))


HOME = Restart()
"""Default start of a run."""


class SampleTimes(tuple[float, ...]):
    """Sample times [s] of many runs, with their array for C."""

    @cached_property
    def column(self) -> NDArray[np.float64]:
        """Return the times, and infinity behind the last."""
        return np.fromiter((*self, np.inf), float, len(self) + 1)

    @cached_property
    def chosen(self) -> dict[int, SampleTimes]:
        """Return the compared samples by the number of samples of the whole run before these; filled on demand."""
        return {}


def tabulate_times(times: Sequence[float]) -> NDArray[np.float64]:
    """Return sample times [s] as an array that nobody changes, and infinity behind the last."""
    return times.column if isinstance(times, SampleTimes) else np.append(times, np.inf)


@lru_cache(16)
def list_samples(duration: float, samples: int, begin: float) -> SampleTimes:
    """Return the samples [s] of a run of a `duration` [s] from its start, and its start time.

    Raises:
        InputError: the start is not before the end.
    """
    whole = SampleTimes((duration * np.arange(samples) / (samples - 1)).tolist())
    if begin == 0.0:
        return whole
    if not begin < duration * (1.0 - SAME):
        raise InputError(
            f"The run continues at {begin:.6g} s, but ends at {duration:.6g} s, counted from 0; give a longer duration."
        )
    return SampleTimes((begin, *whole[bisect_left(whole, begin + SAME * duration) :]))


def place_stops(restart_times: Sequence[float], times: Sequence[float]) -> list[float]:
    """Return the requested future restarts [s], matched to samples within rounding.

    Raises:
        InputError: a time is outside of the run.
    """
    stops: list[float] = []
    hair = SAME * times[-1]
    for time in sorted(restart_times):
        if not 0.0 < time < times[-1] - hair:
            raise InputError(
                f"A restart at {time:.6g} s is not within the run, which ends at {times[-1]:.6g} s; "
                "its final state is always saved."
            )
        if time <= times[0] + hair:
            continue
        near = times[bisect_left(times, time - hair)]
        stops.append(near if near - time <= hair else time)
    return sorted(set(stops))


def find_restart(restarts: Sequence[Restart], at: float | None = None) -> Restart:
    """Return the restart at a time [s]; by default the last.

    Raises:
        InputError: no restart exists at that time; the message names the nearest time.
    """
    if not restarts:
        raise InputError("That run saved no state: it failed, was a batch, or had external controllers.")
    if at is None:
        return restarts[-1]
    nearest = min(restarts, key=lambda one: abs(one.time - at))
    if abs(nearest.time - at) > 1e-9 * max(abs(at), nearest.time):
        raise InputError(
            f"No state was saved at {at:.6g} s; the nearest is at {nearest.time:.6g} s. "
            "A run saves its final state, and states at the times of `restart` in its [run]."
        )
    return nearest


def name_state(system: AbstractSystem) -> list[str]:
    """Return the names of all state variables of a system, in order."""
    return name_numbers(system.init(floats, *(0.0 if one.unit != "K" else 300.0 for one in system.drives())))


def require_names(system: AbstractSystem, names: Sequence[str]) -> None:
    """Raise `InputError` if state names do not match a system."""
    own = name_state(system)
    if list(names) != own:
        other = next((a for a, b in zip_longest(names, own) if a != b), None)
        raise InputError(
            "That run was of another system: the states differ"
            f"{f' from `{other}` on' if other else ''}. Continue with the same elements, laws and mechanism."
        )


def require_sound(names: Sequence[str], restart: Restart) -> None:
    """Raise `InputError` if a restart with states of these names is damaged.

    All values must be present and finite, with temperatures above 0 K and phase fractions within their ranges.
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
    """Runner of passes leg by leg, with the states at every restart."""

    march: Callable[[MarchPlan], MarchResult]
    begin: Restart
    stops: Sequence[float]
    """Restart times [s], ascending."""
    passes: list[tuple[MarchResult, list[MarchResult]]] = field(
        default_factory=list[tuple[MarchResult, list[MarchResult]]]
    )
    """All passes with their legs."""

    def __call__(self, plan: MarchPlan) -> MarchResult:
        """Run one more pass on a single runtime, since row types differ between runtimes."""
        if self.stops or self.begin.passes:
            legs, rows = self._make_legs(plan)
            if len({leg.runtime for leg in legs}) > 1:
                legs, rows = self._make_legs(plan)
            whole = join_legs(legs, rows, self._begin(len(self.passes)))
        else:
            whole = self.march(plan)
            legs = [whole]
        earlier = [self.passes[-1][0]] if self.passes else []
        for one in (*earlier, *legs):
            if one is not whole:
                one.rows = ()  # rows of one pass are enough
        self.passes.append((whole, legs))
        return whole

    def _make_legs(self, plan: MarchPlan) -> tuple[list[MarchResult], Any]:
        """Return the legs of a pass and their rows."""
        before = self._begin(len(self.passes))
        at = before or REST
        legs, parts = list[MarchResult](), list[Any]()
        for times, sampled in cut_times(plan.times, self.stops):
            begins = len(times) == len(plan.times) and at == REST
            placed = plan if begins else plan._replace(times=times, start=at.state, extremes=(at.low, at.high))
            legs.append(self.march(placed))
            leg = legs[-1]
            parts.append(leg.rows[int(len(legs) > 1) : None if sampled or len(leg.rows) < len(times) else -1])
            if len(leg.rows) < len(times) or leg.status.failed:
                break
            at = at._replace(state=leg.state, low=leg.extremes[0], high=leg.extremes[1])
        return legs, join_rows(parts)

    def _begin(self, number: int) -> PassState | None:
        """Return the start of a pass or of the finest existing pass; None at the default start."""
        passes = self.begin.passes
        return passes[min(number, len(passes) - 1)] if passes else None

    def list_restarts(self, compared: Sequence[float]) -> list[Restart]:
        """Return the restarts for the compared times [s]; empty for an incomplete run."""
        if self.passes[-1][0].status.failed:
            return []
        times = [*self.stops, compared[-1]]
        return [Restart(time, tuple(self._keep(leg, time, compared))) for leg, time in enumerate(times)]

    def _keep(self, leg: int, time: float, compared: Sequence[float]) -> list[PassState]:
        """Return the states of all complete passes at the end of a leg [s]."""
        states = list[PassState]()
        for number, (whole, legs) in enumerate(self.passes):
            if whole.status.failed:
                continue
            if legs[0] is whole:
                states.append(PassState(whole.state, *whole.extremes, whole.largest, whole.ripple, whole.residual))
                continue
            before = self._begin(number) or REST
            parts, (low, high) = legs[: leg + 1], legs[leg].extremes
            gap = whole.largest or before.gap
            if time != compared[-1]:
                gap = whole.find_largest_gap(before.gap, bisect_right(compared[-len(whole.gaps) :], time))
            ripple = max([before.ripple, *(part.ripple for part in parts)])
            residual = max([before.residual, *(part.residual for part in parts)])
            states.append(PassState(legs[leg].state, low, high, gap, ripple, residual))
        return states


def cut_times(times: Sequence[float], stops: Sequence[float]) -> list[tuple[list[float], bool]]:
    """Return the samples of every leg [s], both ends included, and flags for ends at samples."""
    if not stops:
        return [(list(times), True)]
    legs = list[tuple[list[float], bool]]()
    for begin, end in pairwise([times[0], *stops, times[-1]]):
        inside = list(times[bisect_left(times, begin) : bisect_left(times, end)])
        inside = inside if inside and inside[0] == begin else [begin, *inside]
        legs.append(([*inside, end], times[bisect_left(times, end)] == end))
    return legs


def join_rows(parts: Sequence[Any]) -> Any:
    """Return the rows of several legs: an array, or a list on floats."""
    if all(isinstance(one, np.ndarray) for one in parts):
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
    return list(chain.from_iterable(parts))


def _find_closest(legs: Sequence[MarchResult]) -> Decision:
    """Return the closest decision of several legs."""
    return min((leg.decision for leg in legs), key=lambda one: abs(one.margin))


def join_legs(legs: Sequence[MarchResult], rows: Any, before: PassState | None) -> MarchResult:
    """Return a pass from its legs and the previous result; energies cover its legs only."""
    last = legs[-1]
    if len(legs) == 1 and before is None:
        return last
    worst = max(legs, key=lambda one: one.status)
    low, high = last.extremes
    parts = [*legs, before] if before else legs
    sums: dict[str, Any] = {
        name: sum(getattr(one, name) for one in legs) for name in ("steps", "rejected", "put_in", "lost")
    }
    return replace(
        last,
        **sums,
        rows=rows,
        ranges=tuple(map(operator.sub, high, low)),
        status=worst.status,
        time=last.time if last.status.failed or not worst.status else worst.time,
        longest=max(one.longest for one in legs),
        ripple=max(one.ripple for one in parts),
        residual=sum(one.residual for one in parts),
        decision=_find_closest(legs),
        accounts=tuple(map(sum, zip(*(one.accounts for one in legs), strict=True))),
        record=join_rows([one.record for one in legs]),
        gap=before.gap if before else (),
    )
