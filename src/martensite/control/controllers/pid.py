"""PID control with limits, in gains of time units: one kernel for runs in a loop and for loops in C.

    C(s) = K_p + K_i/s + K_d s/(1 + T_f s)        K_i = K_p/T_i,  K_d = K_p T_d,      e = r - y

In every sample, h after the last one, by backward differences:

    u_k = K_p (b r_k - y_k) + I_k + K_d D_k,                limited to [low, high]
    I_k = I_k-1 + K_i h e_k
    D_k = D_k-1 + (x_k - x_k-1 - h D_k-1)/(T_f + h),        x = c r - y

Gains do not depend on the sample time: K_i is per second, K_d in seconds. The derivative is always filtered, with
T_f = T_d/N, N = 10, or with the time `filter` if given, and with at least one sample. In the first sample the integral
and the derivative are zero, so that switching on gives no kick.

`gains_are = "per-sample"` is the discrete form of published controllers with h = 1, whose derivative is unfiltered
unless `filter` is given:

    C(z) = K_p + K_i/(1 - z⁻¹) + K_d (1 - z⁻¹)

Anti-windup is conditional integration: I is held where the output is beyond a limit and the error drives it further.
The sign of K_i counts, so that negative gains control a reading that falls when the signal rises. The choice
`back-calculation` subtracts the limited part from I, with the tracking time T_t:

    I_k = I_k-1 + K_i h e_k + (u_k - v_k) h/T_t,        v the signal before it is limited,      T_t = T_i by default

Sources: C(z), Copaci, Moreno and Blanco (2019), equation (1); otherwise Åström and Hägglund (1995), chapter 3.
"""

import math
from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, option, param, part
from martensite.base.units import DERIVATIVE_GAIN, GAIN, INTEGRAL_GAIN
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings, SignalLimits
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar


class Gains(NamedTuple):
    """Gains of a PID controller in signal per unit of the reading.

    K_i is per second and K_d in seconds; for C(z) both are per sample.
    """

    Kp: Scalar
    Ki: Scalar
    Kd: Scalar


class PidMemory(NamedTuple):
    """Memory of a PID controller."""

    integral: Scalar
    """I [signal]."""
    before: Scalar
    """x = c r - y of the last sample."""
    change: Scalar
    """D, filtered rate of x."""


NO_MEMORY = PidMemory(0.0, 0.0, 0.0)


def compute_gains_per_sample(Kp: float, Ki: float, Kd: float, interval: float) -> Gains:
    """Return the gains per sample from the gains of K_p + K_i/s + K_d s.

    Args:
        Kp: proportional gain.
        Ki: integral gain [1/s].
        Kd: derivative gain [s].
        interval: sample time [s].
    """
    return Gains(Kp, Ki * interval, Kd / interval)


