"""Shaping of a reference: a lag, limits of rate and acceleration, and a rate that depends on a confidence.

    w' = (r - w)/T                              lag, a pre-filter 1/(1 + T s)
    |v| ≤ κ V,   |v_k - v_k-1| ≤ A h            rate v of the shaped reference,  s_k = s_k-1 + h v_k

The rate is the largest that still stops in time: from a distance d, braking by A h in every sample,

    v = A h (√(1/4 + 2 d/(A h²)) - 1/2)

and at most d/h, so that there is no overshoot; the last sample may brake by an eighth more than A.

κ is 1 for a reading `confidence` of at least `full`, 0 for at most `stop`, and linear between: a controller whose
observer has a low confidence slows down, then stops. Below `stop` the reference is held, or, with `below = "safe"`, the
safe signal is applied.
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
    """s, the reference of the controller."""
    rate: Scalar
    """v, rate of s."""
    lagged: Scalar
    """w, target of s."""


class ReferenceShaping(Parametrised):
    """Limits of the rate of change of a reference."""

    rate: Number = param(REFERENCE_RATE, "largest rate", above=0.0, default=math.inf)
    acceleration: Number = param(REFERENCE_ACCELERATION, "largest change of the rate", above=0.0, default=math.inf)
    lag: Number = param("s", "time constant of a first-order lag before the limits", low=0.0, default=0.0)
    confidence: str = text("reading that scales the rate; default: none", default="")
    full: Number = param("1", "confidence from which the rate is the largest", default=0.8)
    stop: Number = param("1", "confidence at which the reference stops", default=0.3)
    below: str = option(
        "action below `stop`: hold the reference, or apply the safe signal", "hold", "safe", default="hold"
    )
    safe: Number = param(DRIVE, "safe signal", default=0.0)

    def check(self) -> None:
        if not self.stop < self.full:
            raise ParameterError(f"`stop` must be below `full`, but they are {self.stop:g} and {self.full:g}.")
        if self.confidence and not math.isfinite(self.rate):
            raise ParameterError("A confidence decides about the `rate` of a reference: give one.")
        if self.below == "safe" and not self.confidence:
            raise ParameterError('`below = "safe"` needs the name of a `confidence`, such as `estimated.confidence`.')

        self.__dict__["_layout"] = math.isfinite(self.rate), math.isfinite(self.acceleration), self.lag > 0.0

    def begin(self, value: Scalar) -> ShapedReference:
        """Return the memory of a constant reference."""
        return ShapedReference(value, 0.0, value)

    def move(
        self, xp: Namespace, before: ShapedReference, reference: Scalar, readings: Mapping[str, Scalar], dt: Scalar
    ) -> ShapedReference:
        """Return the shaped reference after a sample of `dt` [s]."""
        limited, braked, lagging = self.layout()
        lagged = before.lagged + (reference - before.lagged) * dt / (self.lag + dt) if lagging else reference
        way, some = lagged - before.value, dt > 0.0
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
            rate = before.rate + xp.clip(wanted - before.rate, -step, step)
            rate = xp.where(way < 0.0, xp.maximum(rate, way / length), xp.minimum(rate, way / length))
        rate = xp.where(some, rate, before.rate)
        return ShapedReference(before.value + rate * dt, rate, lagged)

    def trust(self, xp: Namespace, readings: Mapping[str, Scalar]) -> Scalar:
        """Return κ, the factor of the rate."""
        if not self.confidence:
            return 1.0
        return xp.clip((readings[self.confidence] - self.stop) / (self.full - self.stop), 0.0, 1.0)

    def is_safe(self, xp: Namespace, readings: Mapping[str, Scalar]) -> Flag:
        """Return whether the safe signal must be applied."""
        return readings[self.confidence] < self.stop
