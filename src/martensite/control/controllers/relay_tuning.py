"""Self-tuning controller: a relay test, then a PID controller with gains from the limit cycle.

    tuning   u = bias + d while y < r_0 - ε until y ≥ r_0 + ε, then bias - d
             K_u = 4 d/(π √(a² - ε²)),    P_u,    a = half the range of y in a cycle
    tuned    u = PID, K_p = c_1 K_u,    T_i = c_2 P_u,    T_d = c_3 P_u

The first `skipped` cycles are ignored. K_u and P_u are means over the next `cycles`; if their lengths scatter by more
than a tenth, counting restarts. The change to PID is bumpless: the integral starts such that the first signal is the
mean signal of the relay. A wire that heats faster than it cools spends more time at the lower signal, while the
describing function averages over both. With `balance` the bias moves, during the skipped cycles, to the mean signal of
the last cycle, so that both times become equal.

Before the end of the test there are no gains. Without a limit cycle within `timeout` the signal stays idle, and
`tuning` is -1. Signals that a supervisor cuts make no cycle.

Rules and describing function: `martensite.control.rules.relay`. Sources: Åström and Hägglund (1984), with Ziegler and
Nichols (1942), Tyreus and Luyben (1992), Seborg et al. (2011, no overshoot).
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param, part
from martensite.base.units import DIFFERENCE, LEVEL
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import NO_MEMORY, Gains, PidLaw, PidMemory
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import NestedShape, choose_tuple, flatten_numbers
from martensite.signals.base import DRIVE
from martensite.signals.levels import HIGH, MARGIN

RELAY_RULES: Mapping[str, Mapping[str, tuple[float, float, float]]] = {
    "ziegler-nichols": {"pi": (0.45, 1.0 / 1.2, 0.0), "pid": (0.6, 0.5, 0.125)},
    "tyreus-luyben": {"pi": (1.0 / 3.2, 2.2, 0.0), "pid": (1.0 / 2.2, 2.2, 1.0 / 6.3)},
    "no-overshoot": {"pid": (0.2, 0.5, 1.0 / 3.0)},
}
"""K_p/K_u, T_i/P_u and T_d/P_u by rule and form."""
STEADY = 0.1
"""Spread of the periods over their mean above which a cycle is not steady."""
TUNING, TUNED, FAILED = 1.0, 0.0, -1.0


def find_ultimate_gain(xp: Namespace, relay: Scalar, amplitude: Scalar, hysteresis: Scalar) -> Scalar:
    """Return K_u by the describing function of a relay d with hysteresis ε, for an amplitude a > ε."""
    return 4.0 * relay / (math.pi * xp.sqrt(amplitude**2 - hysteresis**2))


class RelayCycle(NamedTuple):
    """The present relay cycle."""

    on: Scalar
    """1 at the larger signal, 0 at the smaller."""
    length: Scalar
    """Duration of the cycle [s]."""
    heated: Scalar
    """Time at the larger signal [s]."""
    lowest: Scalar
    highest: Scalar


class RelaySums(NamedTuple):
    """Sums over the counted cycles."""

    count: Scalar
    lengths: Scalar
    squares: Scalar
    heated: Scalar
    ranges: Scalar


class TuningMemory(NamedTuple):
    """Memory of a self-tuning controller."""

    stage: Scalar
    elapsed: Scalar
    """Duration of the test [s]."""
    turns: Scalar
    """Number of times that the relay has switched on."""
    bias: Scalar
    gain: Scalar
    """K_u; 0 if unknown."""
    period: Scalar
    """P_u [s]."""
    cycle: RelayCycle
    sums: RelaySums
    pid: PidMemory


NOTHING = RelaySums(0.0, 0.0, 0.0, 0.0, 0.0)


@CONTROLLERS.register("relay-tuning")
class RelayTuning(AbstractController):
    """A PID controller that finds its gains by a relay test in the loop."""

    cites = ("astrom1984", "ziegler1942", "tyreus1992", "seborg2011")
    integrals = (-3,)

    level: Number = param(LEVEL, "r_0, mean level of the reading during the test", typical=HIGH)
    bias: Number = param(DRIVE, "mean of the two signals of the relay", default=0.5)
    amplitude: Number = param(DRIVE, "d, half the difference of the two signals", above=0.0, default=0.5)
    hysteresis: Number = param(
        DIFFERENCE, "ε, half the band without switching: a few times the noise", low=0.0, default=0.0, typical=MARGIN
    )
    action: str = option("direction of the reading when the signal rises", "rising", "falling", default="rising")
    balance: str = option("whether the bias moves until both signals last as long", "off", "on", default="off")
    rule: str = option("which gains", *RELAY_RULES, default="tyreus-luyben")
    form: str = option("with a derivative part or without", "pi", "pid", default="pid")
    skipped: Number = param("1", "cycles that are not counted", low=1.0, default=3.0)
    cycles: Number = param("1", "counted cycles", low=1.0, default=6.0)
    timeout: Number = param("s", "largest duration of the test", above=0.0, default=120.0)
    law: PidLaw = part("limits, set-point weights and filter", default=PidLaw())

    def check(self) -> None:
        if self.form not in RELAY_RULES[self.rule]:
            raise ParameterError(f"Relay rule `{self.rule}` is for pid only.")
        low, high = self.bias - self.amplitude, self.bias + self.amplitude
        if low < self.law.low or high > self.law.high:
            raise ParameterError(
                f"A relay of {self.bias:g} ± {self.amplitude:g} goes beyond the limits of the signal, "
                f"{self.law.low:g} to {self.law.high:g}; choose a smaller `amplitude`."
            )

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        per = signal if unit == "1" else f"{signal}/{unit}"
        return {
            "tuning": Output("1", "relay test: going on (1), over (0), without a cycle (-1)", "s"),
            "ultimate_gain": Output(per, "ultimate gain", "K_u"),
            "ultimate_period": Output("s", "ultimate period", "P_u"),
            "Kp": Output(per, "proportional gain", "K_p"),
            "Ki": Output(f"{per}/s", "integral gain", "K_i"),
            "Kd": Output(f"{per}*s", "derivative gain", "K_d"),
        }

    def observe(self, xp: Namespace, memory: Column) -> Column:
        parts = self._name_memory(memory)
        return [parts.stage, parts.gain, parts.period, *self._find_gains(xp, parts)]

    def describe_doubts(self, last: Mapping[str, float]) -> list[str]:
        if last["tuning"] == TUNED:
            return []
        if last["tuning"] == TUNING:
            return ["Warning: The relay test is not over yet: nothing was controlled so far."]
        return [
            f"Warning: The relay made no steady limit cycle in {self.timeout:g} s, and the signal is off. Choose a "
            f"`level` that the reading crosses under both signals, {self.bias - self.amplitude:g} and "
            f"{self.bias + self.amplitude:g}, or more hysteresis."
        ]

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        value = readings[self.measured]
        away = self._place(value)
        on = xp.where(away < 0.0, 1.0, 0.0)
        cycle = RelayCycle(on, 0.0, 0.0, away, away)
        pid = self.law.rest(xp, reference, value)
        return flatten_numbers(TuningMemory(TUNING, 0.0, 0.0, self.bias, 0.0, 0.0, cycle, NOTHING, pid))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before, value = self._name_memory(memory), readings[self.measured]
        after, mean = self._advance_test(xp, before, self._place(value), dt)
        begins = xp.both(before.stage > 0.5, xp.both(after.stage < 0.5, after.stage > -0.5))
        gains = self._find_gains(xp, after)
        fresh = self.law.rest(xp, reference, value)
        fresh = fresh._replace(integral=mean - gains.Kp * (self.law.weight * reference - value))
        pid = choose_tuple(xp, begins, fresh, before.pid)
        signal, pid = self.law.answer(xp, gains, pid, reference, value, dt)
        relay = after.bias + self.amplitude * (2.0 * after.cycle.on - 1.0)
        signal = xp.where(after.stage > -0.5, signal, xp.clip(0.0, self.law.low, self.law.high))
        return xp.where(after.stage > 0.5, relay, signal), flatten_numbers(after._replace(pid=pid))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """Return the memory whose integral gives the signal.

        A relay test restarts, because its signals were not applied.
        """
        before, value = self._name_memory(memory), readings[self.measured]
        pid = self.law.track(xp, self._find_gains(xp, before), before.pid, signal, reference, value)
        return flatten_numbers(before._replace(elapsed=0.0, turns=0.0, sums=NOTHING, pid=pid))

    def _place(self, value: Scalar) -> Scalar:
        """Return the distance of a reading beyond the level, in the direction of the signal."""
        return value - self.level if self.action == "rising" else self.level - value

    def _find_gains(self, xp: Namespace, memory: TuningMemory) -> Gains:
        Kp, Ti, Td = RELAY_RULES[self.rule][self.form]
        gain = Kp * memory.gain
        measured = memory.period > 0.0
        return Gains(gain, gain / (Ti * xp.where(measured, memory.period, 1.0)), gain * Td * memory.period)

    def _advance_test(
        self, xp: Namespace, before: TuningMemory, away: Scalar, dt: Scalar
    ) -> tuple[TuningMemory, Scalar]:
        """Return the test after a sample, and the mean signal of the counted cycles."""
        one = before.cycle
        band_state = xp.where(away < self.hysteresis, one.on, 0.0)
        on = xp.where(away < -self.hysteresis, 1.0, band_state)
        turned = xp.both(on > 0.5, one.on < 0.5)
        lowest, highest = xp.minimum(away, one.lowest), xp.maximum(away, one.highest)
        whole = RelayCycle(on, one.length + dt, one.heated + dt * one.on, lowest, highest)
        cycle = choose_tuple(xp, turned, RelayCycle(on, 0.0, 0.0, away, away), whole)
        turns = before.turns + xp.where(turned, 1.0, 0.0)
        sums = choose_tuple(
            xp, xp.both(turned, turns > self.skipped + 1.5), _add_cycle(before.sums, whole), before.sums
        )
        after = before._replace(elapsed=before.elapsed + dt, turns=turns, cycle=cycle, sums=sums)
        after = self._balance_relay(xp, after, whole, xp.both(turned, turns > 1.5))
        return self._judge_cycles(xp, before, after)

    def _balance_relay(self, xp: Namespace, after: TuningMemory, whole: RelayCycle, turned: Flag) -> TuningMemory:
        """Return the memory with the bias at the mean signal of a whole cycle, during skipped cycles."""
        if self.balance == "off":
            return after
        some = xp.where(whole.length > 0.0, whole.length, 1.0)
        mean = after.bias + self.amplitude * (2.0 * whole.heated / some - 1.0)
        mean = xp.clip(mean, self.law.low + self.amplitude, self.law.high - self.amplitude)
        moves = xp.both(turned, after.turns < self.skipped + 0.5)
        return after._replace(bias=xp.where(moves, mean, after.bias))

    def _judge_cycles(self, xp: Namespace, before: TuningMemory, after: TuningMemory) -> tuple[TuningMemory, Scalar]:
        """Compute gain and period after enough cycles; restart counting if they are not steady."""
        sums = after.sums
        count = xp.where(sums.count > 0.5, sums.count, 1.0)
        period, amplitude = sums.lengths / count, 0.5 * sums.ranges / count
        spread = xp.sqrt(sums.squares / count - period**2)
        steady = xp.both(spread <= STEADY * period, amplitude > self.hysteresis)
        enough = xp.both(before.stage > 0.5, sums.count > self.cycles - 0.5)
        tuned, late = xp.both(enough, steady), xp.both(before.stage > 0.5, after.elapsed > self.timeout)
        wide = xp.where(amplitude > self.hysteresis, amplitude, self.hysteresis + 1.0)
        gain = find_ultimate_gain(xp, self.amplitude, wide, self.hysteresis)
        gain = gain if self.action == "rising" else -gain
        stage = xp.where(tuned, TUNED, xp.where(late, FAILED, before.stage))
        fraction = sums.heated / xp.where(sums.lengths > 0.0, sums.lengths, 1.0)
        state = after._replace(
            stage=stage,
            gain=xp.where(tuned, gain, before.gain),
            period=xp.where(tuned, period, before.period),
            sums=choose_tuple(xp, enough, NOTHING, sums),
        )
        return state, after.bias + self.amplitude * (2.0 * fraction - 1.0)

    def _name_memory(self, memory: Column) -> TuningMemory:
        cycle = RelayCycle(*[0.0] * len(RelayCycle._fields))
        example = TuningMemory(TUNING, 0.0, 0.0, 0.0, 0.0, 0.0, cycle, NOTHING, NO_MEMORY)
        return NestedShape(example).rebuild(memory)


def _add_cycle(sums: RelaySums, whole: RelayCycle) -> RelaySums:
    return RelaySums(
        sums.count + 1.0,
        sums.lengths + whole.length,
        sums.squares + whole.length**2,
        sums.heated + whole.heated,
        sums.ranges + whole.highest - whole.lowest,
    )
