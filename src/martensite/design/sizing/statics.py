"""Statics in closed form: how many strands, how long, under which stresses, against what.

With A the section of a strand, n strands, force F, stroke s, return stress σ_r, largest stress σ_m:

    spring   n A (σ_m - (1 + ρ) σ_r) ≥ F        preload n A σ_r, rate ρ n A σ_r/s
    weight   n A σ_m ≥ F                        weight W = max(F, n A σ_r)
    strain   ε = min(ε_m, 0.98 ε_f)             ε_f = ε_L + σ_c/E_M - σ_h/E_A
    length   l = s/ε

σ_c is the stress of the cold wire and σ_h that of the hot one at the end of the stroke: what the
wire stretches as its load grows is taken off its stroke. ρ is the growth of the return spring's
force over the stroke as a share of its preload.

A strand is a system that can be simulated: law `liang-rogers` with the mixture modulus, numbers of the material
`flexinol-70` or `flexinol-90`; resistance per metre from the catalogue, the same for both phases, since the
catalogue has one value; free convection of a vertical wire in still air (`lefevre-ede`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from martensite.actuators.assembly import System
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.design.sizing.request import WireRequest
from martensite.kernels import floats
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import CurrentSource
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import Material, load_material
from martensite.physics.materials.wires import GRAVITY, WireSize
from martensite.physics.thermal.base import AbstractCooling, Cylinder, Environment
from martensite.physics.thermal.convection import LeFevreEde


@cache
def read_alloy(alloy: str) -> Material:
    """The material of one of the maker's alloys, `70` or `90`."""
    return load_material(f"flexinol-{alloy}")


@cache
def build_alloy_law(alloy: str) -> LiangRogers:
    """The law of one of the maker's alloys."""
    numbers = list_alloy_numbers(alloy)
    taken: dict[str, Any] = {n: numbers[n] for n in LiangRogers.declarations if n in numbers}
    return LiangRogers(modulus="mixture", **taken)


def list_alloy_numbers(alloy: str) -> dict[str, float]:
    """All numbers of the material of an alloy, in SI, by canonical name."""
    return {name: number.value for name, number in read_alloy(alloy).values.items()}


@dataclass(frozen=True)
class Strand:
    """A piece of catalogue wire of one alloy, in still air unless it is cooled otherwise."""

    size: WireSize
    alloy: str
    length: float
    """[m]"""
    ambient: float
    """[K]"""
    cooling: AbstractCooling = field(default_factory=LeFevreEde)

    @property
    def law(self) -> LiangRogers:
        """The law of the alloy."""
        return build_alloy_law(self.alloy)

    @property
    def resistance(self) -> float:
        """Electrical resistance [ohm]."""
        return self.size.resistance.value * self.length

    @property
    def mass(self) -> float:
        """Mass of the wire [kg]."""
        return list_alloy_numbers(self.alloy)["density"] * self.size.section * self.length

    def reachable_strain(self, cold: float, hot: float) -> float:
        """ε_L + σ_c/E_M - σ_h/E_A [-]: martensite at `cold` [Pa] to austenite at `hot` [Pa]."""
        return self.law.eps_L + cold / self.law.E_M - hot / self.law.E_A

    def shifted(self, name: str, stress: float) -> float:
        """A transformation temperature [K], such as `M_f`, under `stress` [Pa]."""
        slope = self.law.C_M if name in ("M_s", "M_f") else self.law.C_A
        return getattr(self.law, name) + stress / slope

    def film(self, temperature: float) -> float:
        """Film coefficient [W/(m² K)] at a wire temperature [K]."""
        shape = Cylinder(self.size.diameter.value, self.length)
        return self.cooling.film(floats, temperature, self.ambient, shape)

    def steady_current(self, temperature: float) -> float:
        """Current [A] that holds the strand at `temperature` [K] for ever."""
        loss = self.film(temperature) * (temperature - self.ambient)
        return math.sqrt(loss * math.pi * self.size.diameter.value / self.size.resistance.value)

    def time_constant(self) -> float:
        """m c/(h S) [s], 50 K above the ambient, without latent heat."""
        numbers = list_alloy_numbers(self.alloy)
        per_area = 0.25 * self.size.diameter.value * numbers["density"] * numbers["heat_capacity"]
        return per_area / self.film(self.ambient + 50.0)

    def system(self, mechanism: AbstractMechanism) -> System:
        """The strand, pulling on a mechanism, driven by a current."""
        numbers = list_alloy_numbers(self.alloy)
        per_metre = self.size.resistance.value
        wire = Wire(
            diameter=self.size.diameter.value,
            length=self.length,
            law=self.law,
            resistance=PerLengthResistance(r_A=per_metre, r_M=per_metre),
            limits=ElementLimits(**{k: v for k, v in numbers.items() if k in ElementLimits.declarations}),
            density=numbers["density"],
            heat_capacity=numbers["heat_capacity"],
            latent_heat=numbers["latent_heat"],
        )
        surroundings = Environment(temperature=self.ambient, cooling=self.cooling)
        return System(element=wire, environment=surroundings, source=CurrentSource(), mechanism=mechanism)


USABLE = 0.98
"""Share of the strain between the pure phases that a design may use: the rest comes slowly."""


@dataclass(frozen=True)
class Statics:
    """Number, length and loads of the strands; forces are those of all strands together."""

    count: int
    strand: Strand
    strain: float
    """Contraction over the stroke [-]."""
    reachable: float
    """Contraction between the pure phases under these stresses [-]."""
    cold_stress: float
    """Stress at rest [Pa]."""
    hot_stress: float
    """Stress at the end of the stroke [Pa]."""
    preload: float
    """Force that stretches the cold strands [N]: of the return spring, or the whole weight."""
    stiffness: float
    """Rate of the return spring [N/m]; 0 with a weight."""
    extra: float
    """Part of the weight that is needed only to stretch the strands [N]; 0 with a spring."""
    work_force: float
    """Force of the strands at the end of the stroke [N]."""

    def mechanism(self, stroke: float, share: int = 1) -> AbstractMechanism:
        """Return and load together, or that part of them which one of `share` strands carries."""
        if self.stiffness == 0.0:
            return DeadWeight(mass=self.preload / GRAVITY / share)
        rate = (self.work_force - self.preload) / stroke
        return BiasSpring(stiffness=rate / share, preload=self.preload / share)


def compute_statics(request: WireRequest, size: WireSize, alloy: str) -> Statics:
    """The smallest number of strands of a size that carries the request, and their length."""
    area = size.section
    if request.bias == "spring":
        left = request.stress - (1.0 + request.spring_rise) * request.return_stress
        count = _count_strands(request.force, area * left)
        preload = count * area * request.return_stress
        stiffness, extra = request.spring_rise * preload / request.stroke, 0.0
        work = request.force + preload + stiffness * request.stroke
    else:
        count = _count_strands(request.force, area * request.stress)
        preload = work = max(request.force, count * area * request.return_stress)
        stiffness, extra = 0.0, preload - request.force
    cold, hot = preload / (count * area), work / (count * area)
    reachable = Strand(size, alloy, 1.0, request.ambient).reachable_strain(cold, hot)
    strain = min(request.strain, USABLE * reachable)
    strand = Strand(size, alloy, request.stroke / strain, request.ambient)
    return Statics(count, strand, strain, reachable, cold, hot, preload, stiffness, extra, work)


def _count_strands(force: float, each: float) -> int:
    """Whole strands for a force; a rounding error does not make one more."""
    return max(1, math.ceil(force / each * (1.0 - 1e-12)))
