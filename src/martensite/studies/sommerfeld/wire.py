"""The beam with the heated wire: its switching, its effect, and the fit of its slack.

`LatchedOnOff` switches the wire on at 3 Hz of the rotor, and off below 30 % of its peak amplitude. The cold wire is
slack and does not influence the time of switching on; so three runs close the loop: cold, hot to the end, and hot until
switched off.
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
from martensite.studies.readings import choose_runtime
from martensite.studies.sommerfeld import runs
from martensite.studies.sommerfeld.machines import STEP, calibrated_motor, load_scenario
from martensite.studies.sommerfeld.runs import Windows, split_windows
from martensite.studies.tables import Printed

RATE = 0.2
"""Assumed rate of the voltage in all ramps with the wire [V/s]."""
PERIOD = runs.SAMPLING
"""Assumed sample time of the controller [s]."""
SHARE = 0.3
"""Assumed fraction of the peak amplitude at switch-off."""
SLACKS = (0.005, 0.010, 0.015, 0.020, 0.025)
"""Tried slacks."""
REACH = 6.0
"""Final voltage of the trials [V]; all jump before."""
NAMES = ("rotor_speed", "displacement")


def build_controller(printed: Printed) -> LatchedOnOff:
    """Return the ON/OFF controller of the thesis."""
    return LatchedOnOff(
        measured="rotor_speed",
        reference=Constant(level=2.0 * math.pi * printed.switching_frequency),
        oscillation="displacement",
        share=SHARE,
        window=runs.WINDOW,
        high=printed.wire_current,
    )


@cache
def run_ramp(slack: float, volts: float, drive: Step) -> Result:
    """Return a ramp from 0 to a voltage [V] with a current in the wire."""
    system = load_scenario().system.with_values({"slack": slack})
    duration = volts / RATE
    waves = {"motor": Ramp(high=volts, end=duration), "drive": drive}
    return simulate(system, waves, duration, step=STEP, samples=round(duration / PERIOD) + 1, runtime=choose_runtime())


def switching_times(printed: Printed, run: Result) -> list[float]:
    """Return the switching times of the controller on a recorded run [s]."""
    columns = {name: run[name].tolist() for name in NAMES}
    signals = replay_controller(build_controller(printed), run.times, columns)
    rows = zip(run.times[1:], signals, signals[1:], strict=False)
    return [time for time, before, after in rows if before != after]


@cache
def switched_on(printed: Printed) -> float:
    """Return the time of switching on [s], from a ramp without the wire."""
    cold = runs.run_course(calibrated_motor(), Ramp(high=1.0, end=1.0 / RATE), 1.0 / RATE)
    return switching_times(printed, cold)[0]


def always_on_current(printed: Printed) -> Step:
    """Return the current of the wire [A], never switched off."""
    return Step(high=printed.wire_current, at=switched_on(printed))


@dataclass(frozen=True)
class SlackTrial:
    """A ramp with the hot wire and one slack."""

    slack: float
    jump: float
    """[V]"""
    reduction: float
    """Reduction of the peak amplitude, relative to the peak without the wire."""
    sweep: Windows


@cache
def run_without_wire(printed: Printed) -> Windows:
    """Return the whole ramp without the wire."""
    return runs.run_upward(calibrated_motor(), RATE, printed.last_voltage)


@cache
def run_trial(printed: Printed, slack: float) -> SlackTrial:
    """Return the trial of a slack."""
    run = run_ramp(slack, REACH, always_on_current(printed))
    sweep = split_windows(run, calibrated_motor())
    return SlackTrial(slack, sweep.jump, 1.0 - sweep.peak / run_without_wire(printed).peak, sweep)


def run_trials(printed: Printed) -> list[SlackTrial]:
    """Return the trials of all slacks."""
    return [run_trial(printed, slack) for slack in SLACKS]


def best_trial(printed: Printed) -> SlackTrial:
    """Return the trial nearest to both published numbers, by relative errors."""

    def apart(one: SlackTrial) -> float:
        volts = one.jump / printed.jump_with_wire - 1.0
        return math.hypot(volts, (1.0 - one.reduction) / (1.0 - printed.reduction) - 1.0)

    return min(run_trials(printed), key=apart)


def slack_for(printed: Printed, name: str, value: float) -> float:
    """Return the slack for a `jump` or `reduction`, linear between trials; NaN outside."""
    tried = [(one.slack, getattr(one, name) - value) for one in run_trials(printed)]
    for (s0, d0), (s1, d1) in pairwise(tried):
        if (d0 < 0.0) != (d1 < 0.0):
            return s0 + (s1 - s0) * d0 / (d0 - d1)
    return math.nan


@dataclass(frozen=True)
class ControlledRamp:
    """The whole ramp with the wire switched by the controller."""

    on: float
    """Switch-on time [s]."""
    off: float
    """Switch-off time [s]."""
    result: Result
    sweep: Windows


@cache
def run_controlled(printed: Printed) -> ControlledRamp:
    """Return the whole ramp with the best slack."""
    slack, on = best_trial(printed).slack, switched_on(printed)
    off = switching_times(printed, run_ramp(slack, REACH, always_on_current(printed)))[1]
    drive = Step(high=printed.wire_current, at=on, until=off)
    run = run_ramp(slack, printed.last_voltage, drive)
    return ControlledRamp(on, off, run, split_windows(run, calibrated_motor()))


def agreement_voltage(printed: Printed) -> float:
    """Return the voltage up to which the amplitudes with and without the wire agree within 10 % [V]."""
    one, other = run_controlled(printed).sweep, run_without_wire(printed)
    for volts, a, b in zip(one.voltage, one.amplitude, other.amplitude, strict=False):
        if abs(a - b) > 0.1 * b and volts > 1.0:
            return float(volts)
    return math.nan
