"""Wires, tubes and ribbons that turn an arm: twisted, or bent to a circle.

With angle φ between the ends, length l, radius r, and height y over the neutral axis

    torsion    γ = r φ/l,   M = ∫ τ r dA,   σ = √3 τ,   ε = γ/√3 (so that G = E/3)
    bending    ε = y φ/l,   M = ∫ σ y dA.

A mechanism needs a length and a force. An arm or drum of radius a gives e = a φ and F = M/a; with `arm` = 1 m these are
an angle [rad] and a moment [N m], constant along the element.

Fibres of a bent wire or tube lie at equal angles, y = R sin α, with three through the wall of a tube (Simpson's rule);
both are exact for ∫ y² dA. The neutral axis is the middle: one half is computed and counts twice.
"""

import math
from typing import ClassVar

from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.elements.network import Column
from martensite.actuators.elements.section import ROOT3, AbstractSection, find_section_points
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import Cylinder

WALL = ((0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0))
"""Simpson's rule, outer surface last."""


class AbstractArm(AbstractSection):
    """Section that turns an arm."""

    straight: ClassVar[bool] = False

    diameter: Number = param("m", "outer diameter", above=0.0, high=0.02, typical="0.8 mm")
    inner_diameter: Number = param("m", "inner diameter of a tube, else 0", low=0.0, high=0.02, default=0.0)
    length: Number = param("m", "length that is deformed", above=0.0, high=1e3, typical="100 mm")
    arm: Number = param("m", "radius of the arm or drum at its end", above=0.0, high=10.0, typical="5 mm")

    @override
    def check(self) -> None:
        super().check()
        if self.inner_diameter >= self.diameter:
            raise ParameterError(
                f"Parameter `inner_diameter` of `{self.registered_name}` must be below its diameter, "
                f"{1e3 * self.diameter:.4g} mm, but is {1e3 * self.inner_diameter:.4g} mm."
            )

    @override
    def wire_length(self) -> Scalar:
        return self.length

    def section(self) -> Scalar:
        """Return the cross-section of the wall [m²]."""
        return 0.25 * math.pi * (self.diameter + self.inner_diameter) * (self.diameter - self.inner_diameter)


@ELEMENTS.register("torsion-wire")
class TorsionWire(AbstractArm):
    """Twisted straight wire or tube."""

    def fibre_columns(self, xp: Namespace) -> tuple[Column, Column]:
        """Return γ/√3 per arm displacement [1/m] and volume [m³] of the rings."""
        return self.cut_rings(self.inner_diameter, 1.0 / (ROOT3 * self.length * self.arm))


@ELEMENTS.register("bending-beam")
class BendingBeam(AbstractArm):
    """Ribbon, wire or tube that is bent to a circle."""

    shape: str = option("its section", "ribbon", "wire", "tube", default="ribbon")
    diameter: Number = param(
        "m", "outer diameter of a wire or tube, thickness of a ribbon", above=0.0, high=0.02, typical="0.8 mm"
    )
    width: Number = param("m", "width of a ribbon", above=0.0, high=0.1, default=2e-3)
    arm: Number = param("m", "radius of the arm at its end", above=0.0, high=10.0, typical="10 mm")

    @override
    def check(self) -> None:
        super().check()
        if self.inner_diameter > 0.0 and self.shape != "tube":
            raise ParameterError("Parameter `inner_diameter` of `bending-beam` must be 0 unless `shape` is `tube`.")

    @override
    def section(self) -> Scalar:
        return self.diameter * self.width if self.shape == "ribbon" else super().section()

    def cylinder(self) -> Cylinder:
        """Return the cylinder that loses heat; for a ribbon a cylinder of equal perimeter."""
        around = (2.0 / math.pi) * (self.diameter + self.width) if self.shape == "ribbon" else self.diameter
        return Cylinder(around, self.length)

    def fibre_columns(self, xp: Namespace) -> tuple[Column, Column]:
        """Return strain per arm displacement [1/m] and volume [m³], both sides of the neutral axis together."""
        count, half, inner = int(self.fibres), 0.5 * self.diameter, 0.5 * self.inner_diameter
        each = math.pi / (2 * count - 1)
        turns = [((k + 0.5) * each, each if k + 1 < count else 0.5 * each) for k in range(count)]
        if self.shape == "ribbon":
            rows = [(half * s, self.section() * w) for s, w in find_section_points(count)]
        elif self.shape == "wire":
            rows = [(half * math.sin(a), half * half * (4.0 * math.cos(a) ** 2 * w)) for a, w in turns]
        else:
            wall = [(inner + (half - inner) * s, (half - inner) * w) for s, w in WALL]
            rows = [(r * math.sin(a), r * thick * (4.0 * w)) for a, w in turns for r, thick in wall]
        per_height = 1.0 / (self.length * self.arm)
        return [per_height * y for y, _ in rows], [self.length * area for _, area in rows]
