r"""A disturbance observer around a PID controller: what the plant does beyond a nominal model is taken from the signal.

    G(s) = K e^(-L s)/(1 + T s)                         nominal, around where it begins
    d̂ = Q(s) (G_0⁻¹(s) y - e^(-L s) u),                 Q(s) = 1/(1 + τ s),     G_0 without dead time
    u = C e - d̂                                         limited to [low, high]

d̂ is the signal that would do to the model what happens to the plant: a draught, another load, a supply that sags, the
other branch of the hysteresis. It is exact for the model sampled with a held signal: with α = e^(-T_s/T), a =
e^(-T_s/τ) and m samples of dead time,

    d̂_k = a d̂_k-1 + (1 - a) ((y_k - α y_k-1)/(K (1 - α)) - u_k-1-m)

u is the signal within its limits, so that nothing winds up. A supervisor that cuts it is not seen. Below 1/τ the loop
is that of the model, whatever the plant; a τ shorter than the dead time, or a K that is much too small, make it swing:
it holds while |Q(iω) (P/G - 1)| < 1 for the plant P. The model comes from a step test (`ms.control.run_loop_tests`).

Sources: Ohnishi (1987); Chen, Yang, Guo and Li (2016), section III.
"""

from typing import NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import PidGains, PidMemory
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers


class DisturbanceMemory(NamedTuple):
    """Memory of a disturbance observer."""

    disturbance: Scalar
    """d̂ [signal]."""
    before: Scalar
    """The reading of the last sample, from where it began."""
    origin: Scalar
    """Reading of the first sample."""
    signals: tuple[Scalar, ...]
    """u of the last samples, latest first."""
    pid: PidMemory


@CONTROLLERS.register("disturbance-observer")
class DisturbanceObserver(PidGains, AbstractController):
    """A PID controller that is helped by an observer of the disturbance."""

    cites = ("ohnishi1987", "chen2016")
    integrals = (-3,)

    period: Number = param("s", "time from one sample to the next", above=0.0, typical="20 ms")
    model_gain: Number = param("1", "K, SI units of what is measured per signal", typical=0.01)
    time_constant: Number = param("s", "T of the model", above=0.0, typical="2 s")
    dead_time: Number = param("s", "L of the model", low=0.0, default=0.0)
    filter_time: Number = param("s", "τ, time constant of the filter Q", above=0.0, typical="0.5 s")

    def check(self) -> None:
        """Raise `ParameterError` for a model that does nothing; fix what decides the program's size."""
        PidGains.check(self)
        if self.model_gain == 0.0:
            raise ParameterError("`model_gain` of `disturbance-observer` must not be 0.")
        self.__dict__["_layout"] = (1 + round(self.dead_time / self.period),)

    def layout(self) -> tuple[int, ...]:
        """Return the signals that are kept."""
        return self.__dict__["_layout"]

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        """Return the disturbance."""
        return {"disturbance": Output(signal, "estimated disturbance, as a signal", "d")}

    def observe(self, xp: Namespace, memory: Column) -> Column:
        """Return its value."""
        return memory[:1]

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """No disturbance, no signal."""
        found = readings[self.measured]
        return flatten_numbers(self._begin(found, self.law.rest(xp, reference, found)))

    def _begin(self, origin: Scalar, pid: PidMemory) -> DisturbanceMemory:
        return DisturbanceMemory(0.0, 0.0, origin, (0.0,) * self.layout()[0], pid)

    def _name_memory(self, memory: Column) -> DisturbanceMemory:
        return NestedShape(self._begin(0.0, PidMemory(*[0.0] * len(PidMemory._fields)))).rebuild(memory)

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """With the signal that there was, and the integral that gives it."""
        held, found = self._name_memory(memory), readings[self.measured]
        pid = self.law.track(xp, self.gains, held.pid, signal + held.disturbance, reference, found)
        return flatten_numbers(held._replace(signals=(signal, *held.signals[1:]), pid=pid))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample."""
        before, found = self._name_memory(memory), readings[self.measured]
        away = found - before.origin
        disturbance = self._estimate(xp, before, away, dt)
        left = {"low": self.law.low + disturbance, "high": self.law.high + disturbance}
        wanted, pid = self.law.rebuilt(left).answer(xp, self.gains, before.pid, reference, found, dt, self.sampled)
        signal = xp.clip(wanted - disturbance, self.law.low, self.law.high)
        signals = (signal, *before.signals[:-1])
        return signal, flatten_numbers(DisturbanceMemory(disturbance, away, before.origin, signals, pid))

    def _estimate(self, xp: Namespace, before: DisturbanceMemory, away: Scalar, dt: Scalar) -> Scalar:
        """d̂ of this sample, no larger than the range of the signal; as before without time."""
        some = dt > 0.0
        step = xp.where(some, dt, self.time_constant)
        kept, held = xp.exp(-step / self.time_constant), xp.exp(-step / self.filter_time)
        raw = (away - kept * before.before) / (self.model_gain * (1.0 - kept)) - before.signals[-1]
        found = held * before.disturbance + (1.0 - held) * raw
        most = self.law.high - self.law.low
        return xp.where(some, xp.clip(found, -most, most), before.disturbance)
