"""A piece of wire that is at hand: what current, resistor or duty it needs, how fast it is, what it lifts.

    i_full = U/R                    without anything in series
    i_1    contracts in the pulse asked for (simulated)
    i_hold = sqrt(h π d (T_h - T_a)/r)      r per metre; T_h = A_f(σ) + 10 K under the load when hot
    i_max  the same at the temperature limit of the material: more must not stay on
    R_s = U/i - R,  P_s = i² R_s        or a duty D = (i/i_full)² of a switch: heat goes with i² D
    L = μ₀ l/(2π) (ln(4 l/d) - 1)       of a straight wire, which a flyback diode would be for

Resistance per metre, pull and current in 1 s are the cells of the catalogue. A wire of another resistance
(`resistance`) is that of the catalogue with this one. Loads are a weight, or a spring with a preload; without
either, the weight is the maker's pull. The law is that of `statics`.

Source: the catalogue's cells, each with its kind; the inductance of a straight round wire is that of textbooks.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.errors import ParameterError
from martensite.base.parameters import Parametrised, option, param
from martensite.design.sizing.cycle import PulseCycle, find_current, simulate_cycle
from martensite.design.sizing.request import ALLOYS
from martensite.design.sizing.statics import USABLE, Strand, list_alloy_numbers
from martensite.kernels.namespace import Scalar
from martensite.physics.fluids.oil import Oil
from martensite.physics.fluids.water import Water
from martensite.physics.materials.wires import GRAVITY, WireCatalogue, WireSize, load_wires
from martensite.physics.thermal.base import AbstractCooling
from martensite.physics.thermal.convection import ChurchillBernstein, ChurchillChu, LeFevreEde

COOLINGS: dict[str, AbstractCooling] = {
    "air": LeFevreEde(),
    "horizontal": ChurchillChu(),
    "fan": ChurchillBernstein(speed=2.0),
    "water": ChurchillChu(fluid=Water()),
    "oil": ChurchillChu(fluid=Oil()),
}
"""What is around the wire: still air (vertical or horizontal), a stream of air of 2 m/s, still water or oil."""
ABOVE = 10.0
"""How far above A_f a wire is held [K]."""
NEAR = 0.04
"""Relative difference of a diameter from one of the catalogue that is the same size."""
ROUNDED = 1.01
"""What rounding makes of the maker's pull, over his working stress."""
VACUUM = 4e-7 * math.pi
"""Permeability of the vacuum [H/m]."""


class WireInHand(Parametrised):
    """A piece of wire, what drives it and what it pulls."""

    diameter: Scalar = param("m", "diameter of the wire, one of the maker's", above=0.0, high=0.01)
    length: Scalar = param("m", "length of the wire", above=0.0, high=100.0)
    supply: Scalar = param("V", "voltage of the supply", above=0.0, high=1e4)
    current_limit: Scalar = param("A", "largest current of the supply", above=0.0, default=math.inf)
    load: Scalar = param("N", "weight that hangs on it; 0 for the maker's pull", low=0.0, high=1e5, default=0.0)
    spring: Scalar = param("N/m", "rate of a spring that it pulls; 0 for a weight", low=0.0, high=1e7, default=0.0)
    preload: Scalar = param("N", "force of the spring when cold; 0 for the maker's", low=0.0, high=1e5, default=0.0)
    pulse: Scalar = param("s", "time in which it is to contract", low=0.01, high=60.0, default=1.0)
    ambient: Scalar = param("K", "ambient temperature", low=250.0, high=400.0, default=295.15)
    resistance: Scalar = param("ohm", "as measured; 0 for the maker's", low=0.0, high=1e6, default=0.0)
    alloy: str = option("which of the maker's alloys", *ALLOYS, default="90")
    cooling: str = option("what is around the wire", *COOLINGS, default="air")

    def check(self) -> None:
        """Raise `ParameterError` if a weight and a spring are given."""
        if self.load > 0.0 and (self.spring > 0.0 or self.preload > 0.0):
            raise ParameterError("A wire lifts a weight or pulls a spring; give `load`, or `spring` and `preload`.")

    def find_size(self, catalogue: WireCatalogue) -> WireSize:
        """The size of the catalogue, with the resistance that was measured.

        Raises:
            ParameterError: the catalogue has no such wire.
        """
        sizes = sorted(catalogue.sizes.values(), key=lambda one: abs(math.log(one.diameter.value / self.diameter)))
        best = sizes[0]
        if abs(best.diameter.value / self.diameter - 1.0) > NEAR:
            near = " and ".join(sorted(one.name for one in sizes[:2]))
            raise ParameterError(f"The catalogue has no wire of {1e3 * self.diameter:.4g} mm; the nearest are {near}.")
        if self.resistance == 0.0:
            return best
        return replace(best, resistance=replace(best.resistance, value=self.resistance / self.length, kind="measured"))

    def mechanism(self, size: WireSize) -> AbstractMechanism:
        """What the wire pulls."""
        if self.spring == 0.0 and self.preload == 0.0:
            return DeadWeight(mass=(self.load or size.pull_force) / GRAVITY)
        return BiasSpring(stiffness=self.spring, preload=self.preload or size.deformation_force)


