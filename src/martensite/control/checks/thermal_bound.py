"""Upper bound on the temperature of an element, without a sensor.

    C dT̂/dt = P̂(u) - G (T̂ - T̂_a),      T̂ = T̂_a in the steady state without a signal

u is the signal that the guard passes, P̂(u) the largest power of this signal, and C the heat capacity without latent
heat. G is a lower bound of the conductance for all temperatures up to the limit, T̂_a the highest ambient temperature.
Every period is solved exactly. A signal under which T̂ would pass its limit within the next period is cut. Under the
answer `limit` of a guard it is lowered to the largest signal that ends the period at the limit:

    T̂_∞ = (T_lim - T̂ e)/(1 - e),   e = exp(-G t/C),      P̂(u) = G (T̂_∞ - T̂_a)

The bound holds for an element of uniform temperature T. Let S be the heat that the element stores beyond C times its
temperature rise: from a larger heat capacity, and latent heat S = Δh (1 - ξ). Then

    C d(T - T̂)/dt ≤ -G (T - T̂) - dS/dt,   so   T - T̂ ≤ [mean of S over the past - S(t)]/C

with a mean that fades with C/G. At the maximum of T, in austenite, S is also at its maximum, and T ≤ T̂. While
martensite is left, T is below A_f at its stress. So T stays below the limit, or below A_f if A_f is higher. C must
exclude latent heat: with it, the bound would be too low in austenite.

If `cooling` names a reading, such as `estimated.least_cooling` of the observer `self-sensing`, G is multiplied by it.

The bound does not cover a source that heats without a signal or with more than the declared power, nor hot spots.
Pulses exceed the mean of their period t by up to P (1 - D) D t/C: choose the limit lower by this amount.
"""

from __future__ import annotations

from martensite.base.parameters import Number, option, param, text
from martensite.base.units import DEGREES
from martensite.control.checks.base import CHECKS, AbstractCheck, CheckResult, Column, Named
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE

SHORT = 1e-12
"""Fraction of a time constant that counts as zero."""


@CHECKS.register("thermal-bound")
class ThermalBound(AbstractCheck):
    """Cut or limit signals by a lumped model of the worst case."""

    alarm, size = 8, 1

    drive: str = text("name of the drive that heats the element", default="drive")
    limit: Number = param("K", "highest temperature", above=0.0, typical="400 K")
    band: Number = param(DEGREES, "distance of clearing below the limit", low=0.0, default=0.0, typical="5 K")
    power: Number = param("W", "largest power in the element at the full signal", above=0.0, typical="1 W")
    full: Number = param(DRIVE, "the full signal", above=0.0, default=1.0)
    rises: str = option(
        "power with the signal: `linear` for a duty or a power, `square` for volt or ampere",
        "linear",
        "square",
        default="linear",
    )
    capacity: Number = param("J/K", "heat capacity of the element, without latent heat", above=0.0, typical="0.02 J/K")
    conductance: Number = param("W/K", "least heat loss per kelvin", above=0.0, typical="0.01 W/K")
    cooling: str = text("reading of the lower bound of the heat loss, over `conductance`", default="")
    ambient: Number = param("K", "hottest surroundings", above=0.0, typical="30 degC")

    def names(self) -> tuple[str, ...]:
        return (self.drive, *self.cuts())

    def reads(self) -> tuple[str, ...]:
        return (self.cooling,) if self.cooling else ()

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the highest ambient temperature [K]."""
        return (self.ambient,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        memory = (memory[0], *(readings[name] for name in self.reads()))
        then = self._adapt_conductance(memory).after(xp, memory[0], wanted[self.drive], dt)
        return CheckResult(xp.negate(then <= self.limit), then <= self.limit - self.band, memory)

    def find_most(self, xp: Namespace, memory: Column, dt: Scalar) -> Named:
        conductance = self._adapt_conductance(memory).conductance
        decay = xp.exp(-conductance * dt / self.capacity)
        settled = (self.limit - memory[0] * decay) / xp.maximum(1.0 - decay, SHORT)
        fraction = xp.maximum((settled - self.ambient) * conductance / self.power, 0.0)
        return {self.drive: self.full * (fraction if self.rises == "linear" else xp.sqrt(fraction))}

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        return (self._adapt_conductance(memory).after(xp, memory[0], allowed[self.drive], dt),)

    def _adapt_conductance(self, memory: Column) -> ThermalBound:
        return self.rebuilt({"conductance": self.conductance * memory[1]}) if self.cooling else self

    def after(self, xp: Namespace, bound: Scalar, signal: Scalar, dt: Scalar) -> Scalar:
        """Return the bound [K] after `dt` [s] of a signal."""
        settled = self.settled_bound(xp, signal)
        return settled + (bound - settled) * xp.exp(-self.conductance * dt / self.capacity)

    def settled_bound(self, xp: Namespace, signal: Scalar) -> Scalar:
        """Return the steady state of the bound under a constant signal [K]."""
        fraction = xp.abs(signal) / self.full
        fraction = fraction if self.rises == "linear" else fraction * fraction
        return self.ambient + self.power * fraction / self.conductance

    def holds(self, safe: float) -> bool:
        """Return whether the bound stays below its limit under the safe signal."""
        return self.settled_bound(floats, safe) <= self.limit
