"""Simulated heating and cooling of a strand: currents for a time, times for a current.

A cycle is one pulse from the cold state and the cooling after it. Heating ends at the stroke; the return ends when 2 %
of the stroke remain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from martensite.actuators.assembly import System
from martensite.base.status import Status
from martensite.kernels.brent import find_root
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.step import Step
from martensite.simulate.alarms import Alarm, Values, find_excursion
from martensite.simulate.api import simulate
from martensite.simulate.judgement import judge_run
from martensite.simulate.result import Result

RETURNED = 0.02
"""Remaining fraction of the stroke at the end of the return."""
STEPS = 100
"""Steps within the heating time."""
MOST_STEPS = 4000
"""Largest number of steps of a cycle."""
RUNNING = 4
"""Cycles after which the peak temperature has almost settled."""
TOLERANCE = 4e-4
"""Relative tolerance of a current; the result is within twice of it and reaches the stroke."""
WIDENINGS = 12
FIRST_FACTOR = 2.0
"""Factor between the bounds of a current."""
WINDOWS = (6.0, 16.0)
"""First and last time of the search for the return, in time constants."""


@dataclass(frozen=True)
class PulseCycle:
    """Current pulse through a strand, and the cooling after it."""

    current: float
    """[A]"""
    heating: float
    """Time until the stroke is reached [s]."""
    cooling: float | None
    """Time of the return [s]; None if it never ends."""
    hottest: float
    """Highest temperature in the first cycle [K]."""
    running: float | None = None
    """Highest temperature in `RUNNING` cycles at the requested rate [K]; None if the rate is not reached."""
    exceeded: tuple[Alarm, ...] = ()
    """Exceeded limits of the element, in the first cycle or repeated cycles."""

    @property
    def fastest(self) -> float | None:
        """Return the highest rate [Hz]; None if the wire does not return."""
        return None if self.cooling is None else 1.0 / (self.heating + self.cooling)

    def keeps(self, period: float) -> bool:
        """Return true if heating and cooling fit into a period [s]."""
        return self.fastest is not None and self.fastest * period >= 1.0 - 1e-9


def simulate_pulse(system: System, current: float, time: float) -> float:
    """Return the position [m] at the end of a pulse of `current` [A] and `time` [s].

    It is the largest position if the wire would melt or tear before.
    """
    run = simulate(system, Step(high=current), time, step=time / STEPS, samples=STEPS + 1)
    left = run.status is Status.OUT_OF_ENVELOPE
    return run.find_range("position")[1] if left else float(run["position"][-1])


def find_current(
    system: System, position: float, time: float, guess: float, factor: float = FIRST_FACTOR
) -> float | None:
    """Return the smallest constant current [A] that reaches `position` [m] in `time` [s], within 0.1 %.

    It is None if no current up to some thousand times `guess` [A] suffices. The search begins between the guess and the
    guess divided by `factor`.
    """
    high = guess
    for _ in range(WIDENINGS):
        if simulate_pulse(system, high, time) >= position:
            break
        high, factor = high * factor, FIRST_FACTOR
    else:
        return None
    low = high / factor
    while simulate_pulse(system, low, time) >= position:
        high, low = low, low / FIRST_FACTOR
    ends = math.log(low), math.log(high)
    root = find_root(lambda x: simulate_pulse(system, math.exp(x), time) - position, *ends, TOLERANCE)
    return math.exp(root + TOLERANCE)


def find_reach_time(system: System, position: float, current: float, longest: float) -> float | None:
    """Return the time [s] at which a constant current first reaches `position` [m], or None."""
    samples = 10 * STEPS + 1
    step = longest / (samples - 1)
    run = simulate(system, Step(high=current), longest, step=step, samples=samples)
    times, columns = run.draw_curves(["position"])
    return find_crossing(times, columns["position"], position)


def simulate_cycle(system: System, position: float, current: float, heating: float, time_constant: float) -> PulseCycle:
    """Return the cycle with a pulse of `current` [A] that lasts `heating` [s]."""
    left = RETURNED * position
    run, cooling = simulate_cooling(system, left, current, heating, time_constant)
    return PulseCycle(current, heating, cooling, run.find_range("temperature")[1], exceeded=judge_run(run).alarms)


def repeat_pulse(system: System, cycle: PulseCycle, rate: float) -> PulseCycle:
    """Return the cycle with the results of pulses repeated at a rate [Hz].

    Later pulses start from a warmer wire and heat it beyond the stroke.
    """
    pulses = PulseWidthModulation(high=cycle.current, frequency=rate, duty=cycle.heating * rate)
    step = max(cycle.heating / STEPS, 1.0 / rate / MOST_STEPS * RUNNING)
    run = simulate(system, pulses, RUNNING / rate, step=step, samples=401)
    exceeded = judge_run(run).alarms or cycle.exceeded
    return replace(cycle, running=run.find_range("temperature")[1], exceeded=exceeded)


def simulate_cooling(
    system: System, left: float, current: float, heating: float, time_constant: float
) -> tuple[Result, float | None]:
    """Return the run of a pulse and the time [s] until only `left` [m] of the stroke remain."""
    pulse = Step(high=current, until=heating)
    soon, late = (heating + window * time_constant for window in WINDOWS)
    run = _run_pulse(system, pulse, soon)
    time = _find_fall_time(run, heating, left)
    if time is None:
        run = _run_pulse(system, pulse, late)
        time = _find_fall_time(run, heating, left)
    return run, time


def _run_pulse(system: System, pulse: Step, duration: float) -> Result:
    step = max(pulse.until / STEPS, duration / MOST_STEPS)
    return simulate(system, pulse, duration, step=step, samples=2001)


def _find_fall_time(run: Result, start: float, level: float) -> float | None:
    """Return the time after `start` [s] at which the position has fallen to a level [m]."""
    times, columns = run.draw_curves(["position"])
    after = times >= start
    time = find_crossing(times[after], -columns["position"][after], -level)
    return None if time is None else time - start


def find_crossing(times: Values, values: Values, level: float) -> float | None:
    """Return the first interpolated time at which `values` exceed `level`, or None."""
    above = find_excursion(times, np.asarray(values, float) - level)
    return None if above is None else above.first