class PidLaw(SignalLimits):
    """Limits, set-point weights, filter and anti-windup of a PID controller."""

    weight: Number = param("1", "set-point weight b of the proportional part", low=0.0, high=1.0, default=1.0)
    slope_weight: Number = param("1", "set-point weight c of the derivative part", low=0.0, high=1.0, default=1.0)
    N: Number = param("1", "derivative time over its filter time: T_f = T_d/N", above=0.0, default=10.0)
    filter: Number = param("s", "time constant T_f of the derivative's filter; by N if 0", low=0.0, default=0.0)
    anti_windup: str = option(
        "anti-windup of the integral where the signal is limited",
        "conditional",
        "back-calculation",
        default="conditional",
    )
    tracking: Number = param("s", "tracking time T_t of back-calculation; T_i if 0", low=0.0, default=0.0)

    def rest(self, xp: Namespace, reference: Scalar, measured: Scalar) -> PidMemory:
        """Return the memory before the first sample."""
        return PidMemory(0.0, self.slope_weight * reference - measured, 0.0)

    def answer(
        self,
        xp: Namespace,
        gains: Gains,
        memory: PidMemory,
        reference: Scalar,
        measured: Scalar,
        dt: Scalar,
        sampled: bool = False,
    ) -> tuple[Scalar, PidMemory]:
        """Return the signal `dt` [s] after the last sample, and the new memory; `sampled`: gains of C(z)."""
        length = 1.0 if sampled else dt
        added = gains.Ki * (reference - measured) * length
        integral = memory.integral + added
        now = self.slope_weight * reference - measured
        lag = count_samples(xp, self.filter, dt) if sampled else self.filter_time(xp, gains, dt)
        change = memory.change + (now - memory.before - length * memory.change) / (length + lag)
        wanted = gains.Kp * (self.weight * reference - measured) + integral + gains.Kd * change
        signal = xp.clip(wanted, self.low, self.high)
        if self.anti_windup == "back-calculation":
            tracking = count_samples(xp, self.tracking, dt) if sampled else self.tracking
            time = xp.maximum(xp.where(self.tracking > 0.0, tracking, integral_time(xp, gains)), length)
            corrected = integral + (signal - wanted) * length / xp.maximum(time, SHORTEST)
            return signal, PidMemory(corrected, now, change)
        return signal, PidMemory(self.hold_integral(xp, wanted, added, memory.integral, integral), now, change)

    def track(
        self, xp: Namespace, gains: Gains, memory: PidMemory, signal: Scalar, reference: Scalar, measured: Scalar
    ) -> PidMemory:
        """Return the memory whose integral, if any, gives the signal in this sample."""
        rest = gains.Kp * (self.weight * reference - measured) + gains.Kd * memory.change
        return memory._replace(integral=xp.where(xp.abs(gains.Ki) > 0.0, signal - rest, memory.integral))

    def filter_time(self, xp: Namespace, gains: Gains, dt: Scalar) -> Scalar:
        """Return the time constant T_f of the filter of the derivative [s], at least one sample of `dt` [s]."""
        Td = xp.abs(gains.Kd * gains.Kp) / xp.maximum(gains.Kp * gains.Kp, SLIGHT)  # 0 without K_p
        lag = xp.where(self.filter > 0.0, self.filter, Td / self.N)
        return xp.maximum(xp.maximum(lag, dt), SHORTEST)

    def describe(self, gains: Gains, period: float, sampled: bool = False) -> str:
        """Describe the anti-windup and filter."""
        method = "conditional integration"
        if self.anti_windup == "back-calculation":
            unit = period if sampled else 1.0
            time = max(self.tracking or unit * integral_time(floats, gains), period)
            method = f"back-calculation, tracking time {time:.4g} s"
        lag = self.filter if sampled else self.filter_time(floats, gains, period)
        derivative = f"derivative filtered with {lag:.4g} s" if lag else "derivative without a filter"
        return f"anti-windup by {method}" + (f"; {derivative}" if gains.Kd else "")


SHORTEST = 1e-12
"""Time constant that counts as zero [s]."""
SLIGHT = 1e-30
"""Square of a gain that counts as zero."""


def count_samples(xp: Namespace, time: Scalar, dt: Scalar) -> Scalar:
    """Return a time [s] in samples of `dt` [s]."""
    return time / xp.maximum(dt, SHORTEST)


def integral_time(xp: Namespace, gains: Gains) -> Scalar:
    """Return T_i = K_p/K_i in the time unit of K_i; very large without an integral."""
    return xp.abs(gains.Kp) / xp.maximum(xp.abs(gains.Ki), SHORTEST)


IN_SECONDS, PER_SAMPLE = GAINS_ARE = "in-seconds", "per-sample"
"""Time units of the integral and derivative gains."""


