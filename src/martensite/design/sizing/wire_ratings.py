"""Ratings of an existing wire or coil: currents, resistor or duty cycle, speed and load.

    i_full = U/R                    without a series resistance
    i_1    contracts in the requested pulse (simulated)
    i_hold = sqrt(h π d (T_h - T_a)/r)      r per metre; T_h = A_f(σ) + 10 K under the hot load; at most i_1
    i_max  the same at the temperature limit of the material, the largest continuous current
    R_s = U/i - R,  P_s = i² R_s        or a duty cycle D = (i/i_full)², since the heat is i² D
    L = μ₀ l/(2π) (ln(4 l/d) - 1)       straight wire, for the choice of a flyback diode
    L = μ₀ N² π D²/4/(L_s + 0.45 D)     coil (Wheeler)

Resistance per metre, pull and current in 1 s are the cells of the catalogue, unless `resistance` is given. The load is
a weight, by default the maker's pull, or a spring with a preload. A coil drawn to a length starts its stroke there and
has returned when it reaches that length again. The law is the law of `statics`.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.base.errors import ParameterError
from martensite.design.sizing.coil_in_hand import CoilInHand, StretchedCoil, draw_out
from martensite.design.sizing.cycle import RETURNED, PulseCycle, find_current, find_reach_time, simulate_cooling
from martensite.design.sizing.statics import USABLE, CoilStrand, Strand, list_alloy_numbers
from martensite.design.sizing.wire_in_hand import WireInHand
from martensite.physics.materials.wires import GRAVITY, WireCatalogue, WireSize, load_wires
from martensite.simulate.judgement import describe_excess, judge_run

ABOVE = 10.0
"""Excess of the holding temperature over A_f [K]."""
HALVINGS = 60
"""Bisections of the stroke against a spring."""
TOUCHABLE = 60.0
"""Highest direct voltage [V] of bare parts: the limit ES1 of IEC 62368-1."""
LONGEST = 60.0
"""Longest pulse [s]."""
VACUUM = 4e-7 * math.pi
"""Permeability of the vacuum [H/m]."""


@dataclass(frozen=True)
class WireRatings:
    """Requirements and performance of a piece of wire, in SI."""

    wire: WireInHand
    size: WireSize
    strand: Strand
    stroke: float
    """98 % of the stroke between the pure phases under the load, or from the drawn length [m]."""
    cold_force: float
    hot_force: float
    hot_stress: float
    full_current: float
    """Current of the supply without a series resistance [A]."""
    cycle: PulseCycle | None
    """Pulse that contracts the wire in the requested time, and the cooling; None if no current does."""
    supply_time: float | None
    """Contraction time [s] at the largest supply current, if longer than requested."""
    holding_temperature: float
    holding_current: float
    """Continuous current that keeps the wire contracted [A]."""
    most_current: float
    """Continuous current at the temperature limit of the material [A]."""
    temperature_limit: float
    stress_limit: float
    strain_limit: float
    returns: bool
    """True if the ambient is below M_f under the cold load."""
    drawn_coil: StretchedCoil | None = None
    """Coil at its drawn length."""
    contradiction: str = ""
    """Contradiction between the measured resistance and the maker's table, or ''."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Return the reasons for which the wire does not work so."""
        faults = [self.contradiction] if self.contradiction else []
        if self.cycle is None:
            faults.append(f"no current contracts the wire in {self.wire.pulse:.3g} s; use a longer pulse")
        elif not self.drivable:
            faults.append(self._describe_supply(self.cycle.current))
        if not self.returns or (self.cycle is not None and self.cycle.cooling is None):
            faults.append(
                "the wire does not return at this ambient temperature and cold load; use a colder ambient or more load"
            )
        stress, limit = self.hot_stress / 1e6, self.stress_limit / 1e6
        if stress > limit:
            faults.append(f"{stress:.4g} MPa is above the maker's {limit:.4g} MPa for repeated use")
        alarms = () if self.cycle is None else self.cycle.exceeded
        faults += [describe_excess(alarm) for alarm in alarms if alarm.kind != "stress"]
        if self.drawn_coil is not None and self.drawn_coil.strain > self.strain_limit:
            strains = (
                f"{100.0 * self.drawn_coil.strain:.3g} % strain, above the maker's {100.0 * self.strain_limit:.3g} %"
            )
            faults.append(f"stretched to {1e3 * self.drawn_coil.length:.4g} mm the coil has {strains}")
        return tuple(faults)

    def _describe_supply(self, needed: float) -> str:
        """Return the lack of supply for a current [A], and a sufficient pulse or supply."""
        most, options = self.supply_current, list[str]()
        if self.supply_time is not None and (pulse := math.ceil(10.2 * self.supply_time) / 10.0) <= LONGEST:
            options.append(f'--pulse "{pulse:.4g} s"')
        if self.full_current < needed:
            options.append(f'--supply "{_round_up(needed * self.strand.resistance):.4g} V"')
        if self.wire.current_limit < needed:
            options.append(f'--current-limit "{_round_up(needed):.4g} A"')
        together = " with " if self.full_current < needed and self.wire.current_limit < needed else " or "
        remedy = together.join(options[-2:]) if together == " with " else " or ".join(options)
        return (
            f"the supply drives {most:.3g} A, {100.0 * (1.0 - most / needed):.2g} % less than the {needed:.3g} A that "
            f"contract it in {self.wire.pulse:.3g} s; use {remedy}"
        )

    @property
    def cautions(self) -> tuple[str, ...]:
        """Return the dangers of the wire."""
        if self.wire.supply <= TOUCHABLE:
            return ()
        needed = "" if self.cycle is None else f", here of at least {self.cycle.current * self.strand.resistance:.3g} V"
        return (
            f"{self.wire.supply:.4g} V can kill. Do not touch bare wire above {TOUCHABLE:.0f} V or connect a wire "
            f"to the mains; use an isolated low-voltage supply{needed}",
        )

    @property
    def supply_current(self) -> float:
        """Return the largest supply current [A]."""
        return min(self.full_current, self.wire.current_limit)

    @property
    def drivable(self) -> bool:
        """Return true if the supply drives the current of the pulse."""
        return self.cycle is not None and self.cycle.current <= self.supply_current

    def series_resistor(self, current: float) -> tuple[float, float]:
        """Return the series resistance [ohm] for a current [A], and its heat [W]."""
        series = self.wire.supply / current - self.strand.resistance
        return series, current**2 * series

    def duty(self, current: float) -> float:
        """Return the duty cycle of a switch that heats as a current [A] does."""
        return (current / self.full_current) ** 2

    @property
    def energy(self) -> float | None:
        """Return the electrical energy of one pulse [J]."""
        return None if self.cycle is None else self.cycle.current**2 * self.strand.resistance * self.cycle.heating

    @property
    def inductance(self) -> float:
        """Return the inductance of the straight wire or the closed coil [H]."""
        if isinstance(self.strand, CoilStrand):
            across = self.strand.coil_diameter
            return VACUUM * self.strand.turns**2 * 0.25 * math.pi * across**2 / (self.strand.solid + 0.45 * across)
        shape = math.log(4.0 * self.strand.length / self.size.diameter.value) - 1.0
        return VACUUM * self.strand.length / (2.0 * math.pi) * shape

    def describe_coil(self) -> dict[str, float] | None:
        """Return turns, diameters and lengths of a coil; None for a straight wire."""
        return self.strand.describe_shape(self.cold_force / self.strand.bearing, self.hot_stress)

    @property
    def count(self) -> int | None:
        """Return the number of parallel wires of the supply; None without a current limit."""
        if self.cycle is None or math.isinf(self.wire.current_limit):
            return None
        return int(self.wire.current_limit / self.cycle.current * (1.0 + 1e-9))

    def to_dict(self) -> dict[str, Any]:
        """Return all results as plain values, in SI."""
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
            "coil": self.describe_coil(),
            "drawn": self.drawn_coil and asdict(self.drawn_coil),
            "supply_time": self.supply_time,
            "table_current": self.size.current.value,
            "count": self.count,
            "faults": list(self.faults),
            "cautions": list(self.cautions),
        }