@dataclass(frozen=True)
class WireRatings:
    """What a piece of wire needs and does; SI."""

    wire: WireInHand
    size: WireSize
    strand: Strand
    stroke: float
    """98 % of what it gives between the pure phases under its load [m]."""
    cold_force: float
    hot_force: float
    hot_stress: float
    full_current: float
    """Of the supply without anything in series [A]."""
    cycle: PulseCycle | None
    """A pulse that contracts it in the time asked for, and the cooling after it; None if none does."""
    holding_temperature: float
    holding_current: float
    """Keeps it contracted, for ever [A]."""
    most_current: float
    """Heats it to the temperature limit of the material in the long run [A]."""
    temperature_limit: float
    stress_limit: float
    returns: bool
    """Whether the ambient is below M_f under the cold load."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Why it does not work so; empty if it does."""
        found: list[str] = []
        if self.cycle is None:
            found.append(f"no current contracts it in {self.wire.pulse:.3g} s")
        elif not self.drivable:
            most = min(self.full_current, self.wire.current_limit)
            found.append(
                f"the supply drives {most:.3g} A, but {self.cycle.current:.3g} A contract it in "
                f"{self.wire.pulse:.3g} s; a shorter wire, more volts or a longer --pulse would do"
            )
        if not self.returns or (self.cycle is not None and self.cycle.cooling is None):
            found.append("it does not come back at this ambient under this load when cold")
        stress, limit = self.hot_stress / 1e6, self.stress_limit / 1e6
        if stress > limit * ROUNDED:
            found.append(f"{stress:.4g} MPa is above the maker's {limit:.4g} MPa for repeated use")
        return tuple(found)

    @property
    def drivable(self) -> bool:
        """Whether the supply drives the current of the pulse."""
        return self.cycle is not None and self.cycle.current <= min(self.full_current, self.wire.current_limit)

    def series_resistor(self, current: float) -> tuple[float, float]:
        """Resistor that leaves a current [A]: [ohm], and the heat in it while it flows [W]."""
        series = self.wire.supply / current - self.strand.resistance
        return series, current**2 * series

    def duty(self, current: float) -> float:
        """Duty of a switch at the supply that heats as a current [A] does."""
        return (current / self.full_current) ** 2

    @property
    def energy(self) -> float | None:
        """Electrical energy in the wire of one pulse [J]."""
        return None if self.cycle is None else self.cycle.current**2 * self.strand.resistance * self.cycle.heating

    @property
    def inductance(self) -> float:
        """Of the straight wire [H]."""
        shape = math.log(4.0 * self.strand.length / self.size.diameter.value) - 1.0
        return VACUUM * self.strand.length / (2.0 * math.pi) * shape

    @property
    def count(self) -> int | None:
        """How many such wires the supply drives side by side; None if it has no limit."""
        if self.cycle is None or math.isinf(self.wire.current_limit):
            return None
        return int(self.wire.current_limit / self.cycle.current * (1.0 + 1e-9))

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; numbers in SI."""
        names = ("stroke", "cold_force", "hot_force", "hot_stress", "full_current", "holding_temperature")
        names += ("holding_current", "most_current", "temperature_limit", "returns", "drivable", "energy", "inductance")
        current = None if self.cycle is None else self.cycle.current
        series = None if current is None or not self.drivable else self.series_resistor(current)
        return {
            "wire": {name: getattr(self.wire, name) for name in self.wire.declarations},
            "size": self.size.name,
            "resistance": self.strand.resistance,
            **{name: getattr(self, name) for name in names},
            "cycle": None if self.cycle is None else asdict(self.cycle),
            "series_resistor": series and series[0],
            "series_power": series and series[1],
            "duty": None if series is None or current is None else self.duty(current),
            "table_current": self.size.current.value,
            "count": self.count,
            "faults": list(self.faults),
        }


def rate_wire(wire: WireInHand, catalogue: WireCatalogue | None = None) -> WireRatings:
    """What a piece of wire needs and does.

    Args:
        wire: the wire, its supply and its load.
        catalogue: the maker's table; that of Flexinol if not given.

    Raises:
        ParameterError: the catalogue has no such wire, or the load leaves no stroke.
    """
    size = wire.find_size(catalogue or load_wires())
    strand = Strand(size, wire.alloy, wire.length, wire.ambient, COOLINGS[wire.cooling])
    mechanism, limits = wire.mechanism(size), list_alloy_numbers(wire.alloy)
    stroke, cold, hot = _find_stroke(strand, mechanism)
    if stroke <= 0.0:
        raise ParameterError(
            f"The load leaves the wire no stroke: it would stand under {cold / size.section / 1e6:.4g} MPa when cold."
        )
    holding = strand.shifted("A_f", hot / size.section) + ABOVE
    system = strand.system(mechanism)
    current = find_current(system, stroke, wire.pulse, size.current.value)
    cycle = None if current is None else simulate_cycle(system, stroke, current, wire.pulse, strand.time_constant())
    return WireRatings(
        wire,
        size,
        strand,
        stroke,
        cold,
        hot,
        hot / size.section,
        wire.supply / strand.resistance,
        cycle,
        holding,
        strand.steady_current(holding),
        strand.steady_current(limits["temperature_limit"]),
        limits["temperature_limit"],
        limits["stress_limit"],
        wire.ambient < strand.shifted("M_f", cold / size.section),
    )


def _find_stroke(strand: Strand, mechanism: AbstractMechanism) -> tuple[float, float, float]:
    """Stroke [m], and the forces [N] before and after it."""
    area = strand.size.section
    if isinstance(mechanism, BiasSpring):
        cold, rate = float(mechanism.preload), float(mechanism.stiffness)
        share = USABLE * strand.length
        free = share * strand.reachable_strain(cold / area, cold / area)
        stroke = free / (1.0 + share * rate / (area * strand.law.E_A))
        return stroke, cold, cold + rate * stroke
    weight = float(getattr(mechanism, "mass")) * GRAVITY  # noqa: B009
    return USABLE * strand.length * strand.reachable_strain(weight / area, weight / area), weight, weight
