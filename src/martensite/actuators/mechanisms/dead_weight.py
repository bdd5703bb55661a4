"""Dead weight: a constant pull m g, at any length of the element."""

from __future__ import annotations

from martensite.actuators.elements.base import Spring
from martensite.actuators.mechanisms.base import MECHANISMS, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar, draw_weight
from martensite.actuators.mechanisms.load_line import AbstractLoadLine, LoadLineReference
from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar


@MECHANISMS.register("dead-weight")
class DeadWeight(AbstractLoadLine):
    """A hanging mass; inertia is left out, and the wire is never slack."""

    mass: Scalar = param("kg", "hanging mass", low=0.0, high=1e6, typical="200 g")
    gravity: Scalar = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)

    def start_force(self, xp: Namespace) -> Scalar:
        """The weight m g [N]."""
        return self.mass * self.gravity

    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """The weight m g [N]."""
        return self.start_force(xp)

    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Lift of the mass [m]."""
        return assembly.elongation - elongation

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy:
        """m g times the lift [J]."""
        return MechanicalEnergy(gravity=self.start_force(xp) * shortening)

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """The element hangs from a ceiling, the mass from the element."""
        hung = reading.lengths["element"]
        end = (0.0, 0.0, reading.outputs["position"] - hung)
        wide, thick = 0.2 * hung, 0.015 * hung
        return [
            draw_bar("ceiling", thick, (-wide, 0.0, thick), (wide, 0.0, thick), kind="ground"),
            DrawingShape("element", "wire", ((0.0, 0.0, 0.0), end), 0.0, "element"),
            draw_weight("weight", end, self.mass, 0.02 * hung, 0.15 * hung),
        ]