def rate_wire(wire: WireInHand, catalogue: WireCatalogue | None = None) -> WireRatings:
    """Return requirements and performance of a wire or coil.

    Args:
        wire: wire or coil with its supply and load.
        catalogue: available wires, by default the maker's table of Flexinol.

    Raises:
        ParameterError: the catalogue has no such wire, a coil contradicts itself, or the load leaves no stroke.
    """
    catalogue = catalogue or load_wires()
    strand = wire.make_strand(catalogue)
    mechanism, limits = wire.mechanism(strand), list_alloy_numbers(wire.alloy)
    free, cold, hot = _find_stroke(strand, mechanism)
    held_at = wire.stretched if isinstance(wire, CoilInHand) and wire.gives("stretched") else None
    state = draw_out(strand, held_at) if held_at is not None and isinstance(strand, CoilStrand) else None
    offset = _find_held(strand, state, cold)
    stroke = free - USABLE * offset
    if free <= 0.0 or stroke <= 0.0:
        cause = f"it would stand under {cold / strand.bearing / 1e6:.4g} MPa when cold"
        if free > 0.0 and state is not None:
            cause = f"hot, it is longer under it than the {1e3 * state.length:.4g} mm to which it is drawn out"
        raise ParameterError(f"The load leaves no stroke: {cause}.")
    holding = strand.shift_temperature("A_f", hot / strand.bearing) + ABOVE
    full = wire.supply / strand.resistance
    places, most = (offset + stroke, offset + RETURNED * stroke), min(full, wire.current_limit)
    cycle, slower = _find_cycle(wire, strand, mechanism, places, most)
    hold = strand.steady_current(holding)
    if cycle is not None and cycle.current < hold:  # a constant current that contracts it keeps it so
        hold, holding = cycle.current, min(holding, cycle.hottest)
    return WireRatings(
        wire,
        strand.size,
        strand,
        stroke,
        cold,
        hot,
        hot / strand.bearing,
        full,
        cycle,
        slower,
        holding,
        hold,
        strand.steady_current(limits["temperature_limit"]),
        limits["temperature_limit"],
        limits["stress_limit"],
        limits["strain_limit"],
        wire.ambient < strand.shift_temperature("M_f", cold / strand.bearing),
        state,
        "" if isinstance(wire, CoilInHand) else wire.find_contradiction(catalogue),
    )


