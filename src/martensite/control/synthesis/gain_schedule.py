"""Schedule of PI gains over the stroke, for heating and cooling, with equal sensitivity at all points.

    C(z) = K_p (1 + (T/T_i)/(1 - z⁻¹)),    largest K_p/T_i with max |1/(1 + C P)| ≤ M_s

for the linear plant P at each operating point of both branches: the largest integral gain gives the least integral of
the error after a disturbance (Åström, Panagopoulos and Hägglund 1998). The gain of the plant changes over its stroke
and between the branches; a single pair of gains must fit the steepest point.
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
"""Number of integral times and of gains, decades of gains, and bisections of the best gain."""
MARKS = "rising", "falling"


@dataclass(frozen=True)
class ScheduledPoint:
    """Gains at an operating point."""

    branch: str
    at: float
    """Reading at the point, in SI."""
    Kp: float
    Ki: float
    """[1/s]"""


@dataclass(frozen=True)
class DesignedSchedule:
    """A controller with a gain schedule, and the points of the schedule."""

    drive: str
    unit: str
    period: float
    """Period of the bench [s]."""
    points: tuple[ScheduledPoint, ...]
    controller: ScheduledPid

    def to_toml(self, text: str) -> str:
        """Return the text of a scenario with its controller replaced by this one."""
        from martensite.base.toml_text import as_toml

        document = tomllib.loads(text)
        section = document["controller"] if "controller" in document else document["controllers"][self.drive]
        shared = {name: section[name] for name in ("period", "low", "high") if name in section}
        section.clear()
        section.update(
            {"kind": "scheduled-pid", "measured": self.controller.measured, **shared, "gains_are": "in-seconds"}
        )
        for mark, branch in zip(MARKS, ("heating", "cooling"), strict=True):
            rows = [one for one in self.points if one.branch == branch]
            section[mark] = {f"p{k}": self._write_point(one) for k, one in enumerate(rows, start=1)}
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
        bench: bench with a controller, whose limits, reading and reference are kept.
        duration: duration of the reference along which the points lie [s].
        drive: drive of the loop; default: the first.
        sensitivity: M_s, above 1.
        count: number of points of a branch.
        waveforms: signals of drives without a controller; their first values count.

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
    """Return K_p and K_i [1/s] of the PI controller with the largest integral gain within a sensitivity.

    Raises:
        InputError: the plant has no static gain.
    """
    omega, rest = list_frequencies(plant.interval), float(plant.gain()[0, 0])
    times = plant.time_constants()
    if rest == 0.0 or not len(times):
        raise InputError("The plant does not answer the signal here: there are no gains for it.")
    response = evaluate_response(plant, omega)
    integrator = plant.interval / (1.0 - np.exp(-1j * omega * plant.interval))
    best = 0.0, 0.0
    for integral_time in np.geomspace(0.02, 2.0, TIMES) * times[0]:
        gain = _find_gain(response * (1.0 + integrator / integral_time) * np.sign(rest), sensitivity, abs(rest))
        if gain / integral_time > best[1]:
            best = gain, gain / integral_time
    return float(np.sign(rest) * best[0]), float(np.sign(rest) * best[1])


def _find_gain(loop: Numbers, sensitivity: float, size: float) -> float:
    def exceeds(gain: float) -> bool:
        return bool(np.min(np.abs(1.0 + gain * loop)) < 1.0 / sensitivity)

    gains = np.geomspace(10.0**-DECADES, 10.0**DECADES, GAINS) / size
    k = next((k for k, gain in enumerate(gains) if exceeds(gain)), len(gains))
    if k in (0, len(gains)):
        return 0.0
    low, high = gains[k - 1], gains[k]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if exceeds(middle) else (middle, high)
    return float(low)
