"""Discrete PID control with limits: one kernel for runs in a loop and for loops in C.

    C(z) = K_p + K_i/(1 - z⁻¹) + K_d (1 - z⁻¹),      e = r - y

    u_k = K_p (b r_k - y_k) + I_k + K_d D_k,                limited to [low, high]
    I_k = I_k-1 + K_i e_k
    D_k = D_k-1 + (x_k - x_k-1 - D_k-1)/(1 + N),            x = c r - y

With set-point weights b = c = 1 and no filter, N = 0, this is C(z). All gains are per sample, as
in that equation: K_i = K_i' T_s and K_d = K_d'/T_s of gains in seconds, which `per_sample`
converts. The derivative begins with the second sample, so switching on gives no kick.

Anti-windup is conditional integration: I stays as it is where the output is beyond a limit and the error drives it
further. The sign of an error counts with that of K_i, so that negative gains control what falls when the signal rises.
The choice `back-calculation` takes from I, in every sample, a share 1/N_t of what is beyond the limits instead:

    I_k = I_k-1 + K_i e_k + (u_k - v_k)/N_t,      v the signal before it is limited

Source of C(z): Copaci, Moreno and Blanco (2019), equation (1); of back-calculation: Åström and
Hägglund (1995), section 3.5.
"""

from typing import NamedTuple

from martensite.base.parameters import Parametrised, option, param, part
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings, SignalLimits
from martensite.kernels.namespace import Namespace, Scalar


class Gains(NamedTuple):
    """Gains of a PID controller, per sample, in signal per unit of what is measured."""

    Kp: Scalar
    Ki: Scalar
    Kd: Scalar


class PidMemory(NamedTuple):
    """What a PID controller remembers."""

    integral: Scalar
    """I [signal]."""
    before: Scalar
    """x = c r - y of the last sample."""
    change: Scalar
    """D, the filtered change of x."""


def per_sample(Kp: float, Ki: float, Kd: float, interval: float) -> Gains:
    """Gains per sample from those of K_p + K_i/s + K_d s.

    Args:
        Kp: proportional gain.
        Ki: integral gain [1/s].
        Kd: derivative gain [s].
        interval: sample time [s].
    """
    return Gains(Kp, Ki * interval, Kd / interval)


class PidLaw(SignalLimits):
    """What a PID controller does beside its gains: limits, set-point weights and filter."""

    weight: float = param("1", "set-point weight b of the proportional part", default=1.0)
    slope_weight: float = param("1", "set-point weight c of the derivative part", default=1.0)
    filter: float = param("1", "time constant N of the derivative's filter, in samples", low=0.0, default=0.0)
    anti_windup: str = option(
        "what the integral does where the signal is limited", "conditional", "back-calculation", default="conditional"
    )
    tracking: float = param("1", "time constant N_t of back-calculation, in samples", low=1.0, default=10.0)

    def rest(self, xp: Namespace, reference: Scalar, measured: Scalar) -> PidMemory:
        """What is remembered before the first sample."""
        return PidMemory(0.0, self.slope_weight * reference - measured, 0.0)

    def answer(
        self, xp: Namespace, gains: Gains, memory: PidMemory, reference: Scalar, measured: Scalar
    ) -> tuple[Scalar, PidMemory]:
        """Signal of this sample, and what is remembered for the next."""
        added = gains.Ki * (reference - measured)
        integral = memory.integral + added
        now = self.slope_weight * reference - measured
        change = memory.change + (now - memory.before - memory.change) / (1.0 + self.filter)
        wanted = gains.Kp * (self.weight * reference - measured) + integral + gains.Kd * change
        signal = xp.clip(wanted, self.low, self.high)
        if self.anti_windup == "back-calculation":
            kept = integral + (signal - wanted) / self.tracking
            return signal, PidMemory(kept, now, change)
        return signal, PidMemory(self.hold_integral(xp, wanted, added, memory.integral, integral), now, change)


GAINS_ARE = "per-sample", "in-seconds"
"""What the integral and the derivative gain of a controller may be given for."""


def sample_gains(xp: Namespace, gains: Gains, kind: str, dt: Scalar) -> Gains:
    """Gains per sample, of gains of a kind of `GAINS_ARE`; the first sample, dt = 0 s, has nothing to integrate."""
    if kind == "per-sample":
        return gains
    some = dt > 0.0
    share = xp.where(some, 1.0 / xp.where(some, dt, 1.0), 0.0)
    return Gains(gains.Kp, gains.Ki * dt, gains.Kd * share)


class PidGains(Parametrised):
    """What any PID controller is given: gains and limits."""

    Kp: Scalar = param("1", "proportional gain, in signal per SI unit of what is measured", typical=100.0)
    Ki: Scalar = param("1", "integral gain", default=0.0)
    Kd: Scalar = param("1", "derivative gain", default=0.0)
    gains_are: str = option(
        "integral and derivative gain: K_i and K_d of C(z), or those of K_p + K_i/s + K_d s",
        *GAINS_ARE,
        default="per-sample",
    )
    law: PidLaw = part("limits, set-point weights and filter", default=PidLaw())

    def gains(self, xp: Namespace, dt: Scalar) -> Gains:
        """All gains per sample."""
        return sample_gains(xp, Gains(self.Kp, self.Ki, self.Kd), self.gains_are, dt)


@CONTROLLERS.register("pid")
class Pid(AbstractController, PidGains):
    """A PID controller that keeps a measured output on a waveform."""

    cites = ("copaci2019", "astrom1995")

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> PidMemory:
        """Nothing integrated."""
        return self.law.rest(xp, reference, readings[self.measured])

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Signal of this sample, and what is remembered for the next."""
        gains, found = self.gains(xp, dt), readings[self.measured]
        return self.law.answer(xp, gains, PidMemory(*memory), reference, found)


KEPT = len(PidMemory._fields)
"""Numbers that a correction remembers."""


class Correction(Parametrised):
    """Feedback beside a feed-forward, and the limits of the signal.

        u = u_f + v,    low - u_f ≤ v ≤ high - u_f

    where u_f is what the feed-forward says and v the answer of a PID law to what is still measured as an error. The
    integral stops where the sum is at a limit. All gains are 0 to begin with: feed-forward alone.
    """

    Kp: Scalar = param("1", "proportional gain, in signal per SI unit measured", default=0.0)
    Ki: Scalar = param("1/s", "integral gain", default=0.0)
    Kd: Scalar = param("s", "derivative gain, over the unit of the proportional one", default=0.0)
    law: PidLaw = part("limits of the whole signal, weights and filter", default=PidLaw())

    def limit_signal(self, xp: Namespace, signal: Scalar) -> Scalar:
        """A signal within the limits."""
        return xp.clip(signal, self.law.low, self.law.high)

    def rest(self, xp: Namespace, reference: Scalar, measured: Scalar) -> PidMemory:
        """Nothing integrated."""
        return self.law.rest(xp, reference, measured)

    def answer(
        self, xp: Namespace, memory: PidMemory, feed: Scalar, reference: Scalar, measured: Scalar, dt: Scalar
    ) -> tuple[Scalar, PidMemory]:
        """Signal of this sample with a feed-forward within the limits, and the new memory."""
        gains = sample_gains(xp, Gains(self.Kp, self.Ki, self.Kd), "in-seconds", dt)
        left = {"low": self.law.low - feed, "high": self.law.high - feed}
        added, after = self.law.rebuilt(left).answer(xp, gains, memory, reference, measured)
        return feed + added, after
