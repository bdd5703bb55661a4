r"""Shaping of a reference: a lag, limits of its rate and acceleration, and a rate that a confidence decides about.

    w' = (r - w)/T                              lag, a pre-filter 1/(1 + T s)
    |v| ≤ κ V,   |v_k - v_k-1| ≤ A h            rate v of what the controller follows,  s_k = s_k-1 + h v_k

The rate is the largest that still stops in time: from a distance d, braking by A h in every sample,

    v = A h (√(1/4 + 2 d/(A h²)) - 1/2)

and never more than d/h, so that nothing overshoots; the last sample may brake by an eighth more than A.

κ is 1 where the reading `confidence` is `full` or more, 0 where it is `stop` or less, and straight between: a
controller whose observer is unsure goes slower, and then stops. Below `stop` the reference is held, or, with
`below = "safe"`, the signal is the safe one until the confidence is back.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, option, param, text
from martensite.base.units import REFERENCE_ACCELERATION, REFERENCE_RATE
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.signals.base import DRIVE


class ShapedReference(NamedTuple):
    """Memory of a shaped reference."""

    value: Scalar
    """s, what the controller follows."""
    rate: Scalar
    """v, per second."""
    lagged: Scalar
    """w, what s goes to."""


class ReferenceShaping(Parametrised):
    """Limits of how fast the reference that a controller follows may change."""

    rate: Number = param(REFERENCE_RATE, "largest rate", above=0.0, default=math.inf)
    acceleration: Number = param(REFERENCE_ACCELERATION, "largest change of the rate", above=0.0, default=math.inf)
    lag: Number = param("s", "time constant of a first-order lag before the limits", low=0.0, default=0.0)
    confidence: str = text("reading that decides about the rate; none if empty", default="")
    full: Number = param("1", "confidence from which the rate is the largest", default=0.8)
    stop: Number = param("1", "confidence at which the reference stops", default=0.3)
    below: str = option(
        "what happens below `stop`: the reference is held, or the signal is safe", "hold", "safe", default="hold"
    )
    safe: Number = param(DRIVE, "safe signal", default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` where confidence has nothing to act on."""
        if not self.stop < self.full:
            raise ParameterError(f"`stop` must be below `full`, but they are {self.stop:g} and {self.full:g}.")
        if self.confidence and not math.isfinite(self.rate):
            raise ParameterError("A confidence decides about the `rate` of a reference: give one.")
        if self.below == "safe" and not self.confidence:
            raise ParameterError('`below = "safe"` needs the name of a `confidence`, such as `estimated.confidence`.')

        self.__dict__["_layout"] = math.isfinite(self.rate), math.isfinite(self.acceleration), self.lag > 0.0

    def layout(self) -> tuple[int, ...]:
        """Which of the three there are."""
        return self.__dict__["_layout"]

    def begin(self, value: Scalar) -> ShapedReference:
        """At rest at a value."""
        return ShapedReference(value, 0.0, value)

    def move(
        self, xp: Namespace, held: ShapedReference, reference: Scalar, readings: Mapping[str, Scalar], dt: Scalar
    ) -> ShapedReference:
        """Return a sample of `dt` [s] later, on the way to a reference."""
        limited, braked, lagging = self.layout()
        lagged = held.lagged + (reference - held.lagged) * dt / (self.lag + dt) if lagging else reference
        way, some = lagged - held.value, dt > 0.0
        length, most = xp.where(some, dt, 1.0), xp.abs(way)
        fastest = most / length
        if limited:
            fastest = xp.minimum(fastest, self.rate * self.trust(xp, readings))
        if not braked:
            rate = xp.clip(way / length, -fastest, fastest)
        else:
            step = self.acceleration * length
            fastest = xp.minimum(fastest, step * (xp.sqrt(0.25 + 2.0 * most / (step * length)) - 0.5))
            wanted = xp.where(way < 0.0, -fastest, fastest)
            rate = held.rate + xp.clip(wanted - held.rate, -step, step)
            rate = xp.where(way < 0.0, xp.maximum(rate, way / length), xp.minimum(rate, way / length))
        rate = xp.where(some, rate, held.rate)
        return ShapedReference(held.value + rate * dt, rate, lagged)

    def trust(self, xp: Namespace, readings: Mapping[str, Scalar]) -> Scalar:
        """κ, the share of the rate that a confidence leaves."""
        if not self.confidence:
            return 1.0
        return xp.clip((readings[self.confidence] - self.stop) / (self.full - self.stop), 0.0, 1.0)

    def is_safe(self, xp: Namespace, readings: Mapping[str, Scalar]) -> Flag:
        """Return whether the signal is the safe one."""
        return readings[self.confidence] < self.stop
