"""Limit cycles of on/off loops: the period is unknown, and events end it.

    on   until y ≥ upper, then for the delay still on
    off  until y < upper - band, then for the delay still off, and so on

The motion from one switching off to the next is a map of the state. Event times are found within a step to rounding
and depend on the state: with s' = ds/dτ at the end of a leg and the gradient g of y there,

    dτ = -(g · J ds)/(g · s'),        d(state) = J ds + s' dτ.

With `sampling` the controller switches at samples, and event times do not depend on the state. Such a loop has a cycle
only if it locks to its samples.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, ParameterError, SolveError, require_known
from martensite.control.controllers.relay import OnOff
from martensite.control.sensors.position import IdealSensor
from martensite.kernels.brent import find_root
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step
from martensite.simulate.steady.continuation import LinearisedEquations
from martensite.simulate.steady.cycles import PeriodicOrbit, ShootingMethod
from martensite.simulate.steady.equilibria import rest_signals
from martensite.simulate.steady.periodic_motion import find_inert, judge_stability
from martensite.simulate.steady.stretch import Stretch

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

CYCLES = 300
BLOCK, BLOCKS = 256, 400
"""Steps between two searches for an event, and number of searches."""


@dataclass(frozen=True)
class Switch:
    """An on/off controller with a dead band."""

    output: str
    upper: float
    """Threshold for switching off, in SI."""
    band: float
    """Distance below `upper` for switching on, above 0."""
    high: float
    """Drive while it is on."""
    low: float = 0.0
    delay: float = 0.0
    """Delay of the measurement [s]."""
    drive: str | None = None
    sampling: float = 0.0
    """Sample period [s]; 0 for a continuous switch."""


@dataclass(frozen=True, eq=False)
class SwitchedCycle(PeriodicOrbit):
    """A limit cycle of an on/off loop, from one switching off to the next."""

    on_time: float = 0.0
    """Time in a period for which the drive is on [s]."""


def find_switched_cycle(
    subject: Scenario | AbstractSystem, switch: Switch | None = None, *, step: float | None = None
) -> SwitchedCycle:
    """Find the limit cycle of a plant that is switched on and off.

    Args:
        subject: a scenario with one `on-off` controller of a constant reference, or a plant.
        switch: switch of the plant; default: the controller of the scenario.
        step: longest step [s]; default: the longest step of the plant.

    Raises:
        InputError: the scenario has no such controller, or a name is unknown.
        CompileError: no C compiler was found.
        SolveError: a threshold is not reached, or the cycle does not repeat.
    """
    system = subject if isinstance(subject, AbstractSystem) else subject.system
    if switch is None:
        if isinstance(subject, AbstractSystem):
            raise InputError("A plant alone is not switched; give a `switch`.")
        switch = read_switch(subject)
    motion = SwitchedMotion(system, switch, step or longest_step(system))
    shooting = ShootingMethod(motion, motion.heat_up(), CYCLES)
    shooting.run()
    times, outputs = motion.observe(shooting.state)
    _, slopes = motion.march(shooting.state)
    stability = judge_stability(slopes)
    return SwitchedCycle(
        system,
        float(times[-1]),
        times,
        outputs,
        shooting.state,
        stability,
        shooting.period_change,
        shooting.count,
        motion.on_time,
    )


def read_switch(scenario: Scenario) -> Switch:
    """Return the switch of a scenario.

    Raises:
        InputError: the scenario has not one `on-off` controller with a constant reference and a plain sensor.
    """
    bench = scenario.bench
    members = {} if bench is None else bench.controllers.members()
    drive, one = next(iter(members.items()), ("", None))
    if bench is None or len(members) != 1 or not isinstance(one, OnOff):
        raise InputError(f"Scenario `{scenario.title}` has not one controller `on-off`, whose cycle could be found.")
    mounted = bench.sensors.members().get(one.measured)
    output = one.measured if mounted is None else mounted.of
    if mounted is not None and not isinstance(mounted.sensor, IdealSensor):
        raise InputError(
            f"The sensor `{mounted.sensor.registered_name}` of `{one.measured}` lags or has noise of its own; the "
            "cycle is that of an `ideal` sensor, which may be late."
        )
    output = output if isinstance(output, str) else output[0]
    if not isinstance(one.reference, Constant) or output not in scenario.system.outputs():
        raise InputError("The cycle of an ON/OFF loop needs a constant reference and a sensor of one output.")
    late = 0.0 if mounted is None else float(mounted.delay)
    reference = one.reference.value(0.0)
    levels = float(one.high), float(one.low)
    return Switch(output, reference, float(one.band), *levels, late, drive, float(bench.period))


class _Leg:
    """Steps with a constant drive."""

    def __init__(self, states: Numbers, lengths: Numbers, level: float) -> None:
        self.states, self.lengths, self.level = states, lengths, level


class SwitchedMotion:
    """Map of the state from one switching off to the next."""

    settled = 1e-6
    """Change over a period below which a state repeats."""

    def __init__(self, system: AbstractSystem, switch: Switch, step: float) -> None:
        names = [one.name for one in system.drives()]
        drive = switch.drive or names[0]
        require_known("drive", drive, names)
        require_known("output", switch.output, list(system.outputs()))
        if not switch.band > 0.0:
            raise ParameterError(
                "An ON/OFF loop without a dead band chatters and has no cycle; `band` must be above 0."
            )
        self.stretch, self.switch = Stretch(system), replace(switch, drive=drive)
        self.looks = max(int(np.ceil(switch.sampling / step - 1e-9)), 1)
        """Steps in a sample."""
        self.step = switch.sampling / self.looks if switch.sampling > 0.0 else step
        self.size, self.place = self.stretch.size, names.index(drive)
        self.rest = rest_signals(system)
        self.on_time = 0.0
        self._cached: tuple[Numbers, list[_Leg]] | None = None

    def heat_up(self) -> Numbers:
        """Return the state at the first switching off, from the steady state."""
        state = self.stretch.rest(list(self.rest))
        return self._pass(state, on=True)[-1].states[-1]

    def go_on(self, state: Numbers) -> Numbers:
        """Return the state at the next switching off."""
        return self._legs(state)[-1].states[-1]

    def measure_change(self, state: Numbers) -> float:
        """Return the largest change of an output over a period, relative to its convergence scale.

        Rates and other values of the last step differ by rounding over the short step to an event, so states are not
        compared.
        """
        scales = self.stretch.system.convergence_scales()
        ends = np.array([state, self.go_on(state)])
        outputs = self.stretch.observe(ends, np.tile(self.signals_at_begin(), (2, 1)))
        return max(abs(float(outputs[name][1] - outputs[name][0])) / size for name, size in scales.items())

    def signals_at_begin(self) -> Numbers:
        """Return all drives at switching off."""
        return self._signals(self.switch.low)

    def _signals(self, level: float) -> Numbers:
        signals = self.rest.copy()
        signals[self.place] = level
        return signals

    def _legs(self, state: Numbers) -> list[_Leg]:
        if self._cached is None or not np.array_equal(self._cached[0], state):
            off = self._pass(state, on=False)
            on = self._pass(off[-1].states[-1], on=True)
            self.on_time = float(sum(leg.lengths.sum() for leg in on))
            self._cached = (np.array(state), [*off, *on])
        return self._cached[1]

    def _pass(self, state: Numbers, on: bool) -> list[_Leg]:
        switch = self.switch
        level = switch.high if on else switch.low
        threshold = switch.upper if on else switch.upper - switch.band
        first = self._find_event(state, level, threshold, 1.0 if on else -1.0)
        late = self._go(first.states[-1], np.array(self._cut(switch.delay)), level)
        return [first, late]

    def _cut(self, time: float) -> list[float]:
        count = int(np.ceil(time / self.step - 1e-9))
        return [time / count] * count if count else []

    def _go(self, state: Numbers, lengths: Numbers, level: float) -> _Leg:
        row, _ = self.stretch.hold(self._signals(level))
        rows = np.column_stack([np.tile(row, (len(lengths), 1)), lengths])
        no_slopes = np.zeros((0, 0))
        end = self.stretch.march(state, rows, np.zeros((self.size, 0)), np.zeros((*rows.shape, 0)), no_slopes)
        return _Leg(end.states, lengths, level)

    def _see(self, states: Numbers, level: float) -> Numbers:
        signals = np.tile(self._signals(level), (len(states), 1))
        return self.stretch.observe(states, signals)[self.switch.output]

    def _find_event(self, state: Numbers, level: float, threshold: float, sign: float) -> _Leg:
        """Return the steps until the output passes a threshold, ending there or at the next sample.

        Raises:
            SolveError: the threshold is not reached.
        """
        begin, full = state, np.full(BLOCK * self.looks, self.step)
        states_before = list[Numbers]()
        for _ in range(BLOCKS):
            leg = self._go(begin, full, level)
            beyond = sign * (self._see(leg.states, level) - threshold)
            over = np.flatnonzero(beyond[self.looks :: self.looks] >= 0.0)
            if len(over):
                done = len(states_before) * len(full)
                if self.switch.sampling > 0.0:
                    k = (int(over[0]) + 1) * self.looks
                    return _Leg(
                        np.concatenate([*states_before, leg.states[: k + 1]]), np.full(done + k, self.step), level
                    )
                k = int(over[0])
                last, end = self._find_end(leg.states[k], level, threshold, sign)
                lengths = np.append(np.full(done + k, self.step), last)
                return _Leg(np.concatenate([*states_before, leg.states[: k + 1], end]), lengths, level)
            states_before.append(leg.states[:-1])
            begin = leg.states[-1]
        raise SolveError(
            f"`{self.switch.output}` does not come to {threshold:.6g} within {BLOCKS * len(full) * self.step:.6g} s."
        )

    def _find_end(self, state: Numbers, level: float, threshold: float, sign: float) -> tuple[float, Numbers]:
        """Return the length of the step that ends at a threshold, and the state there, shape (1, states)."""

        def end(length: float) -> Numbers:
            return self._go(state, np.array([length]), level).states[-1:]

        def missing(length: float) -> float:
            return sign * float(self._see(end(length), level)[0] - threshold)

        short = 1e-9 * self.step
        if missing(short) >= 0.0:
            return short, end(short)
        last = find_root(missing, short, self.step, relative=1e-14)
        return last, end(last)

    def march(self, state: Numbers) -> tuple[Numbers, Numbers]:
        """Return the states of a cycle, and the Jacobian of the last state."""
        legs, slopes = self._legs(state), np.eye(self.size)
        for number, leg in enumerate(legs):
            slopes = self._differentiate(leg, slopes, event=number % 2 == 0 and not self.switch.sampling)
        states = np.concatenate([*(leg.states[:-1] for leg in legs), legs[-1].states[-1:]])
        return states, slopes

    def _differentiate(self, leg: _Leg, seeds: Numbers, event: bool) -> Numbers:
        """Return the derivatives of the last state of a leg; an event moves its last step."""
        count = len(leg.lengths)
        if not count:
            return seeds
        signals = self._signals(leg.level)
        row, _ = self.stretch.hold(signals)
        rows = np.column_stack([np.tile(row, (count, 1)), leg.lengths])
        n = self.size
        dgiven = np.zeros((*rows.shape, n + 1))
        dgiven[-1, -1, n] = 1.0
        begin = np.column_stack([seeds, np.zeros(n)])
        slopes = self.stretch.march(leg.states[0], rows, begin, dgiven, np.zeros((0, n + 1))).slopes
        if not event:
            return slopes[:, :n]
        output = self.stretch.observe_slopes(self.switch.output, leg.states[-1], signals, slopes)
        return slopes[:, :n] - np.outer(slopes[:, n], output[:n] / output[n])

    def linearise(self, point: Numbers) -> LinearisedEquations:
        """Return the relative change of the states over a cycle, and its derivatives."""
        states, slopes = self.march(point)
        sizes = np.maximum(np.abs(states).max(axis=0), 1e-12)
        residual, jacobian = states[-1] - states[0], slopes - np.eye(self.size)
        inert = find_inert(slopes)
        residual[inert], jacobian[inert] = 0.0, np.eye(self.size)[inert]
        return LinearisedEquations(residual / sizes, jacobian / sizes[:, None], sizes)

    def observe(self, state: Numbers) -> tuple[Numbers, dict[str, Numbers]]:
        """Return the times [s] and outputs of a cycle."""
        legs = self._legs(state)
        lengths = np.concatenate([leg.lengths for leg in legs])
        states = np.concatenate([*(leg.states[:-1] for leg in legs), legs[-1].states[-1:]])
        levels = [leg.level for leg in legs for _ in leg.lengths]
        signals = np.array([self._signals(level) for level in [*levels, self.switch.low]])
        return np.concatenate([[0.0], np.cumsum(lengths)]), self.stretch.observe(states, signals)
