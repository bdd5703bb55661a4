"""Sliding-mode control: the signal switches on the two sides of a surface in the space of errors.

    s = ė + λ e                    or, with the integral,   s = ė + 2λ e + λ² ∫e dt,     e = r - y
    u = u_eq + K φ(s/Φ)            limited to [low, high]

φ is the saturation, φ(x) = x limited to [-1, 1], or tanh. Within the boundary layer |s| < Φ the control is linear,
without chattering; the remaining error is at most about Φ/λ without the integral. On the surface the error decays with
the time constant 1/λ.

ė is the difference over a sample behind a lag with the time constant τ of `filter`. The equivalent signal u_eq, which
would hold the plant on the surface, is a line of the reference, u_0 + k r, from a staircase test of the plant, or
(`filtered`) the signal u behind a separate lag (Utkin's equivalent control). The lag replaces the integral and cannot
wind up, since u is limited. ∫e is held where the signal is limited and the error drives it further.

K is in signal, λ in 1/s, Φ in units of s, the reading per second. A negative K controls a reading that falls when the
signal rises.

Sources: surface, boundary layer and integral, Slotine and Li (1991), chapter 7; equivalent control by a lag, Utkin
(1992); tanh in a robust controller for an SMA wire, Song et al. (2003).
"""

from typing import NamedTuple

from martensite.base.parameters import Number, option, param
from martensite.base.units import RATE
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings, SignalLimits
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE
from martensite.signals.levels import HIGH, MARGIN


class SlidingMemory(NamedTuple):
    """Memory of a sliding-mode controller."""

    error: Scalar
    rate: Scalar
    """ė behind its lag."""
    integral: Scalar
    """∫e dt."""
    mean: Scalar
    """u behind its lag."""


@CONTROLLERS.register("sliding-mode")
class SlidingMode(AbstractController, SignalLimits):
    """A controller that drives the error onto a surface and along it to 0."""

    cites = ("slotine1991", "utkin1992", "song2003")

    gain: Number = param(DRIVE, "largest signal K of the switching part", typical=HIGH)
    slope: Number = param("1/s", "slope λ of the surface", above=0.0, typical="2 1/s")
    layer: Number = param(RATE, "half width Φ of the boundary layer, in units of s", above=0.0, typical=MARGIN)
    boundary: str = option("switching function within the layer", "saturation", "tanh", default="saturation")
    integral: str = option("integral in the surface", "without", "with", default="without")
    equivalent: str = option(
        "equivalent signal: a line of the reference, or the lagged signal", "line", "filtered", default="line"
    )
    offset: Number = param(DRIVE, "u_0 of the line", default=0.0)
    per_reference: Number = param("1", "k of the line, in signal per SI unit", default=0.0)
    lag: Number = param("s", "time constant of the lag of the signal", low=0.0, default=1.0)
    filter: Number = param("s", "time constant τ of the filter of ė", low=0.0, default=0.05)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> SlidingMemory:
        mean = xp.clip(0.0, self.low, self.high)
        return SlidingMemory(reference - readings[self.measured], 0.0, 0.0, mean)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before, error = SlidingMemory(*memory), reference - readings[self.measured]
        rate = lag_rate(xp, before.rate, error - before.error, self.filter, dt)
        integral = before.integral + error * dt
        part = self._switching_function(xp, self._surface(error, rate, integral) / self.layer)
        wanted = self._equivalent_signal(before.mean, reference) + self.gain * part
        signal = xp.clip(wanted, self.low, self.high)
        new_integral = self.hold_integral(xp, wanted, self.gain * error, before.integral, integral)
        mean = lag_rate(xp, before.mean, signal * dt, self.lag, dt)
        return signal, SlidingMemory(error, rate, new_integral, mean)

    def _surface(self, error: Scalar, rate: Scalar, integral: Scalar) -> Scalar:
        if self.integral == "without":
            return rate + self.slope * error
        return rate + self.slope * (2.0 * error + self.slope * integral)

    def _switching_function(self, xp: Namespace, x: Scalar) -> Scalar:
        return xp.tanh(x) if self.boundary == "tanh" else xp.clip(x, -1.0, 1.0)

    def _equivalent_signal(self, mean: Scalar, reference: Scalar) -> Scalar:
        return mean if self.equivalent == "filtered" else self.offset + self.per_reference * reference


def lag_rate(xp: Namespace, before: Scalar, change: Scalar, lag: Scalar, dt: Scalar) -> Scalar:
    """Return the rate of a quantity that changes by `change` in `dt`, behind a lag, by the implicit rule.

    d = (τ d₋ + Δ)/(τ + dt), and d₋ for dt = 0; with Δ = u dt it is u behind the lag.
    """
    some = dt > 0.0
    return xp.where(some, (lag * before + change) / xp.where(some, lag + dt, 1.0), before)
