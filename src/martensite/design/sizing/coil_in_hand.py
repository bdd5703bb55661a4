"""Existing coil spring, from the data on its bag or from measurements.

    N = L_s/d                         turns, from the closed length
    D = √[(l/N)² - d²]/π, l = R/r     mean diameter, from the resistance (a helix of pitch d)
    D = D_o - d                       or from the outer diameter

Redundant data must agree: turns within a tenth or one and a half, the resistance of the wire within a third. The
measured resistance then takes precedence. A coil drawn to a length by hand has the strain of the element there. A
length below the length under load is a stop, where the stroke starts and ends.

Source: the element `coil-spring`; resistance per metre from the maker's table or its continuation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from martensite.actuators.elements.limits import STRONGEST
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.design.sizing.statics import CoilStrand, Strand, list_alloy_numbers
from martensite.design.sizing.wire_in_hand import COOLINGS, NOT_GIVEN, SPARE, WireInHand, take_resistance
from martensite.kernels import floats
from martensite.physics.materials.wires import WireCatalogue, WireSize

LISTED = 0.005
"""Relative difference of equal diameters."""
SLACK_TURNS, SLACK_SHARE, SLACK_OHMS = 1.5, 0.1, 1.0 / 3.0
"""Tolerances of redundant data: turns, relative turns, and relative resistance."""
INDICES = (2.0, 50.0)
"""Range of plausible spring indices."""
HALVINGS = 60
"""Bisections of the force of a coil, up to the largest stress that a wire has withstood."""


@dataclass(frozen=True)
class StretchedCoil:
    """Coil that is held at a length, in SI."""

    length: float
    strain: float
    """Equivalent strain at the surface of the wire [-]."""
    shear: float
    """Shear strain, √3 times the equivalent strain [-]."""
    hot_force: float
    """Force of the heated coil at this length, within the range of the law [N]."""
    hot_stress: float
    """[Pa]"""


class CoilInHand(WireInHand):
    """Close-wound coil with its supply and load."""

    diameter: Number = param("m", "diameter of the wire", low=2e-5, high=2e-3)
    length: Number = param("m", "length of the wire, if it is known", above=0.0, high=100.0, default=NOT_GIVEN)
    turns: Number = param("1", "number of turns", above=0.0, high=1e5, default=NOT_GIVEN)
    solid: Number = param("m", "length of the closed coil", above=0.0, high=100.0, default=NOT_GIVEN)
    outer: Number = param("m", "coil diameter over all", above=0.0, high=1.0, default=NOT_GIVEN)
    stretched: Number = param(
        "m", "length to which it is drawn out when cold", above=0.0, high=100.0, default=NOT_GIVEN
    )

    @override
    def check(self) -> None:
        super().check()
        if not (self.gives("turns") or self.gives("solid")):
            raise ParameterError("Say how many turns the coil has: by `solid`, its closed length, or by `turns`.")
        counted, measured = self.turns, self.solid / self.diameter
        if (
            self.gives("turns")
            and self.gives("solid")
            and abs(counted - measured) > max(SLACK_TURNS, SLACK_SHARE * counted)
        ):
            raise ParameterError(
                f"{1e3 * self.solid:.4g} mm of closed {1e3 * self.diameter:.4g} mm wire are {measured:.1f} turns, but "
                f"`turns` is {counted:.4g}: one of the three is wrong, or the coil is not wound closed."
            )
        if not (self.gives("outer") or self.gives("length") or self.gives("resistance")):
            raise ParameterError(
                "Say how wide the coil is: by `outer`, its diameter over all, or by its `resistance`, which has the "
                "length of its wire in it."
            )
        if self.gives("stretched") and self.stretched <= self.count_turns() * self.diameter:
            raise ParameterError(
                f"`stretched` is {1e3 * self.stretched:.4g} mm, which is not longer than the closed coil, "
                f"{1e3 * self.count_turns() * self.diameter:.4g} mm."
            )
        if self.gives("stretched") and (self.gives("spring") or self.gives("preload")):
            raise ParameterError("A coil is drawn out to a stop (`stretched`) or by a spring (`spring`, `preload`).")

    def count_turns(self) -> float:
        """Return the number of turns, as counted or from the closed length."""
        return self.turns if self.gives("turns") else self.solid / self.diameter

    @override
    def find_size(self, catalogue: WireCatalogue) -> WireSize:
        listed = (one for one in catalogue.sizes.values() if abs(one.diameter.value / self.diameter - 1.0) < LISTED)
        size = next(listed, None) or catalogue.interpolate(self.diameter)
        text = f"{1e3 * self.diameter:.9g} mm"
        given = replace(size.diameter, value=self.diameter, text=text, kind="given", source="", where="", note="")
        return replace(size, diameter=given)

    @override
    def choose_load(self, strand: Strand) -> float:
        return (1.0 - SPARE) * list_alloy_numbers(self.alloy)["stress_limit"] * strand.bearing

    def make_strand(self, catalogue: WireCatalogue) -> CoilStrand:
        """Return the coil.

        Raises:
            ParameterError: length or resistance of the wire contradict the turns or the diameter.
        """
        size, turns = self.find_size(catalogue), self.count_turns()
        per_metre = size.resistance.value
        wound = turns * math.hypot(math.pi * (self.outer - self.diameter), self.diameter)
        wide, long = self.gives("outer"), self.gives("length")
        length = self.length if long else wound if wide else self.resistance / per_metre
        if wide and abs(wound / length - 1.0) > SLACK_SHARE:
            raise ParameterError(
                f"Turns this wide are {1e3 * wound:.4g} mm of wire, but `length` is {1e3 * length:.4g} mm."
            )
        self._check_ohms(length, per_metre)
        each = (length / turns) ** 2 - self.diameter**2
        index = math.sqrt(max(each, 0.0)) / (math.pi * self.diameter)
        if not INDICES[0] <= index <= INDICES[1]:
            raise ParameterError(
                f"{turns:.4g} turns from {1e3 * length:.4g} mm of wire would have a mean diameter of {index:.3g} wire "
                f"diameters, which no coil has: `diameter`, `solid`, `outer` or `resistance` is wrong."
            )
        if self.gives("resistance"):
            size = take_resistance(size, self.resistance, length)
        cooling = COOLINGS["horizontal" if self.cooling == "air" else self.cooling]
        return CoilStrand(size, self.alloy, length, self.ambient, cooling, index=index)

    def _check_ohms(self, length: float, per_metre: float) -> None:
        expected = length * per_metre
        if self.gives("resistance") and abs(math.log(self.resistance / expected)) > math.log1p(SLACK_OHMS):
            raise ParameterError(
                f"{self.count_turns():.4g} turns this wide are {1e3 * length:.4g} mm of wire, which have "
                f"{expected:.3g} ohm by the maker's table, but `resistance` is {self.resistance:.3g} ohm: `diameter`, "
                "`outer`, `turns` or `resistance` is wrong, or it is another alloy."
            )


def draw_out(coil: CoilStrand, length: float) -> StretchedCoil:
    """Return the state of a coil that is drawn to a length [m] and heated there."""
    elongation, low, high = length - coil.solid, 0.0, STRONGEST * coil.bearing
    for _ in range(HALVINGS):
        force = 0.5 * (low + high)
        low, high = (low, force) if coil.elongation(0.0, force) > elongation else (force, high)
    strain = coil.element.strain(floats, elongation)
    return StretchedCoil(length, strain, math.sqrt(3.0) * strain, high, high / coil.bearing)
