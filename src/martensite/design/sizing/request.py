"""Request for an actuator wire, and the wiring of its strands to the supply.

`force` is the force on the load at the end of the stroke. A bias weight has this weight. With a bias spring, the load
grows from 0 to `force` over the stroke and returns its energy, in addition to the return spring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, option, param

ALLOYS = ("70", "90")
"""Austenite start temperatures [°C], which name the two alloys."""

LIFE_CYCLES, LIFE_STRESS = 1e6, 172.4e6
"""Cycles, and the stress of 25 ksi [Pa] that nitinolactuators.com gives for them."""


class WireRequest(Parametrised):
    """Required force, stroke and rate of a wire, and its supply."""

    cites = ("dynalloy-vendor-page", "dynalloy-table-copy")

    force: Number = param("N", "pull on the load at the end of the stroke", above=0.0, high=1e5)
    stroke: Number = param("m", "travel of the load", above=0.0, high=10.0)
    rate: Number = param("Hz", "cycles per second", above=0.0, high=1e3)
    supply: Number = param("V", "voltage of the supply", above=0.0, high=1e4)
    ambient: Number = param("K", "ambient temperature, still air", low=250.0, high=400.0, default=295.15)
    strain: Number = param("1", "largest strain to be used", low=0.002, high=0.08, default=0.04)
    stress: Number = param("Pa", "largest stress of the hot wire", above=0.0, high=6e8, default=172e6)
    return_stress: Number = param("Pa", "stress that stretches the cold wire", above=0.0, high=3e8, default=69e6)
    spring_rise: Number = param(
        "1",
        "growth of the return spring's force over the stroke, as a share of its preload",
        low=0.01,
        high=5.0,
        default=0.25,
    )
    current_limit: Number = param("A", "largest current of the supply", above=0.0, default=math.inf)
    strands: Number = param("1", "most wires side by side", low=1.0, high=1000.0, default=12.0)
    life: Number = param("1", "cycles that it must last; by default any number", above=0.0, default=math.inf)
    element: str = option("what pulls: straight wire, or a coil spring of it", "wire", "coil", default="wire")
    bias: str = option("what stretches the cold wire", "spring", "weight", default="spring")
    limits: str = option("limits of the material: stress, strain, temperature", "keep", "ignore", default="keep")
    alloy: str = option("which of the maker's alloys", "any", *ALLOYS, default="any")

    @override
    def check(self) -> None:
        has_life = math.isfinite(self.life)
        if has_life and (self.life > LIFE_CYCLES or self.element == "coil" or self.limits == "ignore"):
            raise ParameterError(
                f"Parameter `life` of `WireRequest` applies to straight wires within their limits, up to "
                f"{LIFE_CYCLES:,.0f} cycles, because no source covers more. It is {self.life:,.0f}."
            )
        rise = self.spring_rise if self.bias == "spring" else 0.0
        taken = self.return_stress * (1.0 + rise)
        if taken >= self.stress:
            raise ParameterError(
                f"Parameter `stress` of `WireRequest` must be above the {taken / 1e6:.4g} MPa that "
                f"the return of the wire takes, but is {self.stress / 1e6:.4g} MPa."
            )

    def alloys(self) -> tuple[str, ...]:
        """Return the allowed alloys."""
        return ALLOYS if self.alloy == "any" else (self.alloy,)

    @property
    def period(self) -> float:
        """Return the time for one cycle [s]."""
        return 1.0 / self.rate


@dataclass(frozen=True)
class Wiring:
    """Wiring of the strands to the supply."""

    kind: str
    """single, series or parallel"""
    count: int
    resistance: float
    """Resistance of one strand [ohm]."""

    def total_current(self, strand: float) -> float:
        """Return the supply current [A] for a strand current [A]."""
        return strand * (self.count if self.kind == "parallel" else 1)

    def voltage(self, strand: float) -> float:
        """Return the voltage [V] for a strand current [A]."""
        return strand * self.resistance * (self.count if self.kind == "series" else 1)

    def most(self, request: WireRequest) -> float:
        """Return the largest strand current [A] of the supply."""
        return min(request.supply / self.voltage(1.0), request.current_limit / self.total_current(1.0))


def choose_wiring(request: WireRequest, count: int, resistance: float, needed: float) -> Wiring:
    """Return the wiring for a strand current [A].

    Series needs the smallest supply current and is preferred; else parallel; if neither suffices, the larger current.
    """
    if count == 1:
        return Wiring("single", 1, resistance)
    series, parallel = (Wiring(kind, count, resistance) for kind in ("series", "parallel"))
    if series.most(request) >= needed:
        return series
    return max(parallel, series, key=lambda wiring: wiring.most(request))
