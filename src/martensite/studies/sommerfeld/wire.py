"""The beam with the heated wire: when it is switched, what it does, and which slack fits.

The wire is switched by `LatchedOnOff`: on at 3 Hz of the rotor, off once the amplitude is below
30 % of its peak. Cold, the wire is slack and cannot influence what switches it on; hot, it
cannot know when it will be switched off. So three runs close the loop: cold, hot to the end, and
hot until then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

from martensite.control.controllers.latched_on_off import LatchedOnOff, replay_controller
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.readings import runtime
from martensite.studies.sommerfeld import runs
from martensite.studies.sommerfeld.machines import (
    STEP,
    calibrated_motor,
    scenario,
)
from martensite.studies.sommerfeld.runs import Windows, windows
from martensite.studies.tables import Printed

RATE = 0.2
"""Of the voltage in all ramps with the wire [V/s]: assumed."""
PERIOD = runs.SAMPLING
"""Of the controller [s]: assumed."""
SHARE = 0.3
"""Of the peak amplitude, below which the wire is switched off: assumed."""
SLACKS = (0.005, 0.010, 0.015, 0.020, 0.025)
"""Tried in the fit."""
REACH = 6.0
"""Voltage to which they are tried [V]; all jump before."""
NAMES = ("rotor_speed", "displacement")


def controller(printed: Printed) -> LatchedOnOff:
    """The ON/OFF controller of the thesis."""
    return LatchedOnOff(
        measured="rotor_speed",
        reference=Constant(level=2.0 * math.pi * printed.switching_frequency),
        oscillation="displacement",
        share=SHARE,
        window=runs.WINDOW,
        high=printed.wire_current,
    )


@cache
def run(slack: float, volts: float, drive: Step) -> Result:
    """A ramp from 0 to a voltage [V] with a current in the wire."""
    system = scenario().system.with_values({"slack": slack})
    duration = volts / RATE
    waves = {"motor": Ramp(high=volts, end=duration), "drive": drive}
    return simulate(
        system,
        waves,
        duration,
        step=STEP,
        samples=round(duration / PERIOD) + 1,
        runtime=runtime(),
    )


def switchings(printed: Printed, found: Result) -> list[float]:
    """Times at which the controller would have switched along a run [s]."""
    columns = {name: found[name].tolist() for name in NAMES}
    signals = replay_controller(controller(printed), found.times, columns)
    rows = zip(found.times[1:], signals, signals[1:], strict=False)
    return [time for time, before, after in rows if before != after]


@cache
def switched_on(printed: Printed) -> float:
    """When the wire is switched on [s]: along a ramp without it."""
    cold = runs.course(calibrated_motor(), Ramp(high=1.0, end=1.0 / RATE), 1.0 / RATE)
    return switchings(printed, cold)[0]


def always(printed: Printed) -> Step:
    """Current of the wire [A] that is never switched off."""
    return Step(high=printed.wire_current, at=switched_on(printed))


@dataclass(frozen=True)
class SlackTrial:
    """A ramp with the wire on, with one slack."""

    slack: float
    jump: float
    """[V]"""
    reduction: float
    """Of the peak amplitude, as a share of that without the wire."""
    sweep: Windows


@cache
def without(printed: Printed) -> Windows:
    """The whole ramp without the wire."""
    return runs.upward(calibrated_motor(), RATE, printed.last_voltage)


@cache
def trial(printed: Printed, slack: float) -> SlackTrial:
    """The ramp with a slack."""
    found = run(slack, REACH, always(printed))
    sweep = windows(found, calibrated_motor())
    return SlackTrial(slack, sweep.jump, 1.0 - sweep.peak / without(printed).peak, sweep)


def trials(printed: Printed) -> list[SlackTrial]:
    """The ramp with every slack."""
    return [trial(printed, slack) for slack in SLACKS]


def best(printed: Printed) -> SlackTrial:
    """The slack tried that comes nearest to both published numbers, by their relative errors."""

    def apart(one: SlackTrial) -> float:
        volts = one.jump / printed.jump_with_wire - 1.0
        return math.hypot(volts, (1.0 - one.reduction) / (1.0 - printed.reduction) - 1.0)

    return min(trials(printed), key=apart)


def slack_for(printed: Printed, name: str, value: float) -> float:
    """Slack at which `jump` or `reduction` has a value, linear between those tried; else NaN."""
    tried = [(one.slack, getattr(one, name) - value) for one in trials(printed)]
    for (s0, d0), (s1, d1) in pairwise(tried):
        if (d0 < 0.0) != (d1 < 0.0):
            return s0 + (s1 - s0) * d0 / (d0 - d1)
    return math.nan


@dataclass(frozen=True)
class Controlled:
    """The whole ramp with the wire switched by the controller."""

    on: float
    """[s]"""
    off: float
    """[s]"""
    result: Result
    sweep: Windows


@cache
def controlled(printed: Printed) -> Controlled:
    """The whole ramp with the best slack."""
    slack, on = best(printed).slack, switched_on(printed)
    off = switchings(printed, run(slack, REACH, always(printed)))[1]
    drive = Step(high=printed.wire_current, at=on, until=off)
    found = run(slack, printed.last_voltage, drive)
    return Controlled(on, off, found, windows(found, calibrated_motor()))


def agreement(printed: Printed) -> float:
    """Voltage up to which the amplitudes with and without the wire agree within 10 % [V]."""
    one, other = controlled(printed).sweep, without(printed)
    for volts, a, b in zip(one.voltage, one.amplitude, other.amplitude, strict=False):
        if abs(a - b) > 0.1 * b and volts > 1.0:
            return float(volts)
    return math.nan
