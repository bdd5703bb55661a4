"""Is a loop able to do what it is for? Tests of a bench that find what a run would show too late.

Here: signals that the source cannot give, the sign of the loop, the reach of the reference. Where `martensite-control`
is installed, it adds margins on both branches, pace, sampling, noise and observability.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from martensite.base.errors import InputError, MartensiteError
from martensite.base.formats import write_quantity
from martensite.control.controllers.base import AHEAD, AbstractController
from martensite.control.controllers.mpc import Mpc
from martensite.control.loop.bench import Bench
from martensite.control.loop.findings import LoopFinding, check_guard, check_signals, find_source, list_limits
from martensite.control.loop.held_readings import iterate_signals
from martensite.control.loop.names import list_readings
from martensite.control.synthesis.rest_curves import RestCurve, compute_rest_curve, read_at_rest, read_curve
from martensite.kernels.c99_lanes import BLOCK
from martensite.signals.base import AbstractWaveform
from martensite.signals.sampling.sampled import Numbers

COARSE, SIGNALS = BLOCK, 2 * BLOCK
"""On a branch: to see where the reading moves, and there."""
EVEN = 0.2
"""Share of the signals that is spread evenly."""
LONGER = 1000
"""Samples after which a controller has answered an error, its integral included."""
SHORT = 10
"""Samples after which it has answered a reference."""
BEYOND = 0.02
"""Share of what can be reached by which a reference may be beyond it."""
SAMPLES = 4000
"""Of a reference at most."""


@dataclass(frozen=True)
class LoopReport:
    """What a check of the loops of a bench found."""

    findings: tuple[LoopFinding, ...]
    """Faults first."""
    tested: tuple[str, ...]
    untested: Mapping[str, str]
    """What could not be tested, and why."""
    margins: tuple[Mapping[str, Any], ...] = ()
    """A row for every operating point: branch, reading and signal, margins."""

    @property
    def verdict(self) -> str:
        """`not sound` with a fault, `not all tested`, or `sound`."""
        faults = any(one.fault for one in self.findings)
        return "not sound" if faults else "not all tested" if self.untested else "sound"

    def to_dict(self) -> dict[str, Any]:
        """All of it for programs."""
        return asdict(self) | {"verdict": self.verdict}


@dataclass(frozen=True, eq=False)
class LoopCase:
    """One loop of a bench, and what its tests ask for."""

    bench: Bench
    drive: str
    controller: AbstractController
    duration: float
    """Of the run [s]."""
    others: Mapping[str, float] = field(default_factory=dict[str, float])
    """Signals of other drives."""

    @property
    def unit(self) -> str:
        """SI unit of what is controlled."""
        return list_readings(self.bench)[self.controller.measured].unit

    @cached_property
    def reference(self) -> Numbers:
        """What the reading shall be, at samples of the run."""
        count = min(int(self.duration / self.bench.period) + 1, SAMPLES)
        return np.array([float(self.controller.reference.value(t)) for t in np.linspace(0.0, self.duration, count)])

    @cached_property
    def limits(self) -> tuple[float, float]:
        """Least and largest signal that the controller gives and the source can give."""
        source, ohms = find_source(self.bench.plant, self.drive)
        known = list_limits(self.controller).values()
        reach = (-np.inf, np.inf) if source is None else source.reach(ohms)
        low, high = (min(known), max(known)) if known else reach
        low, high = max(low, reach[0], 0.0), min(high, reach[1])
        if not (np.isfinite(high) and low < high):
            raise InputError("no limits of the signal are known")
        return low, high

    @cached_property
    def heating(self) -> RestCurve:
        """Rest under rising signals."""
        return self.compute_branch(self.limits[1], None)

    @cached_property
    def cooling(self) -> RestCurve:
        """Rest under falling signals, from the end of the heating branch."""
        return self.compute_branch(self.limits[1], self.heating.states[:, -1])

    def compute_branch(self, high: float, start: Numbers | None) -> RestCurve:
        """Rest under signals up to a highest one, dense where the reading moves; cooling from a `start`."""

        def settle(row: Numbers) -> RestCurve:
            return compute_rest_curve(self.bench.plant, self.drive, row, others=self.others, start=start)

        coarse = settle(np.linspace(self.limits[0], high, COARSE))
        moved = np.abs(np.diff(self.read(coarse)))
        way = np.cumsum([0.0, *(moved + EVEN * max(moved.sum(), 1e-300) / COARSE)])
        return settle(np.interp(np.linspace(0.0, way[-1], SIGNALS), way, coarse.levels))

    def list_reached(self) -> Numbers:
        """Readings on the heating branches of this drive, of those led, and of those that hold the same reading."""
        own = self.controller
        members = {**self.bench.controllers.members(), **dict.fromkeys(own.led_drives(), own), self.drive: own}
        peers = [(name, one) for name, one in members.items() if one.measured == own.measured and name != self.drive]
        every = [self, *(LoopCase(self.bench, *peer, self.duration, self.others) for peer in peers)]
        return np.concatenate([one.read(one.heating) for one in every])

    def read(self, curve: RestCurve) -> Numbers:
        """What is controlled, as it is read along a branch."""
        return read_curve(self.bench, curve, self.controller.measured)

    def find(
        self, test: str, place: str, said: tuple[str, str], number: tuple[float, float, str], fault: bool = False
    ) -> LoopFinding:
        """A finding about this loop: sentence and remedy; number, what is allowed, unit."""
        where = place if "." in place else f"{place}.{self.drive}"
        return LoopFinding(test, where, said[0], float(number[0]), float(number[1]), number[2], said[1], fault)


LoopTest: TypeAlias = Callable[[LoopCase], Iterator[LoopFinding]]


def check_loop(bench: Bench, duration: float, *, waveforms: Mapping[str, AbstractWaveform] | None = None) -> LoopReport:
    """Test every loop of a bench for what keeps it from doing what it is for.

    Args:
        bench: with its controllers.
        duration: of the run whose references are judged [s].
        waveforms: of drives that no controller has; their first values count.
    """
    others = {name: float(one.value(0.0)) for name, one in (waveforms or {}).items()}
    members = bench.controllers.members()
    findings, untested = [*check_signals(bench), *check_guard(bench)], dict[str, str]()
    tested = [*["signal"] * bool(members), *["guard"] * (bench.supervisor is not None)]
    margins = list[Mapping[str, Any]]()
    tests = _collect_tests(margins)
    for drive, controller in members.items():
        case, named = LoopCase(bench, drive, controller, duration, others), f" of {drive}" * (len(members) > 1)
        if not controller.holds:
            untested[f"loop of {drive}"] = f"`{controller.registered_name}` holds no reading at a reference"
            continue
        for name, test in tests.items():
            try:
                findings.extend(test(case))
                tested.append(name + named)
            except (MartensiteError, ArithmeticError) as error:
                untested[name + named] = str(error).rstrip(".")
            except LookupError as error:
                untested[name + named] = f"`{controller.registered_name}` asks for {error}, which no reading is"
    if len(members) > 1:
        untested["coupling"] = "each loop was tested alone, with the other controllers off"
    wrong = {one.where for one in findings if one.test == "sign"}  # whose margins follow from it
    kept = [one for one in findings if one.test != "margins" or one.where not in wrong]
    return LoopReport(tuple(sorted(kept, key=lambda one: not one.fault)), tuple(tested), untested, tuple(margins))


def _collect_tests(margins: list[Mapping[str, Any]]) -> dict[str, LoopTest]:
    """Return the tests by name."""
    from martensite.control.margins.loop_tests import make_tests

    return {"sign": check_sign, "reach": check_reach} | make_tests(margins)


def check_reach(case: LoopCase) -> Iterator[LoopFinding]:
    """Whether the reading can rest where the reference asks for it."""
    reached, unit, asked = case.list_reached(), case.unit, case.reference
    least, most = float(reached.min()), float(reached.max())
    ends = f"between {write_quantity(least, unit, 4)} and {write_quantity(most, unit, 4)}"
    under = f"under signals from {case.limits[0]:.4g} to {case.limits[1]:.4g}"
    for words, level, bound in (("at most", asked.max(), most), ("at least", asked.min(), least)):
        if abs(level - np.clip(level, least, most)) > BEYOND * (most - least) and (level > most) == (bound == most):
            wanted = f"The reference asks for `{case.controller.measured}` of {write_quantity(float(level), unit, 4)}"
            remedy = f"Try a reference of {words} {write_quantity(bound, unit, 3)}, or another actuator."
            said = f"{wanted}, but {under} it rests {ends}."
            yield case.find("reach", "references", (said, remedy), (level, bound, unit), fault=True)


def check_sign(case: LoopCase) -> Iterator[LoopFinding]:
    """Whether the controller answers too low a reading with the signal that raises it, at once and in the end."""
    if case.controller.led_drives():
        raise InputError(f"`{case.controller.registered_name}` answers with several signals at once")
    ends = [read_at_rest(case.bench, case.heating.point(k).outputs) for k in (0, -1)]
    name, (first, last) = case.controller.measured, ends
    rise, middle = last[name] - first[name], 0.5 * (first[name] + last[name])
    if rise == 0.0:
        raise InputError(f"no signal between {case.limits[0]:.4g} and {case.limits[1]:.4g} moves `{name}`")
    answers = np.array([_list_answers(case, one, middle) for one in ends])
    pushes = answers[0] - answers[1]
    if not pushes.any():
        yield _judge_idle(case, ends)
        return
    wrong = [k for k in range(2) if pushes[k] < 0.0]
    if wrong:
        at, (low, high) = [write_quantity(one[name], case.unit, 3) for one in ends], answers[:, wrong[0]]
        when = "" if len(wrong) > 1 else " at once" if wrong == [0] else " in the end"
        said = (
            f"A higher signal {'raises' if rise > 0.0 else 'lowers'} `{name}`, but with a reference of "
            f"{write_quantity(middle, case.unit, 3)} the controller answers{when} {low:.3g} at {at[0]} and {high:.3g} "
            f"at {at[1]}: the loop drives away from its reference."
        )
        numbers = float(pushes[wrong[0]]), 0.0, "1"
        yield case.find("sign", "controllers", (said, "Turn the sign of its gains."), numbers, fault=True)


def _judge_idle(case: LoopCase, ends: Sequence[Mapping[str, float]]) -> LoopFinding:
    """Return the fault of a controller that responds to neither reading nor reference.

    Raises:
        InputError: it responds to the reference, as a feed-forward does.
    """
    name = case.controller.measured
    low, high = (_list_answers(case, ends[0], one[name], SHORT)[-1] for one in ends)
    if low != high:
        raise InputError(f"`{case.controller.registered_name}` does not answer what it reads")
    said = (
        f"The controller gives {low:.3g} at every `{name}` and every reference: it has no gain, so nothing is "
        "controlled."
    )
    remedy = "Give it gains, such as those of `martensite tune`."
    return case.find("sign", "controllers", (said, remedy), (0.0, 0.0, "1"), fault=True)


def _list_answers(
    case: LoopCase, readings: Mapping[str, float], reference: float, count: int = LONGER
) -> tuple[float, float]:
    """Signals of the controller while it reads the same: the first one, and that after a while."""
    previews = case.controller.list_previews().items()  # of its own reference, for it leads nobody
    ahead = {f"{AHEAD}{name}.{k}": reference for name, times in previews for k in range(len(times) + 1)}
    samples = 1 if isinstance(case.controller, Mpc) else count  # a plan is made anew in every sample
    signals = list(iterate_signals(case.controller, {**readings, **ahead}, reference, case.bench.period, samples))
    return signals[0], signals[-1]
