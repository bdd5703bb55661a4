"""A straight wire that is at hand: what it is, what drives it and what it pulls."""

from __future__ import annotations

import math
from dataclasses import replace

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.errors import ParameterError
from martensite.base.parameters import Parametrised, option, param
from martensite.design.sizing.request import ALLOYS
from martensite.design.sizing.statics import Strand
from martensite.kernels.namespace import Scalar
from martensite.physics.fluids.oil import Oil
from martensite.physics.fluids.water import Water
from martensite.physics.materials.wires import GRAVITY, WireCatalogue, WireSize
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
NEAR = 0.04
"""Relative difference of a diameter from one of the catalogue that is the same size."""


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
        return take_resistance(best, self.resistance, self.length)

    def make_strand(self, catalogue: WireCatalogue) -> Strand:
        """The wire.

        Raises:
            ParameterError: the catalogue has no such wire.
        """
        return Strand(self.find_size(catalogue), self.alloy, self.length, self.ambient, COOLINGS[self.cooling])

    def choose_load(self, strand: Strand) -> float:
        """Weight [N] where none is given: the maker's pull."""
        return strand.size.pull_force

    def mechanism(self, strand: Strand) -> AbstractMechanism:
        """What it pulls."""
        if self.spring == 0.0 and self.preload == 0.0:
            return DeadWeight(mass=(self.load or self.choose_load(strand)) / GRAVITY)
        usual = strand.size.deformation_force * strand.bearing / strand.size.section
        return BiasSpring(stiffness=self.spring, preload=self.preload or usual)


def take_resistance(size: WireSize, ohms: float, length: float) -> WireSize:
    """A size whose resistance [ohm] was measured over a length [m]."""
    cell, said = size.resistance, f"{ohms:.4g} ohm over {1e3 * length:.4g} mm"
    per_metre = ohms / length
    measured = replace(
        cell, value=per_metre, text=f"{per_metre:.9g} ohm/m", kind="measured", source="", where="", note=said
    )
    return replace(size, resistance=measured)
