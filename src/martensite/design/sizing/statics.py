"""Statics in closed form: number, length, stresses and loads of the strands.

With the section A of a strand, n strands, force F, stroke s, return stress σ_r and largest stress σ_m:

    spring   n A (σ_m - (1 + ρ) σ_r) ≥ F        preload n A σ_r, rate ρ n A σ_r/s
    weight   n A σ_m ≥ F                        weight W = max(F, n A σ_r)
    strain   ε = min(ε_m, 0.98 ε_f)             ε_f = ε_L + σ_c/E_M - σ_h/E_A
    length   l = s/ε

σ_c and σ_h are the stresses of the cold and hot wire; the elastic elongation under the growing load reduces the stroke.
ρ is the growth of the return spring's force over the stroke, as a fraction of its preload.

A close-wound coil of index C = D/d and N turns is the element `coil-spring`, at large deflection. Its wire carries σ =
√3 τ with Wahl's factor K(C) at the inner fibre, which drives the law and has the limits, so that

    A = F/σ = π d²/(8 √3 C K),      y/ε = √3 l²/(π N d)      (elongation per strain)

and ε_f = d [y_M(σ_c) - y_A(σ_h)] π N/(√3 l²) with the lengths of the two phases of the element. The coil is as wide as
possible with the smallest number of coils, under 20 % more load if allowed. The number of turns is whole, which lowers
the strain slightly.

A strand is simulated with the law `liang-rogers` (mixture modulus) and the material `flexinol-70` or `flexinol-90`; the
resistance per metre of the catalogue for both phases; free convection of a vertical wire in still air (`lefevre-ede`),
or of the wire of a coil as a horizontal one (`churchill-chu`), without mutual heating of turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, Self

from martensite.actuators.assembly import System
from martensite.actuators.elements.base import Spring
from martensite.actuators.elements.coil_spring import CoilSpring
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.wire import AbstractRoundWire, Wire
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.interfaces import override
from martensite.design.sizing.request import WireRequest
from martensite.kernels import floats
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import CurrentSource
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import Material, load_material
from martensite.physics.materials.wires import GRAVITY, WireSize
from martensite.physics.thermal.base import AbstractCooling, Cylinder, Environment
from martensite.physics.thermal.convection import ChurchillChu, LeFevreEde

INDICES = (8.0, 7.0, 6.0, 5.0, 4.0)
"""Tried spring indices D/d, the widest first."""
HEAVIER = 1.2
"""Larger load that a robust wire withstands."""


@cache
def read_alloy(alloy: str) -> Material:
    """Return the material of the alloy `70` or `90`."""
    return load_material(f"flexinol-{alloy}")


@cache
def build_alloy_law(alloy: str) -> LiangRogers:
    """Return the law of an alloy."""
    numbers = list_alloy_numbers(alloy)
    taken: dict[str, Any] = {n: numbers[n] for n in LiangRogers.declarations if n in numbers}
    return LiangRogers(modulus="mixture", **taken)


def list_alloy_numbers(alloy: str) -> dict[str, float]:
    """Return all numbers of the material of an alloy, in SI, by canonical name."""
    return {name: number.value for name, number in read_alloy(alloy).values.items()}


@dataclass(frozen=True)
class Strand:
    """Piece of catalogue wire, by default in still air."""

    size: WireSize
    alloy: str
    length: float
    """[m]"""
    ambient: float
    """[K]"""
    cooling: AbstractCooling = field(default_factory=LeFevreEde)

    @property
    def bearing(self) -> float:
        """Return the force per stress [m²]."""
        return self.size.section

    @property
    def reach(self) -> float:
        """Return the elongation per strain [m]."""
        return self.length

    def cut_for(self, stroke: float, strain: float) -> Self:
        """Return the strand with the length for a stroke [m] at a strain [-]."""
        return replace(self, length=stroke / strain * (self.length / self.reach))

    @property
    def law(self) -> LiangRogers:
        """Return the law of the alloy."""
        return build_alloy_law(self.alloy)

    @property
    def resistance(self) -> float:
        """Return the electrical resistance [ohm]."""
        return self.size.resistance.value * self.length

    @property
    def mass(self) -> float:
        """Return the mass of the wire [kg]."""
        return list_alloy_numbers(self.alloy)["density"] * self.size.section * self.length

    def reachable_strain(self, cold: float, hot: float) -> float:
        """Return ε_L + σ_c/E_M - σ_h/E_A [-], from martensite at `cold` to austenite at `hot` [Pa]."""
        return self.law.eps_L + cold / self.law.E_M - hot / self.law.E_A

    def shift_temperature(self, name: str, stress: float) -> float:
        """Return a transformation temperature [K], such as `M_f`, under `stress` [Pa]."""
        slope = self.law.C_M if name in ("M_s", "M_f") else self.law.C_A
        return getattr(self.law, name) + stress / slope

    def film(self, temperature: float) -> float:
        """Return the film coefficient [W/(m² K)] at a wire temperature [K]."""
        shape = Cylinder(self.size.diameter.value, self.length)
        return self.cooling.film(floats, temperature, self.ambient, shape)

    def describe_shape(self, cold: float, hot: float) -> dict[str, float] | None:
        """Return turns, diameters, lengths and rates of a coil at the cold and hot stress [Pa], in SI, or None."""
        return None

    def steady_current(self, temperature: float) -> float:
        """Return the current [A] that keeps the strand at `temperature` [K]."""
        loss = self.film(temperature) * (temperature - self.ambient)
        return math.sqrt(loss * math.pi * self.size.diameter.value / self.size.resistance.value)

    def time_constant(self) -> float:
        """Return m c/(h S) [s], 50 K above the ambient, without latent heat."""
        numbers = list_alloy_numbers(self.alloy)
        per_area = 0.25 * self.size.diameter.value * numbers["density"] * numbers["heat_capacity"]
        return per_area / self.film(self.ambient + 50.0)

    def make_element(self) -> AbstractRoundWire:
        """Return the strand as an element."""
        return Wire(length=self.length, **self.list_parts())

    def list_parts(self) -> dict[str, Any]:
        """Return the arguments of an element of this wire without its shape."""
        numbers = list_alloy_numbers(self.alloy)
        per_metre = self.size.resistance.value
        return {
            "diameter": self.size.diameter.value,
            "law": self.law,
            "resistance": PerLengthResistance(r_A=per_metre, r_M=per_metre),
            "limits": ElementLimits(**{k: v for k, v in numbers.items() if k in ElementLimits.declarations}),
            **{name: numbers[name] for name in ("density", "heat_capacity", "latent_heat")},
        }

    def system(self, mechanism: AbstractMechanism) -> System:
        """Return the strand on a mechanism, driven by a current."""
        surroundings = Environment(temperature=self.ambient, cooling=self.cooling)
        return System(
            element=self.make_element(), environment=surroundings, source=CurrentSource(), mechanism=mechanism
        )


@dataclass(frozen=True)
class CoilStrand(Strand):
    """Close-wound coil; `length` is the length of its wire."""

    cooling: AbstractCooling = field(default_factory=ChurchillChu)
    index: float = field(kw_only=True)
    """Mean coil diameter over wire diameter."""

    @property
    def turns(self) -> float:
        """Return the number of turns."""
        return self.length / (self.size.diameter.value * math.hypot(math.pi * self.index, 1.0))

    @override
    def cut_for(self, stroke: float, strain: float) -> Self:
        coil = super().cut_for(stroke, strain)
        return replace(coil, length=coil.length * (math.ceil(coil.turns - 1e-9) / coil.turns))

    @property
    def coil_diameter(self) -> float:
        """Return the mean coil diameter [m]."""
        return self.index * self.size.diameter.value

    @cached_property
    def element(self) -> CoilSpring:
        """Return the coil as an element."""
        turns = self.turns
        return CoilSpring(
            coil_diameter=self.coil_diameter,
            coil_measure="mean",
            turns=turns,
            free_length=self.solid,
            deflection="large",
            stress_factor="wahl",
            **self.list_parts(),
        )

    @override
    def make_element(self) -> CoilSpring:
        return self.element

    @property
    def bearing(self) -> float:
        """Return the force per stress at the inner fibre [m²]."""
        return 1.0 / self.element.stress(floats, 1.0)

    @property
    def reach(self) -> float:
        """Return the elongation per strain [m]."""
        return self.element.reach()

    def spring(self, martensite: float, force: float) -> Spring:
        """Return the tangent of a pure phase (martensite 0 or 1) under a force [N]."""
        return self.element.spring(floats, Fractions(martensite, martensite), self.ambient, force)

    def elongation(self, martensite: float, force: float) -> float:
        """Return the elongation [m] of a pure phase under a force [N]."""
        spring = self.spring(martensite, force)
        return spring.free + spring.compliance * force

    @property
    def solid(self) -> float:
        """Return the length of the closed coil [m]."""
        return self.turns * self.size.diameter.value

    @override
    def describe_shape(self, cold: float, hot: float) -> dict[str, float]:
        return {
            "turns": self.turns,
            "mean_diameter": self.coil_diameter,
            "outer_diameter": self.coil_diameter + self.size.diameter.value,
            "solid_length": self.solid,
            "hot_length": self.solid + self.elongation(0.0, hot * self.bearing),
            "cold_length": self.solid + self.elongation(1.0, cold * self.bearing),
            "hot_rate": 1.0 / self.spring(0.0, hot * self.bearing).compliance,
            "cold_rate": 1.0 / self.spring(1.0, cold * self.bearing).compliance,
        }

    @override
    def reachable_strain(self, cold: float, hot: float) -> float:
        between = self.elongation(1.0, cold * self.bearing) - self.elongation(0.0, hot * self.bearing)
        return between / self.reach


USABLE = 0.98
"""Usable fraction of the strain between the pure phases; the rest comes slowly."""


@dataclass(frozen=True)
class Statics:
    """Number, length and loads of the strands; forces of all strands together."""

    count: int
    strand: Strand
    strain: float
    """Contraction over the stroke [-]."""
    reachable: float
    """Contraction between the pure phases at these stresses [-]."""
    cold_stress: float
    """Stress at rest [Pa]."""
    hot_stress: float
    """Stress at the end of the stroke [Pa]."""
    preload: float
    """Force of the return spring or weight on the cold strands [N]."""
    stiffness: float
    """Rate of the return spring [N/m]; 0 with a weight."""
    extra: float
    """Part of the weight that only stretches the strands [N]; 0 with a spring."""
    work_force: float
    """Force of the strands at the end of the stroke [N]."""

    def mechanism(self, stroke: float, share: int = 1) -> AbstractMechanism:
        """Return the return spring and load, divided by `share` strands."""
        if self.stiffness == 0.0:
            return DeadWeight(mass=self.preload / GRAVITY / share)
        rate = (self.work_force - self.preload) / stroke
        return BiasSpring(stiffness=rate / share, preload=self.preload / share)


def compute_statics(request: WireRequest, size: WireSize, alloy: str) -> Statics:
    """Return the smallest number of strands for a request, and their length."""
    one, count = _choose_strand(request, size, alloy)
    area = one.bearing
    if request.bias == "spring":
        preload = count * area * request.return_stress
        stiffness, extra = request.spring_rise * preload / request.stroke, 0.0
        work = request.force + preload + stiffness * request.stroke
    else:
        preload = work = max(request.force, count * area * request.return_stress)
        stiffness, extra = 0.0, preload - request.force
    cold, hot = preload / (count * area), work / (count * area)
    reachable = one.reachable_strain(cold, hot)
    strand = one.cut_for(request.stroke, min(request.strain, USABLE * reachable))
    strain = request.stroke / strand.reach
    return Statics(count, strand, strain, reachable, cold, hot, preload, stiffness, extra, work)


def _choose_strand(request: WireRequest, size: WireSize, alloy: str) -> tuple[Strand, int]:
    """Return one metre of wire, straight or wound as wide as the load allows, and the number of strands."""
    if request.element == "wire":
        one = Strand(size, alloy, 1.0, request.ambient)
        return one, _count_strands(request, one)
    coils = [CoilStrand(size, alloy, 1.0, request.ambient, index=index) for index in INDICES]
    spare = _count_strands(request, coils[-1], HEAVIER) <= request.strands
    counts = [_count_strands(request, coil, HEAVIER if spare else 1.0) for coil in coils]
    widest = counts.index(counts[-1])
    return coils[widest], counts[widest]


def _count_strands(request: WireRequest, one: Strand, heavier: float = 1.0) -> int:
    """Return the whole number of strands for a force, regardless of rounding errors."""
    taken = (1.0 + request.spring_rise) * request.return_stress if request.bias == "spring" else 0.0
    each = one.bearing * (request.stress - taken)
    return max(1, math.ceil(heavier * request.force / each * (1.0 - 1e-12)))
