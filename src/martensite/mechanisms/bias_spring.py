"""Bias spring: a linear spring that stretches the element back.

    F = F₀ + k x while positive;   F = 0 when the element is slack

with F₀ the preload at assembly and x the position. Neither wire nor spring can push.
"""

from __future__ import annotations

from martensite.elements.base import Spring
from martensite.mechanisms.base import MECHANISMS
from martensite.mechanisms.load_line import AbstractLoadLine, Assembly
from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar


@MECHANISMS.register("bias-spring")
class BiasSpring(AbstractLoadLine):
    """A linear return spring with preload."""

    stiffness: Scalar = param("N/m", "spring rate", above=0.0, high=1e9)
    preload: Scalar = param("N", "force at assembly", low=0.0, high=1e6, default=0.0)

    def start_force(self, xp: Namespace) -> Scalar:
        """Preload [N]."""
        return self.preload

    def force(self, xp: Namespace, assembly: Assembly, spring: Spring) -> Scalar:
        """Intersection of the two straight lines [N]; zero if they meet in compression."""
        pull = self.preload + self.stiffness * (assembly.elongation - spring.free)
        return xp.maximum(pull / (1.0 + self.stiffness * spring.compliance), 0.0)

    def position(
        self, xp: Namespace, assembly: Assembly, force: Scalar, elongation: Scalar
    ) -> Scalar:
        """Shortening of the spring's path [m]; the spring's own length when slack."""
        return (force - self.preload) * (1.0 / self.stiffness)
