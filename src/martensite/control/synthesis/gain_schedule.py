"""A schedule of PI gains over the stroke, heating and cooling, with the same sensitivity at every point.

    C(z) = K_p (1 + (T/T_i)/(1 - z⁻¹)),    largest K_p/T_i with max |1/(1 + C P)| ≤ M_s

for the linear plant P at every operating point of both branches: the largest integral gain is the least integral of the
error after a disturbance (Åström, Panagopoulos and Hägglund 1998). The gain of the plant changes over its stroke, and
from one branch to the other; one pair of gains must be small enough for the steepest point, a schedule need not.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import InputError, ParameterError, require_known
from martensite.control.controllers.pid import PidLaw
from martensite.control.controllers.scheduled_pid import GainsAt, GainSchedule, ScheduledPid
from martensite.control.loop.bench import Bench
from martensite.control.margins.linear_loop import LinearLoop
from martensite.control.margins.loop_case import LoopCase
from martensite.control.margins.loop_points import linearise_case
from martensite.control.margins.margins import evaluate_response, list_frequencies
from martensite.identify.chains.linear_system import LinearSystem
from martensite.signals.base import AbstractWaveform
from martensite.signals.sampling.sampled import Numbers

TIMES, GAINS, DECADES, HALVINGS = 41, 81, 4.0, 40
"""Integral times and gains that are tried, over how many decades, and halvings of the interval of the best gain."""
MARKS = "rising", "falling"


@dataclass(frozen=True)
class ScheduledPoint:
    """Gains at an operating point."""

    branch: str
    at: float
    """Reading there, in SI."""
    Kp: float
    Ki: float
    """[1/s]"""


@dataclass(frozen=True)
class DesignedSchedule:
    """A controller whose gains follow a schedule, and its points."""

    drive: str
    unit: str
    """SI unit of the reading."""
    period: float
    """Period of the bench [s]."""
    points: tuple[ScheduledPoint, ...]
    controller: ScheduledPid

    def to_toml(self, text: str) -> str:
        """Return the scenario, given as text, with this controller in place of its present one."""
        from martensite.base.toml_text import as_toml

        document = tomllib.loads(text)
        own = document["controller"] if "controller" in document else document["controllers"][self.drive]
        kept = {name: own[name] for name in ("period", "low", "high") if name in own}
        own.clear()
        own.update({"kind": "scheduled-pid", "measured": self.controller.measured, **kept, "gains_are": "in-seconds"})
        for mark, branch in zip(MARKS, ("heating", "cooling"), strict=True):
            rows = [one for one in self.points if one.branch == branch]
            own[mark] = {f"p{k}": self._write_point(one) for k, one in enumerate(rows, start=1)}
        return as_toml(document)

    def _write_point(self, one: ScheduledPoint) -> dict[str, Any]:
        at = one.at if self.unit == "1" else f"{one.at:.6g} {self.unit}"
        return {"at": at, "Kp": float(f"{one.Kp:.6g}"), "Ki": float(f"{one.Ki:.6g}")}


def design_gain_schedule(
    bench: Bench,
    duration: float,
    *,
    drive: str | None = None,
    sensitivity: float = 1.4,
    count: int = 4,
    waveforms: Mapping[str, AbstractWaveform] | None = None,
) -> DesignedSchedule:
    """Design gains over the reference, with the same largest sensitivity at points of both branches.

    Args:
        bench: with a controller, whose limits, reading and reference are kept.
        duration: of the run along whose reference the points lie [s].
        drive: whose loop; the first if not named.
        sensitivity: M_s, above 1.
        count: points of a branch.
        waveforms: of drives that no controller has; their first values count.

    Raises:
        InputError: the loop does not exist, or it has no linear system.
        ParameterError: M_s is not above 1.
    """
    if not sensitivity > 1.0:
        raise ParameterError(f"The largest sensitivity must be above 1, but is {sensitivity:g}.")
    members = bench.controllers.members()
    if not members:
        raise InputError("A bench without a controller has no loop to schedule gains of.")
    name = drive or next(iter(members))
    require_known("controller", name, members)
    others = {key: float(one.value(0.0)) for key, one in (waveforms or {}).items()}
    case = LoopCase(bench, name, members[name], duration, others)
    loops = [one for one in linearise_case(case, count) if one.branch != "dead band"]
    points = tuple(_design_point(one, sensitivity) for one in loops)
    tables = [_tabulate_gains([one for one in points if one.branch == branch]) for branch in ("heating", "cooling")]
    low, high = case.limits
    controller = ScheduledPid(
        measured=case.controller.measured,
        reference=case.controller.reference,
        rising=tables[0],
        falling=tables[1],
        gains_are="in-seconds",
        law=PidLaw(low=low, high=high),
    )
    return DesignedSchedule(name, case.unit, bench.period, points, controller)


def _tabulate_gains(points: list[ScheduledPoint]) -> GainSchedule:
    ordered = sorted(points, key=lambda one: one.at)
    rows = {f"p{k}": GainsAt(at=one.at, Kp=one.Kp, Ki=one.Ki) for k, one in enumerate(ordered, start=1)}
    return GainSchedule(**rows)


def _design_point(one: LinearLoop, sensitivity: float) -> ScheduledPoint:
    Kp, Ki = design_pi(one.plant, sensitivity)
    return ScheduledPoint(one.branch, one.reading, Kp, Ki)


def design_pi(plant: LinearSystem, sensitivity: float) -> tuple[float, float]:
    """K_p and K_i [1/s] of the PI controller with the largest integral gain within a largest sensitivity.

    Raises:
        InputError: the plant has no gain at rest.
    """
    omega, rest = list_frequencies(plant.interval), float(plant.gain()[0, 0])
    times = plant.time_constants()
    if rest == 0.0 or not len(times):
        raise InputError("The plant does not answer the signal here: there are no gains for it.")
    response = evaluate_response(plant, omega)
    share = plant.interval / (1.0 - np.exp(-1j * omega * plant.interval))
    best = 0.0, 0.0
    for integral_time in np.geomspace(0.02, 2.0, TIMES) * times[0]:
        gain = _find_gain(response * (1.0 + share / integral_time) * np.sign(rest), sensitivity, abs(rest))
        if gain / integral_time > best[1]:
            best = gain, gain / integral_time
    return float(np.sign(rest) * best[0]), float(np.sign(rest) * best[1])


def _find_gain(loop: Numbers, sensitivity: float, size: float) -> float:
    """Return the gain up to which max |1/(1 + K L)| stays within a bound, from small ones on."""

    def exceeds(gain: float) -> bool:
        return bool(np.min(np.abs(1.0 + gain * loop)) < 1.0 / sensitivity)

    tried = np.geomspace(10.0**-DECADES, 10.0**DECADES, GAINS) / size
    k = next((k for k, gain in enumerate(tried) if exceeds(gain)), len(tried))
    if k in (0, len(tried)):
        return 0.0
    low, high = tried[k - 1], tried[k]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if exceeds(middle) else (middle, high)
    return float(low)
