"""Error of averaging: a run with a mean duty cycle compared with a run of every pulse.

With the power P_on in the element while the switch is closed, a pulse of the fraction D of a period 1/f raises the
temperature by

    ΔT ≈ P_on D (1 - D)/(f C)

above its slow variation. C is the heat capacity. This holds without transformation for periods short beside the thermal
time constant; latent heat lowers the rise. The mean temperature differs in proportion to 1/f, because a pulse starts
its period.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import System
from martensite.base.errors import InputError
from martensite.control.controllers.constant_power import ConstantPower
from martensite.physics.electrical.switches import PowerPwm, PwmVoltage
from martensite.signals.base import AbstractDrive, AbstractWaveform
from martensite.simulate.api import first_step, simulate
from martensite.simulate.closed_loop import LoopResult, simulate_loop
from martensite.simulate.result import Result

COMPARED = ("temperature", "position", "power")


@dataclass(frozen=True)
class Difference:
    """Difference of the means over the periods of the pulses from the averaged run at mid-period, in SI."""

    largest: float
    """Largest absolute difference."""
    rms: float
    """Root mean square difference."""


@dataclass(frozen=True)
class Averaging:
    """Averaged run beside its pulses."""

    frequency: float
    """[Hz]"""
    differences: dict[str, Difference]
    """Differences of temperature, position and power."""
    ripple: float
    """Largest rise of temperature in a pulse above the straight line through its period [K]."""
    estimate: float
    """Largest P_on D (1 - D)/(f C) [K]."""
    average: Result
    pulsed: LoopResult


def compare_averaging(
    system: System,
    waveform: AbstractWaveform,
    duration: float,
    frequency: float,
    *,
    shortest: float = 0.0,
    step: float | None = None,
) -> Averaging:
    """Compare the averaged run of a switched drive with a run of every pulse.

    Args:
        system: plant with the drive `pwm-voltage`, or `power-pwm`, whose pulses come from the constant-power loop.
        waveform: duty cycle, or demanded power [W].
        duration: length of the runs [s]; whole periods are compared.
        frequency: pulse frequency [Hz].
        shortest: shortest pulse or gap of the switch [s].
        step: longest step [s], by default a tenth of the thermal time constant.

    Raises:
        InputError: the drive is not a switch, or an argument is out of range.
        SolveError: one of the runs failed.
    """
    switched, drive = switch_plant(system, waveform)
    if not (0.0 < frequency < math.inf and duration * frequency >= 1.0 - 1e-9):
        raise InputError(
            f"The carrier must make at least one period in {duration:.6g} s, but its frequency is {frequency:.6g} Hz."
        )
    periods, period = int(duration * frequency + 1e-9), 1.0 / frequency
    step = min(first_step(system, duration, 2), 0.5 * period) if step is None else step
    average = simulate(system, waveform, periods * period, step=step, samples=2 * periods + 1)
    pulsed = simulate_loop(switched, drive, periods * period, period, pulses=True, shortest=shortest, step=step)
    for run in (average, pulsed.result):
        run.require()
    differences = {name: _compare_runs(pulsed.means[name], average[name][1::2].tolist()) for name in COMPARED}
    capacity = system.element.heat_capacity_total()
    estimate = max(
        power * (1.0 - duty) * period / capacity
        for power, duty in zip(pulsed.means["power"], pulsed.means["drive"], strict=True)
    )
    return Averaging(frequency, differences, max(measure_ripples(pulsed)), estimate, average, pulsed)


def switch_plant(system: System, waveform: AbstractWaveform) -> tuple[System, AbstractDrive]:
    """Return the system with a bare switch, and the drive of its duty cycle; `InputError` for other sources."""
    source = system.source
    if isinstance(source, PwmVoltage):
        return system, waveform
    if not isinstance(source, PowerPwm):
        raise InputError(f"Pulses need the drive `pwm-voltage` or `power-pwm`, but it is `{source.registered_name}`.")
    switch = PwmVoltage(
        supply=source.supply, series_resistance=source.series_resistance, current_limit=source.current_limit
    )
    once = source.measured == "once"
    largest = source.reach(source.reference_resistance).most if once else 0.0
    drive = ConstantPower(reference=waveform, updated=source.measured, largest=largest)
    return system.with_parts(source=switch), drive


def measure_ripples(pulsed: LoopResult) -> list[float]:
    """Return the rise of temperature in each pulse above the straight line through its period [K]."""
    starts, ends = pulsed.result["temperature"].tolist(), pulsed.ends["temperature"]
    shares = pulsed.means["drive"]
    return [
        end - (begin + share * (after - begin))
        for begin, end, after, share in zip(starts, ends, starts[1:], shares, strict=False)
    ]


def _compare_runs(pulsed: Sequence[float], average: Sequence[float]) -> Difference:
    apart = [p - a for p, a in zip(pulsed, average, strict=True)]
    mean_square = sum(d * d for d in apart) / len(apart)
    return Difference(max(map(abs, apart)), math.sqrt(mean_square))
