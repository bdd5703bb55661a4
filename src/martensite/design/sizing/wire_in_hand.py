"""Existing straight wire with its supply and load."""

from __future__ import annotations

import math
from dataclasses import replace

from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, option, param
from martensite.design.sizing.request import ALLOYS
from martensite.design.sizing.statics import Strand, list_alloy_numbers
from martensite.physics.electrical.resistances import describe_contradiction
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
"""Cooling: still air (vertical or horizontal), an air stream of 2 m/s, still water or oil."""
NOT_GIVEN = math.inf
"""Marker of a missing number; 0 is a value."""
SPARE = 1e-6
"""Remaining fraction of the stress limit, as a margin for rounding."""
DIAMETER_TOLERANCE = 0.04
"""Relative difference of equal diameters."""


class WireInHand(Parametrised):
    """Piece of wire with its supply and load."""

    diameter: Number = param("m", "diameter of the wire, one of the maker's", above=0.0, high=0.01)
    length: Number = param("m", "length of the wire", above=0.0, high=100.0)
    supply: Number = param("V", "voltage of the supply", above=0.0, high=1e4)
    current_limit: Number = param("A", "largest current of the supply", above=0.0, default=math.inf)
    load: Number = param("N", "weight; by default the maker's pull", above=0.0, high=1e5, default=NOT_GIVEN)
    spring: Number = param("N/m", "spring rate; by default a weight", low=0.0, high=1e7, default=NOT_GIVEN)
    preload: Number = param(
        "N", "spring force when cold; by default the maker's", above=0.0, high=1e5, default=NOT_GIVEN
    )
    pulse: Number = param("s", "time in which it is to contract", low=0.01, high=60.0, default=1.0)
    ambient: Number = param("K", "ambient temperature", low=250.0, high=400.0, default=295.15)
    resistance: Number = param("ohm", "as measured; by default the maker's", above=0.0, high=1e6, default=NOT_GIVEN)
    alloy: str = option("which of the maker's alloys", *ALLOYS, default="90")
    cooling: str = option("what is around the wire", *COOLINGS, default="air")

    @override
    def check(self) -> None:
        if self.gives("load") and (self.gives("spring") or self.gives("preload")):
            raise ParameterError("A wire lifts a weight or pulls a spring; give `load`, or `spring` and `preload`.")

    def gives(self, name: str) -> bool:
        """Return true if a number is given."""
        return getattr(self, name) != NOT_GIVEN

    def find_size(self, catalogue: WireCatalogue) -> WireSize:
        """Return the size of the catalogue, with the measured resistance.

        Raises:
            ParameterError: the catalogue has no such wire.
        """
        best = self._find_listed(catalogue)
        if not self.gives("resistance"):
            return best
        return take_resistance(best, self.resistance, self.length)

    def find_contradiction(self, catalogue: WireCatalogue) -> str:
        """Return the contradiction of the measured resistance to the maker's table, as a clause or ''."""
        if not self.gives("resistance"):
            return ""
        listed = self._find_listed(catalogue).resistance.value
        return describe_contradiction(self.resistance / self.length, listed, self.length, "the maker's table gives")

    def _find_listed(self, catalogue: WireCatalogue) -> WireSize:
        """Return the nearest size of the catalogue; `ParameterError` if none is near."""
        sizes = sorted(catalogue.sizes.values(), key=lambda one: abs(math.log(one.diameter.value / self.diameter)))
        best = sizes[0]
        if abs(best.diameter.value / self.diameter - 1.0) > DIAMETER_TOLERANCE:
            near = " and ".join(sorted(one.name for one in sizes[:2]))
            raise ParameterError(f"The catalogue has no wire of {1e3 * self.diameter:.4g} mm; the nearest are {near}.")
        return best

    def make_strand(self, catalogue: WireCatalogue) -> Strand:
        """Return the wire.

        Raises:
            ParameterError: the catalogue has no such wire.
        """
        return Strand(self.find_size(catalogue), self.alloy, self.length, self.ambient, COOLINGS[self.cooling])

    def choose_load(self, strand: Strand) -> float:
        """Return the default weight [N]: the maker's pull within the stress limit."""
        limit = list_alloy_numbers(self.alloy)["stress_limit"] * strand.bearing
        return min(strand.size.pull_force, (1.0 - SPARE) * limit)

    def mechanism(self, strand: Strand) -> AbstractMechanism:
        """Return the mechanism of the load."""
        if not (self.gives("spring") or self.gives("preload")):
            return DeadWeight(mass=(self.load if self.gives("load") else self.choose_load(strand)) / GRAVITY)
        usual = strand.size.deformation_force * strand.bearing / strand.size.section
        rate, preload = (getattr(self, n) if self.gives(n) else v for n, v in (("spring", 0.0), ("preload", usual)))
        return BiasSpring(stiffness=rate, preload=preload)


def take_resistance(size: WireSize, ohms: float, length: float) -> WireSize:
    """Return a size with a resistance [ohm] measured over a length [m]."""
    cell, note = size.resistance, f"{ohms:.4g} ohm over {1e3 * length:.4g} mm"
    per_metre = ohms / length
    measured = replace(
        cell, value=per_metre, text=f"{per_metre:.9g} ohm/m", kind="measured", source="", where="", note=note
    )
    return replace(size, resistance=measured)
