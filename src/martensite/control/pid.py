"""Discrete PID control with limits: one kernel for runs in a loop and for loops in C.

    C(z) = K_p + K_i/(1 - z⁻¹) + K_d (1 - z⁻¹),      e = r - y

    u_k = K_p (b r_k - y_k) + I_k + K_d D_k,                limited to [low, high]
    I_k = I_k-1 + K_i e_k
    D_k = D_k-1 + (x_k - x_k-1 - D_k-1)/(1 + N),            x = c r - y

With set-point weights b = c = 1 and no filter, N = 0, this is C(z). All gains are per sample, as
in that equation: K_i = K_i' T_s and K_d = K_d'/T_s of gains in seconds, which `per_sample`
converts. The derivative begins with the second sample, so switching on gives no kick.

Anti-windup is conditional integration: I stays as it is where the output is beyond a limit and
the error drives it further. The sign of an error counts with that of K_i, so that negative gains
control what falls when the signal rises.

Source of C(z): Copaci, Moreno and Blanco (2019), equation (1).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from martensite.errors import ParameterError, suggestion
from martensite.parameters import Parametrised, param, part
from martensite.runtimes import floats
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractDrive


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


class PidLaw(Parametrised):
    """What a PID controller does beside its gains: limits, set-point weights and filter."""

    low: float = param(DRIVE, "least signal", default=0.0)
    high: float = param(DRIVE, "largest signal", default=1.0)
    weight: float = param("1", "set-point weight b of the proportional part", default=1.0)
    slope_weight: float = param("1", "set-point weight c of the derivative part", default=1.0)
    filter: float = param(
        "1", "time constant N of the derivative's filter, in samples", low=0.0, default=0.0
    )

    def check(self) -> None:
        """Raise `ParameterError` if there is nothing between the limits."""
        if not self.low < self.high:
            raise ParameterError(
                f"The least signal of a controller must be below the largest one, but they are "
                f"{self.low:g} and {self.high:g}."
            )

    @property
    def idle(self) -> float:
        """The signal nearest to 0 within the limits: that before anything is controlled."""
        return min(max(self.low, 0.0), self.high)

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
        over = xp.both(wanted > self.high, added > 0.0)
        under = xp.both(wanted < self.low, added < 0.0)
        kept = xp.where(xp.either(over, under), memory.integral, integral)
        return xp.clip(wanted, self.low, self.high), PidMemory(kept, now, change)


class Pid(AbstractDrive):
    """A PID controller that keeps a measured output on a waveform."""

    cites = ("copaci2019",)

    measured: str = part("name of the output that is measured")
    reference: Any = part("what it shall follow, in the SI unit of that output", WAVEFORMS)
    Kp: float = param("1", "proportional gain, in signal per SI unit of that output")
    Ki: float = param("1", "integral gain per sample, in the same unit", default=0.0)
    Kd: float = param("1", "derivative gain per sample, in the same unit", default=0.0)
    law: PidLaw = part("limits, set-point weights and filter", default=PidLaw())

    @property
    def gains(self) -> Gains:
        """All gains."""
        return Gains(self.Kp, self.Ki, self.Kd)

    def init(self) -> PidMemory | None:
        """Nothing measured."""
        return None

    def __call__(
        self, time: float, measurement: Mapping[str, float], memory: PidMemory | None
    ) -> tuple[float, PidMemory]:
        """Signal at `time` [s] and the new memory; called once in every sample.

        Raises:
            ParameterError: the system has no such output.
        """
        if self.measured not in measurement:
            raise ParameterError(
                f"`Pid` cannot measure `{self.measured}`: the system has no such output. "
                f"{suggestion(self.measured, measurement)}"
            )
        wanted, found = self.reference.value(time), measurement[self.measured]
        memory = memory or self.law.rest(floats, wanted, found)
        return self.law.answer(floats, self.gains, memory, wanted, found)
