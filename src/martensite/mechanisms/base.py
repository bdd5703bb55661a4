"""What every mechanism answers: the force on an element that is, for now, a linear spring.

An element at frozen fractions and temperature has elongation = free + compliance · force.
The mechanism closes the loop: it returns the force at which both fit. It is assembled with
the element in its initial state, which defines position zero. Position grows as the element
shortens.
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.elements.base import Spring
from martensite.parameters import Parametrised
from martensite.registry import Registry
from martensite.runtimes.namespace import Namespace, Scalar

MECHANISMS: Registry[AbstractMechanism] = Registry("mechanism", "martensite.mechanisms")


class Assembly(NamedTuple):
    """What a mechanism remembers of being assembled."""

    elongation: Scalar
    """Elongation of the element at position zero [m]."""


class AbstractMechanism(Parametrised):
    """Interface of a quasi-static mechanism with one element and one coordinate."""

    def start_force(self, xp: Namespace) -> Scalar:
        """Force [N] on the element when it is assembled."""
        raise NotImplementedError

    def force(self, xp: Namespace, assembly: Assembly, spring: Spring) -> Scalar:
        """Force [N] at which element and mechanism fit; never below zero."""
        raise NotImplementedError

    def position(
        self, xp: Namespace, assembly: Assembly, force: Scalar, elongation: Scalar
    ) -> Scalar:
        """Coordinate of the mechanism [m]; zero at assembly, growing with contraction."""
        raise NotImplementedError
