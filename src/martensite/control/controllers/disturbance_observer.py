"""PID controller with a disturbance observer: the deviation of the plant from a nominal model is compensated.

    G(s) = K e^(-L s)/(1 + T s)                         nominal model around the start
    d̂ = Q(s) (G_0⁻¹(s) y - e^(-L s) u),                 Q(s) = 1/(1 + τ s),     G_0 without dead time
    u = C e - d̂                                         limited to [low, high]

d̂ is the signal that has the same effect on the model as the disturbance on the plant: a draught, another load, a lower
supply, the other branch of the hysteresis. The sampled form is exact for a held signal: with α = e^(-T_s/T),
a = e^(-T_s/τ) and m samples of dead time,

    d̂_k = a d̂_k-1 + (1 - a) ((y_k - α y_k-1)/(K (1 - α)) - u_k-1-m)

u is the limited signal, which prevents windup; a cut by a supervisor is not included. Below 1/τ the loop behaves like
the model for any plant P with |Q(iω) (P/G - 1)| < 1. A τ shorter than the dead time, or a K that is much too small,
makes the loop oscillate. A step test (`ms.control.run_loop_tests`) identifies the model.

Sources: Ohnishi (1987); Chen, Yang, Guo and Li (2016), section III.
"""

from typing import NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import NO_MEMORY, PidGains, PidMemory
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers


class DisturbanceMemory(NamedTuple):
    """Memory of a disturbance observer."""

    disturbance: Scalar
    """d̂ [signal]."""
    before: Scalar
    """Reading of the last sample, less the origin."""
    origin: Scalar
    """Reading of the first sample."""
    signals: tuple[Scalar, ...]
    """u of the last samples, newest first."""
    pid: PidMemory


@CONTROLLERS.register("disturbance-observer")
class DisturbanceObserver(PidGains, AbstractController):
    """A PID controller with an observer of the disturbance."""

    cites = ("ohnishi1987", "chen2016")
    integrals = (-3,)

    period: Number = param("s", "time from one sample to the next", above=0.0, typical="20 ms")
    model_gain: Number = param("1", "K, SI units of the reading per signal", typical=0.01)
    time_constant: Number = param("s", "T of the model", above=0.0, typical="2 s")
    dead_time: Number = param("s", "L of the model", low=0.0, default=0.0)
    filter_time: Number = param("s", "τ, time constant of the filter Q", above=0.0, typical="0.5 s")

    def check(self) -> None:
        PidGains.check(self)
        if self.model_gain == 0.0:
            raise ParameterError("`model_gain` of `disturbance-observer` must not be 0.")
        self.__dict__["_layout"] = (1 + round(self.dead_time / self.period),)

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        return {"disturbance": Output(signal, "estimated disturbance, as a signal", "d")}

    def observe(self, xp: Namespace, memory: Column) -> Column:
        return memory[:1]

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        value = readings[self.measured]
        return flatten_numbers(self._begin(value, self.law.rest(xp, reference, value)))

    def _begin(self, origin: Scalar, pid: PidMemory) -> DisturbanceMemory:
        return DisturbanceMemory(0.0, 0.0, origin, (0.0,) * self.layout()[0], pid)

    def _name_memory(self, memory: Column) -> DisturbanceMemory:
        return NestedShape(self._begin(0.0, NO_MEMORY)).rebuild(memory)

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        before = self._name_memory(memory)
        wanted = signal + before.disturbance
        pid = self.law.track(xp, self.gains, before.pid, wanted, reference, readings[self.measured])
        return flatten_numbers(before._replace(signals=(signal, *before.signals[1:]), pid=pid))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before, value = self._name_memory(memory), readings[self.measured]
        away = value - before.origin
        disturbance = self._estimate(xp, before, away, dt)
        limits = {"low": self.law.low + disturbance, "high": self.law.high + disturbance}
        wanted, pid = self.law.rebuilt(limits).answer(xp, self.gains, before.pid, reference, value, dt, self.sampled)
        signal = xp.clip(wanted - disturbance, self.law.low, self.law.high)
        signals = (signal, *before.signals[:-1])
        return signal, flatten_numbers(DisturbanceMemory(disturbance, away, before.origin, signals, pid))

    def _estimate(self, xp: Namespace, before: DisturbanceMemory, away: Scalar, dt: Scalar) -> Scalar:
        """Return d̂, limited to the range of the signal; unchanged for dt = 0."""
        some = dt > 0.0
        step = xp.where(some, dt, self.time_constant)
        model_decay, decay = xp.exp(-step / self.time_constant), xp.exp(-step / self.filter_time)
        raw = (away - model_decay * before.before) / (self.model_gain * (1.0 - model_decay)) - before.signals[-1]
        estimate = decay * before.disturbance + (1.0 - decay) * raw
        most = self.law.high - self.law.low
        return xp.where(some, xp.clip(estimate, -most, most), before.disturbance)
