"""A bound on the temperature that needs no sensor: how hot the element may be at worst.

    C dT̂/dt = P̂(u) - G (T̂ - T̂_a),      T̂ = T̂_a at rest

driven by the signal u that the guard lets pass, with the largest power P̂(u) that the signal can bring, the heat
capacity C without latent heat, a conductance G below that of the element at any temperature up to the limit, and the
hottest surroundings T̂_a. Every period is solved exactly. A signal under which T̂ would pass its limit within the next
period is not let through: T̂ never passes the limit, whatever any sensor says. Under the answer `limit` of a guard it is
lowered to the largest that ends the period at the limit, in closed form a barrier:

    T̂_∞ = (T_lim - T̂ e)/(1 - e),   e = exp(-G t/C),      P̂(u) = G (T̂_∞ - T̂_a)

Nor does the element, if it is equally hot everywhere. With S, the heat that it stores beyond C times its rise - that of
a larger heat capacity, and latent heat, S = Δh (1 - ξ) - its difference to the bound obeys

    C d(T - T̂)/dt ≤ -G (T - T̂) - dS/dt,   so   T - T̂ ≤ [mean of S over the past - S(t)]/C

with a mean that fades with C/G. When T is at its highest so far, and austenite, so is S at its
most, and T ≤ T̂. While martensite is left, T is below the end of the transformation A_f at its
stress. So T stays below the limit, or below that A_f if it should be higher. Latent heat must be
left out of C for this: with it, the bound would be too low once all is austenite.

With a reading `cooling`, such as `estimated.least_cooling` of the observer `self-sensing`, G follows it, as far as that
can be trusted.

What it does not know: a source that heats without a signal, or more than declared, and hot spots.
Pulses go above the mean of their period by up to P (1 - D) D t/C, t being their period: leave
that much room below what the element can stand.
"""

from __future__ import annotations

from martensite.base.parameters import Number, option, param, text
from martensite.base.units import DEGREES
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE

SHORT = 1e-12
"""Fraction of a time constant that counts as zero."""


@CHECKS.register("thermal-bound")
class ThermalBound(AbstractCheck):
    """A lumped model of the worst case."""

    alarm, size = 8, 1

    drive: str = text("name of the drive that heats the element", default="drive")
    limit: Number = param("K", "highest temperature", above=0.0, typical="400 K")
    band: Number = param(DEGREES, "how far below it is well again", low=0.0, default=0.0, typical="5 K")
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
    cooling: str = text("reading of the least heat loss that is sure now, over `conductance`", default="")
    ambient: Number = param("K", "hottest surroundings", above=0.0, typical="30 degC")

    def names(self) -> tuple[str, ...]:
        """Return the drive that heats, and those that are cut."""
        return (self.drive, *self.cuts())

    def reads(self) -> tuple[str, ...]:
        """Return the name of the reading for the cooling, if there is one."""
        return (self.cooling,) if self.cooling else ()

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the memory: the largest ambient temperature."""
        return (self.ambient,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether the element may be too hot at the end of the period; remember its cooling."""
        memory = (memory[0], *(readings[name] for name in self.reads()))
        then = self._cooled(memory).after(xp, memory[0], wanted[self.drive], dt)
        return Looked(xp.negate(then <= self.limit), then <= self.limit - self.band, memory)

    def find_most(self, xp: Namespace, memory: Column, dt: Scalar) -> Named:
        """Return the size of the signal under which the bound is at its limit at the end of the period."""
        conductance = self._cooled(memory).conductance
        kept = xp.exp(-conductance * dt / self.capacity)
        settled = (self.limit - memory[0] * kept) / xp.maximum(1.0 - kept, SHORT)
        share = xp.maximum((settled - self.ambient) * conductance / self.power, 0.0)
        return {self.drive: self.full * (share if self.rises == "linear" else xp.sqrt(share))}

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        """Return the bound at the end of the period."""
        return (self._cooled(memory).after(xp, memory[0], allowed[self.drive], dt),)

    def _cooled(self, memory: Column) -> ThermalBound:
        """With the conductance that is sure now."""
        return self.rebuilt({"conductance": self.conductance * memory[1]}) if self.cooling else self

    def after(self, xp: Namespace, bound: Scalar, signal: Scalar, dt: Scalar) -> Scalar:
        """Return the bound [K] after a signal of dt [s]."""
        settled = self.settled_bound(xp, signal)
        return settled + (bound - settled) * xp.exp(-self.conductance * dt / self.capacity)

    def settled_bound(self, xp: Namespace, signal: Scalar) -> Scalar:
        """Return the final value of the bound under a constant signal [K]."""
        share = xp.abs(signal) / self.full
        share = share if self.rises == "linear" else share * share
        return self.ambient + self.power * share / self.conductance

    def holds(self, safe: float) -> bool:
        """Return whether the bound stays below its limit under the signal of a cut."""
        return self.settled_bound(floats, safe) <= self.limit