class PidGains(Parametrised):
    """Gains and limits of a PID controller."""

    Kp: Number = param(GAIN, "proportional gain", typical=100.0)
    Ki: Number = param(INTEGRAL_GAIN, "integral gain", default=0.0)
    Kd: Number = param(DERIVATIVE_GAIN, "derivative gain", default=0.0)
    Ti: Number = param("s", "integral time T_i, instead of K_i = K_p/T_i", above=0.0, default=math.inf)
    Td: Number = param("s", "derivative time T_d, instead of K_d = K_p T_d", low=0.0, default=0.0)
    gains_are: str = option(
        "gains of K_p + K_i/s + K_d s, or K_i and K_d of the discrete form C(z)", *GAINS_ARE, default=IN_SECONDS
    )
    law: PidLaw = part("limits, set-point weights, filter and anti-windup", default=PidLaw())

    def check(self) -> None:
        if (self.Ki != 0.0 and math.isfinite(self.Ti)) or (self.Kd != 0.0 and self.Td != 0.0):
            raise ParameterError("A PID controller has `Ki` or `Ti`, and `Kd` or `Td`, not both.")
        if self.sampled and (math.isfinite(self.Ti) or self.Td != 0.0):
            raise ParameterError(
                "`Ti` and `Td` are for gains in seconds: give `Ki` and `Kd`, or leave out `gains_are`."
            )

    @property
    def sampled(self) -> bool:
        """Return whether integral and derivative gain are per sample, as in C(z)."""
        return self.gains_are == PER_SAMPLE

    @property
    def gains(self) -> Gains:
        """Return the gains, with T_i and T_d converted."""
        if self.sampled:
            return Gains(self.Kp, self.Ki, self.Kd)
        return Gains(self.Kp, self.Ki + self.Kp / self.Ti, self.Kd + self.Kp * self.Td)

    def describe(self, period: float) -> str:
        """Describe the anti-windup and filter."""
        return self.law.describe(self.gains, period, self.sampled)

    def respond(
        self, xp: Namespace, memory: PidMemory, reference: Scalar, measured: Scalar, dt: Scalar
    ) -> tuple[Scalar, PidMemory]:
        """Return the signal and the new memory."""
        return self.law.answer(xp, self.gains, memory, reference, measured, dt, self.sampled)


@CONTROLLERS.register("pid")
class Pid(PidGains, AbstractController):
    """A PID controller that keeps a reading on a waveform."""

    cites = ("copaci2019", "astrom1995")
    integrals = (0,)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> PidMemory:
        return self.law.rest(xp, reference, readings[self.measured])

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        return self.respond(xp, PidMemory(*memory), reference, readings[self.measured], dt)

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> PidMemory:
        before, value = PidMemory(*memory), readings[self.measured]
        return self.law.track(xp, self.gains, before, signal, reference, value)


KEPT = len(PidMemory._fields)
"""Length of the memory of a correction."""


class Correction(Parametrised):
    """Feedback in addition to a feed-forward, and the limits of the signal.

        u = u_f + v,    low - u_f ≤ v ≤ high - u_f

    u_f is the feed-forward and v the answer of a PID law to the measured error. The integral stops where the sum is at
    a limit. By default all gains are 0.
    """

    Kp: Number = param(GAIN, "proportional gain", default=0.0)
    Ki: Number = param(INTEGRAL_GAIN, "integral gain", default=0.0)
    Kd: Number = param(DERIVATIVE_GAIN, "derivative gain", default=0.0)
    law: PidLaw = part("limits of the whole signal, weights, filter and anti-windup", default=PidLaw())

    @property
    def gains(self) -> Gains:
        """Return the gains of the feedback."""
        return Gains(self.Kp, self.Ki, self.Kd)

    def describe(self, period: float) -> str:
        """Describe the anti-windup and filter; empty without gains."""
        return self.law.describe(self.gains, period) if any(self.gains) else ""

    def limit_signal(self, xp: Namespace, signal: Scalar) -> Scalar:
        """Return a signal within the limits."""
        return xp.clip(signal, self.law.low, self.law.high)

    def rest(self, xp: Namespace, reference: Scalar, measured: Scalar) -> PidMemory:
        """Return the memory with an integral of zero."""
        return self.law.rest(xp, reference, measured)

    def answer(
        self, xp: Namespace, memory: PidMemory, feed: Scalar, reference: Scalar, measured: Scalar, dt: Scalar
    ) -> tuple[Scalar, PidMemory]:
        """Return the signal with a feed-forward, within the limits, and the new memory."""
        limits = {"low": self.law.low - feed, "high": self.law.high - feed}
        added, after = self.law.rebuilt(limits).answer(xp, self.gains, memory, reference, measured, dt)
        return feed + added, after

    def track(
        self, xp: Namespace, memory: PidMemory, feed: Scalar, signal: Scalar, reference: Scalar, measured: Scalar
    ) -> PidMemory:
        """Return the memory whose integral, if any, gives the signal with a feed-forward."""
        return self.law.track(xp, self.gains, memory, signal - feed, reference, measured)