def _round_up(value: float) -> float:
    """Return a value rounded up to three digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.ceil(value / unit * (1.0 - 1e-12)) * unit


def _find_held(strand: Strand, state: StretchedCoil | None, cold: float) -> float:
    """Return the difference between the length under load and the drawn length of a coil [m]."""
    if state is None or not isinstance(strand, CoilStrand):
        return 0.0
    return max(0.0, strand.solid + strand.elongation(1.0, cold) - state.length)


def _find_cycle(
    wire: WireInHand, strand: Strand, mechanism: AbstractMechanism, places: tuple[float, float], most: float
) -> tuple[PulseCycle | None, float | None]:
    """Return the cycle between two places [m], and the time [s] of the supply if it is longer."""
    system, slowness, (contracted, back) = strand.system(mechanism), strand.time_constant(), places
    current = find_current(system, contracted, wire.pulse, strand.size.current.value)
    if current is None:
        return None, None
    run, cooling = simulate_cooling(system, back, current, wire.pulse, slowness)
    cycle = PulseCycle(current, wire.pulse, cooling, run.find_range("temperature")[1], exceeded=judge_run(run).alarms)
    return cycle, None if current <= most else find_reach_time(system, contracted, most, 16.0 * slowness + wire.pulse)


def _find_stroke(strand: Strand, mechanism: AbstractMechanism) -> tuple[float, float, float]:
    """Return the stroke [m] without a stop, and the forces [N] before and after it."""
    area, rate = strand.bearing, 0.0
    if isinstance(mechanism, BiasSpring):
        cold, rate = float(mechanism.preload), float(mechanism.stiffness)
    else:
        cold = float(getattr(mechanism, "mass")) * GRAVITY  # noqa: B009
    share = USABLE * strand.reach
    low, high = 0.0, share * strand.reachable_strain(cold / area, cold / area)
    for _ in range(HALVINGS if rate else 0):
        middle = 0.5 * (low + high)
        if middle < share * strand.reachable_strain(cold / area, (cold + rate * middle) / area):
            low = middle
        else:
            high = middle
    return high, cold, cold + rate * high
