"""One strand of wire as a system that can be simulated, and its numbers in closed form.

Law `liang-rogers` with the mixture modulus, numbers of the material `flexinol-70` or
`flexinol-90`; resistance per metre from the catalogue, the same for both phases, since the
catalogue has one value; free convection of a vertical wire in still air (`lefevre-ede`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

from martensite.actuators.assembly import System
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.kernels import floats
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import CurrentSource
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import Material, load_material
from martensite.physics.materials.wires import WireSize
from martensite.physics.thermal.base import Cylinder, Environment
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
    """A piece of catalogue wire of one alloy in still air."""

    size: WireSize
    alloy: str
    length: float
    """[m]"""
    ambient: float
    """[K]"""

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
        return LeFevreEde().film(floats, temperature, self.ambient, shape)

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
        surroundings = Environment(temperature=self.ambient, cooling=LeFevreEde())
        return System(element=wire, environment=surroundings, source=CurrentSource(), mechanism=mechanism)
