"""One supply for several sources, whose voltage drops under load.

    U = U_0 - R_i Σ I_k(U),      Σ I_k(U) ≤ I_max

No source has more than the common voltage U and its own limit (`supplied_by`). If the sources would draw more than
I_max, the supply lowers its voltage and holds I_max, as a laboratory supply does. U is the root of the increasing
function

    max{U - U_0 + R_i I(U),   U - U I_max/I(U)},      I = Σ I_k,

with I_k averaged over the pulses (a supply with a buffer). Coinciding pulses may draw more for a short time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.base.parameters import Number, Parametrised, param
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import AbstractSource

LEAST_CURRENT = 1e-30
"""Current [A] that counts as zero."""


class Consumer(NamedTuple):
    """Load on a supply."""

    source: AbstractSource
    drive: Scalar
    resistance: Scalar
    """Resistance of the element [ohm]."""

    def limit_voltage(self, xp: Namespace, voltage: Scalar) -> AbstractSource:
        """Return the source at a supply voltage [V]."""
        names = self.source.supplied_by
        return self.source.rebuilt({name: xp.minimum(self.source.value_of(name), voltage) for name in names})


class SharedSupply(Parametrised):
    """Supply voltage with internal resistance and current limit."""

    voltage: Number = param("V", "voltage U_0 without load", above=0.0, high=1e4, typical="12 V")
    internal_resistance: Number = param(
        "ohm", "internal resistance R_i, and that of common leads", low=0.0, high=1e6, default=0.0, typical="0.1 ohm"
    )
    current_limit: Number = param("A", "largest current I_max of all together", above=0.0, high=1e6, default=1e6)

    def sum_currents(self, xp: Namespace, consumers: Sequence[Consumer], voltage: Scalar) -> Scalar:
        """Return the current [A] of all consumers at a voltage [V]."""
        total: Scalar = 0.0
        for one in consumers:
            total = total + one.limit_voltage(xp, voltage).supply_current(xp, one.drive, one.resistance)
        return total

    def find_voltage(self, xp: Namespace, consumers: Sequence[Consumer], limited: bool = True) -> Scalar:
        """Return U [V], with or without the current limit."""

        def excess(xp: Namespace, voltage: Scalar) -> Scalar:
            current = self.sum_currents(xp, consumers, voltage)
            drooped = voltage - self.voltage + self.internal_resistance * current
            dropped = voltage - voltage * (self.current_limit / xp.maximum(current, LEAST_CURRENT))
            return xp.maximum(drooped, dropped) if limited else drooped

        return solve_bracketed(xp, excess, self.voltage, (0.0, 1.01 * self.voltage), smooth=False)

    def observe(self, xp: Namespace, consumers: Sequence[Consumer]) -> tuple[Scalar, Scalar, Scalar]:
        """Return the voltage [V], the current [A], and the current without the limit [A]."""
        voltage, free = self.find_voltage(xp, consumers), self.find_voltage(xp, consumers, limited=False)
        return voltage, self.sum_currents(xp, consumers, voltage), self.sum_currents(xp, consumers, free)
