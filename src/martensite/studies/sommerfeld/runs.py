"""Runs of the motor without a wire: from rest at one voltage, and in slow voltage changes.

A run is captured if its mean speed over the last second is below 1.5 √(k/M). A ramp jumps at the last window of 0.25 s
with a mean speed below that limit. The amplitude is half the range of a window.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.readings import choose_runtime
from martensite.studies.sommerfeld.machines import STEP, natural_frequency

SETTLING = 25.0
"""Duration of a run from rest [s]."""
SAMPLING = 2e-3
"""Sampling interval in ramps [s]."""
SPARSE = 0.02
"""Sampling interval in runs from rest [s]."""
WINDOW = 0.25
GRID = 0.1
"""Step of the voltage grid [V]."""
CAPTURED = 1.5
"""Speed limit of a captured motor, relative to √(k/M)."""


@dataclass(frozen=True)
class SettledRun:
    """The end of a run from rest."""

    voltage: float
    speed: float
    """Mean over the last second [rad/s]."""
    amplitude: float
    """Over the last two seconds [m]."""
    captured: bool


@cache
def from_rest(motor: BeamMotor, volts: float) -> SettledRun:
    """Return the end of a run from rest at a voltage [V], after 25 s."""
    run = simulate(
        Machine(mechanism=motor),
        {"motor": Constant(level=volts)},
        SETTLING,
        step=STEP,
        samples=round(SETTLING / SPARSE) + 1,
        runtime=choose_runtime(),
    )
    second = round(1.0 / SPARSE)
    speed = float(np.mean(run["rotor_speed"][-second:]))
    size = 0.5 * float(np.ptp(run["displacement"][-2 * second :]))
    return SettledRun(volts, speed, size, speed < CAPTURED * natural_frequency(motor))


@cache
def last_captured(motor: BeamMotor, first: float = 6.0) -> float:
    """Return the last captured voltage [V] of a grid of 0.1 V from `first` on."""
    return find_last(lambda volts: from_rest(motor, volts).captured, first)


def find_last(captured: Callable[[float], bool], first: float) -> float:
    """Return the last captured voltage [V] of a grid of 0.1 V from `first` on, for a given test."""
    number = round(first / GRID)
    while captured(round(number * GRID, 10)):
        number += 1
    return round((number - 1) * GRID, 10)


@dataclass(frozen=True)
class Windows:
    """A run in windows of 0.25 s; arrays of equal length."""

    voltage: Any
    """In the middle of the window [V]."""
    amplitude: Any
    """[m]"""
    speed: Any
    """Mean [rad/s]."""
    current: Any
    """Mean current of the motor [A]."""
    limit: float
    """Speed limit of a captured motor [rad/s]."""

    @property
    def end(self) -> int:
        """Return the last captured window."""
        return int(np.flatnonzero(self.speed < self.limit)[-1])

    @property
    def jump(self) -> float:
        """Return the voltage of the jump [V]."""
        return float(self.voltage[self.end])

    @property
    def peak(self) -> float:
        """Return the largest amplitude [m]."""
        return float(self.amplitude.max())

    @property
    def most_current(self) -> float:
        """Return the largest mean current up to the jump [A]."""
        return float(self.current[: self.end + 1].max())


def split_windows(run: Result, motor: BeamMotor) -> Windows:
    """Return a run in windows."""
    size = round(WINDOW / (run.times[1] - run.times[0]))
    count = len(run.times) // size

    def cut(name: str) -> Any:
        return np.asarray(run[name][: count * size]).reshape(count, size)

    return Windows(
        cut("motor").mean(axis=1),
        0.5 * np.ptp(cut("displacement"), axis=1),
        cut("rotor_speed").mean(axis=1),
        cut("motor_current").mean(axis=1),
        CAPTURED * natural_frequency(motor),
    )


@cache
def run_course(motor: BeamMotor, wave: AbstractWaveform, duration: float) -> Result:
    """Return a run under a changing voltage."""
    return simulate(
        Machine(mechanism=motor),
        {"motor": wave},
        duration,
        step=STEP,
        samples=round(duration / SAMPLING) + 1,
        runtime=choose_runtime(),
    )


def run_upward(motor: BeamMotor, rate: float, volts: float) -> Windows:
    """Return the windows of a ramp from rest to a voltage [V] at a rate [V/s]."""
    duration = volts / rate
    return split_windows(run_course(motor, Ramp(high=volts, end=duration), duration), motor)


def run_downward(motor: BeamMotor, rate: float, volts: tuple[float, float]) -> Windows:
    """Return the windows of a free motor under a voltage falling from one value [V] to another at a rate [V/s]."""
    high, low = volts
    free = 10.0
    times = (0.0, 5.0, 25.0, 55.0, 55.0 + (high - low) / rate)
    wave = Table(times=times, values=(free, free, high, high, low))
    windows = split_windows(run_course(motor, wave, times[-1]), motor)
    late = slice(math.ceil(times[3] / WINDOW), None)
    return Windows(
        windows.voltage[late], windows.amplitude[late], windows.speed[late], windows.current[late], windows.limit
    )


def dropped_below(windows: Windows, speed: float) -> float:
    """Return the voltage [V] below which a downward sweep stays under a speed [rad/s]."""
    return float(windows.voltage[int(np.flatnonzero(windows.speed > speed)[-1])])
