"""A robotic finger: one joint, two half wires that bow over its brackets, a spring against them.

Bracket holes lie at (∓g, -r) from the hinge. With h = θ/2 the path of a wire is shorter by ΔL and
its moment arm is m; the spring k acts at the distance a from the hinge, always across it:

    ΔL(θ) = 2 [r sin h + g (1 - cos h)],   m = dΔL/dθ = r cos h + g sin h
    2 F m(θ) = k a (δ₀ + a θ)

The element is both halves as one wire of twice the length, so that it shortens by 2 ΔL. Zero of θ
is the cold finger with all martensite oriented. Geometry and numbers are those of a published
finger prototype as completed for this project.
"""

from __future__ import annotations

from typing import Any

from martensite.electrical.furst_seelecke import FurstSeeleckeResistance
from martensite.electrical.power import PowerSource
from martensite.elements.base import Spring
from martensite.elements.wire import Wire
from martensite.laws.base import LAWS
from martensite.materials.base import load_material
from martensite.mechanisms.base import AbstractMechanism, Assembly
from martensite.parameters import param
from martensite.runtimes.bracket import solve_bracketed
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.signals.table import Table
from martensite.system import System
from martensite.thermal.base import Environment
from martensite.thermal.constant import ConstantCooling

WIDEST = 2.8
"""Largest angle [rad]: there brackets met long before."""
NUMBERS = {name: number.value for name, number in load_material("finger-mas").values.items()}
DURATION = 25.0  # [s]


class Finger(AbstractMechanism):
    """A joint bent by two half wires against a spring; its position is the angle [rad].

    Deliberately not registered: other tests go through all that is.
    """

    offset: Scalar = param("m", "distance r of the wire from the hinge", above=0.0)
    bracket: Scalar = param("m", "distance g of a bracket along the phalanx", above=0.0)
    stiffness: Scalar = param("N/m", "spring rate", above=0.0)
    arm: Scalar = param("m", "distance a of the spring from the hinge", above=0.0)
    extension: Scalar = param("m", "extension of the spring at angle zero", above=0.0)

    def shortening(self, xp: Namespace, angle: Scalar) -> Scalar:
        """ΔL [m] of a half wire."""
        h = 0.5 * angle
        return 2.0 * (self.offset * xp.sin(h) + self.bracket * (1.0 - xp.cos(h)))

    def moment_arm(self, xp: Namespace, angle: Scalar) -> Scalar:
        """m [m]."""
        h = 0.5 * angle
        return self.offset * xp.cos(h) + self.bracket * xp.sin(h)

    def pull(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Force in the wire [N] at which the finger rests."""
        torque = self.stiffness * self.arm * (self.extension + self.arm * angle)
        return xp.maximum(torque, 0.0) / (2.0 * self.moment_arm(xp, angle))

    def bent(self, xp: Namespace, shorter: Scalar, compliance: Scalar, count: int = 3) -> Scalar:
        """Angle [rad] at which 2 ΔL + compliance · pull is `shorter` [m]."""

        def missing(xp: Namespace, angle: Scalar) -> Scalar:
            found = 2.0 * self.shortening(xp, angle) + compliance * self.pull(xp, angle)
            return found - shorter

        half = 0.5 * (shorter - compliance * self.pull(xp, 0.0))
        square = self.offset * self.offset + self.bracket * half
        root = xp.sqrt(xp.maximum(square, 0.25 * self.offset * self.offset))
        start = 2.0 * (root - self.offset) / self.bracket
        low = -self.extension / self.arm  # there the spring is relaxed
        return solve_bracketed(xp, missing, start, (low, WIDEST), count)

    def start_force(self, xp: Namespace) -> Scalar:
        """Force at angle zero [N]."""
        return self.pull(xp, 0.0)

    def force(self, xp: Namespace, assembly: Assembly, spring: Spring) -> Scalar:
        """Force [N] at the angle at which wire and finger fit."""
        shorter = assembly.elongation - spring.free
        return self.pull(xp, self.bent(xp, shorter, spring.compliance))

    def position(
        self, xp: Namespace, assembly: Assembly, force: Scalar, elongation: Scalar
    ) -> Scalar:
        """Angle [rad]."""
        return self.bent(xp, assembly.elongation - elongation, 0.0)


def finger_law(name: str = "mas", **changes: Any) -> Any:
    """A law with the numbers of the prototype; keyword arguments replace some."""
    cls: Any = LAWS[name]
    known = {key: NUMBERS[key] for key in cls.declarations if key in NUMBERS}
    return cls(**(known | changes))


def finger(law: Any = None, offset: float = 3.5e-3, arm: float = 8e-3) -> System:
    """The prototype with a law, and r and a [m]."""
    resistance = {
        key: NUMBERS[key] for key in FurstSeeleckeResistance.declarations if key in NUMBERS
    }
    wire = Wire(
        diameter=0.1e-3, length=0.44, density=NUMBERS["density"],
        heat_capacity=NUMBERS["heat_capacity"], latent_heat=NUMBERS["latent_heat"],
        law=law or finger_law(), resistance=FurstSeeleckeResistance(**resistance),
    )  # fmt: skip
    return System(
        element=wire, source=PowerSource(),
        environment=Environment(temperature=295.0, cooling=ConstantCooling(h=200.0)),
        mechanism=Finger(
            offset=offset, bracket=10.6e-3, stiffness=50.0, arm=arm, extension=1e-3
        ),
    )  # fmt: skip


def trapezoid(watts: float = 2.0) -> Table:
    """Power [W] into both halves: zero until 3 s, full from 5 s to 13 s, zero from 15 s on."""
    times = (0.0, 3.0, 5.0, 13.0, 15.0, DURATION)
    return Table(times=times, values=(0.0, 0.0, watts, watts, 0.0, 0.0))
