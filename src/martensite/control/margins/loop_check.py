"""Tests of the loops of a bench that find faults before a run: signals, sign, reach, margins, pace and noise."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

import numpy as np

from martensite.base.errors import InputError, MartensiteError
from martensite.base.formats import write_quantity
from martensite.control.controllers.base import AHEAD
from martensite.control.controllers.mpc import Mpc
from martensite.control.loop.bench import Bench
from martensite.control.loop.findings import LoopFinding, check_guard, check_signals
from martensite.control.loop.held_readings import iterate_signals
from martensite.control.margins.loop_case import BEYOND, LoopCase
from martensite.control.synthesis.rest_curves import read_at_rest
from martensite.signals.base import AbstractWaveform

LONGER = 1000
"""Samples after which a controller has answered an error with its integral."""
SHORT = 10
"""Samples after which a controller has answered a reference."""


@dataclass(frozen=True)
class LoopReport:
    """Result of the tests of all loops of a bench."""

    findings: tuple[LoopFinding, ...]
    tested: tuple[str, ...]
    untested: Mapping[str, str]
    """Reason by the name of each test that was impossible."""
    margins: tuple[Mapping[str, Any], ...] = ()
    """One row for every operating point: branch, reading, signal, and margins."""

    @property
    def verdict(self) -> str:
        """Return `not sound` with a fault, `not all tested`, or `sound`."""
        faults = any(one.fault for one in self.findings)
        return "not sound" if faults else "not all tested" if self.untested else "sound"

    def to_dict(self) -> dict[str, Any]:
        """Return all fields and the verdict."""
        return asdict(self) | {"verdict": self.verdict}


LoopTest: TypeAlias = Callable[[LoopCase], Iterator[LoopFinding]]


def check_loop(bench: Bench, duration: float, *, waveforms: Mapping[str, AbstractWaveform] | None = None) -> LoopReport:
    """Test every loop of a bench.

    Args:
        bench: bench with controllers.
        duration: duration of the references [s].
        waveforms: signals of drives without a controller, by drive; their first values count.
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
    relevant = [one for one in findings if one.test != "margins" or one.where not in wrong]
    return LoopReport(tuple(sorted(relevant, key=lambda one: not one.fault)), tuple(tested), untested, tuple(margins))


def _collect_tests(margins: list[Mapping[str, Any]]) -> dict[str, LoopTest]:
    from martensite.control.margins.loop_tests import make_tests

    return {"sign": check_sign, "reach": check_reach} | make_tests(margins)


def check_reach(case: LoopCase) -> Iterator[LoopFinding]:
    """Check that the reading can be steady at all levels of the reference."""
    reached, unit, wanted_levels = case.list_reached(), case.unit, case.reference
    least, most = float(reached.min()), float(reached.max())
    ends = f"between {write_quantity(least, unit, 4)} and {write_quantity(most, unit, 4)}"
    under = f"under signals from {case.limits[0]:.4g} to {case.limits[1]:.4g}"
    for words, level, bound in (("at most", wanted_levels.max(), most), ("at least", wanted_levels.min(), least)):
        if abs(level - np.clip(level, least, most)) > BEYOND * (most - least) and (level > most) == (bound == most):
            wanted = f"The reference asks for `{case.controller.measured}` of {write_quantity(float(level), unit, 4)}"
            remedy = f"Try a reference of {words} {write_quantity(bound, unit, 3)}, or another actuator."
            sentence = f"{wanted}, but {under} it rests {ends}."
            yield case.find("reach", "references", (sentence, remedy), (level, bound, unit), fault=True)


def check_sign(case: LoopCase) -> Iterator[LoopFinding]:
    """Check that the controller raises a reading that is too low, at once and in the end."""
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
        sentence = (
            f"A higher signal {'raises' if rise > 0.0 else 'lowers'} `{name}`, but with a reference of "
            f"{write_quantity(middle, case.unit, 3)} the controller answers{when} {low:.3g} at {at[0]} and {high:.3g} "
            f"at {at[1]}: the loop drives away from its reference."
        )
        numbers = float(pushes[wrong[0]]), 0.0, "1"
        yield case.find("sign", "controllers", (sentence, "Turn the sign of its gains."), numbers, fault=True)


def _judge_idle(case: LoopCase, ends: Sequence[Mapping[str, float]]) -> LoopFinding:
    """Return the fault of a controller that responds to neither reading nor reference.

    Raises:
        InputError: it responds to the reference alone, as a feed-forward does.
    """
    name = case.controller.measured
    low, high = (_list_answers(case, ends[0], one[name], SHORT)[-1] for one in ends)
    if low != high:
        raise InputError(f"`{case.controller.registered_name}` does not answer what it reads")
    sentence = (
        f"The controller gives {low:.3g} at every `{name}` and every reference: it has no gain, so nothing is "
        "controlled."
    )
    remedy = "Give it gains, such as those of `martensite tune`."
    return case.find("sign", "controllers", (sentence, remedy), (0.0, 0.0, "1"), fault=True)


def _list_answers(
    case: LoopCase, readings: Mapping[str, float], reference: float, count: int = LONGER
) -> tuple[float, float]:
    previews = case.controller.list_previews().items()  # the own reference leads no other drive
    ahead = {f"{AHEAD}{name}.{k}": reference for name, times in previews for k in range(len(times) + 1)}
    samples = 1 if isinstance(case.controller, Mpc) else count  # a plan is made again in every sample
    signals = list(iterate_signals(case.controller, {**readings, **ahead}, reference, case.bench.period, samples))
    return signals[0], signals[-1]
