"""Bias spring: a linear spring that stretches the element back.

    F = F₀ + k x while positive;   F = 0 when the element is slack

with F₀ the preload at assembly and x the position. Neither wire nor spring can push.
"""

from __future__ import annotations

from martensite.actuators.elements.base import Spring
from martensite.actuators.mechanisms.base import MECHANISMS, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar
from martensite.actuators.mechanisms.load_line import AbstractLoadLine, LoadLineReference
from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar


@MECHANISMS.register("bias-spring")
class BiasSpring(AbstractLoadLine):
    """A linear return spring with preload."""

    stiffness: Scalar = param("N/m", "spring rate", above=0.0, high=1e9, typical="150 N/m")
    preload: Scalar = param("N", "force at assembly", low=0.0, high=1e6, default=0.0, typical="1.5 N")

    def start_force(self, xp: Namespace) -> Scalar:
        """Preload [N]."""
        return self.preload

    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """Intersection of the two straight lines [N]; zero if they meet in compression."""
        pull = self.preload + self.stiffness * (assembly.elongation - spring.free)
        return xp.maximum(pull / (1.0 + self.stiffness * spring.compliance), 0.0)

    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Shortening of the spring's path [m]; the spring's own length when slack."""
        return (force - self.preload) * (1.0 / self.stiffness)

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy:
        """½ F²/k [J]."""
        pull = xp.maximum(self.preload + self.stiffness * shortening, 0.0)
        return MechanicalEnergy(springs=(0.5 / self.stiffness) * pull * pull)

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Element and spring in a row between two walls; the spring's own length is not known."""
        element = reading.lengths["element"]
        end, far, tall = element - reading.outputs["position"], 1.6 * element, 0.1 * element
        thick = 0.012 * element
        near_wall = ((-thick, 0.0, -tall), (-thick, 0.0, tall))
        far_wall = ((far + thick, 0.0, -tall), (far + thick, 0.0, tall))
        return [
            draw_bar("wall", thick, *near_wall, kind="ground"),
            draw_bar("wall of the spring", thick, *far_wall, kind="ground"),
            DrawingShape("element", "wire", ((0.0, 0.0, 0.0), (end, 0.0, 0.0)), 0.0, "element"),
            DrawingShape("slider", "object", ((end, 0.0, 0.0),), 0.03 * element),
            DrawingShape("spring", "spring", ((end, 0.0, 0.0), (far, 0.0, 0.0)), 0.04 * element),
        ]
