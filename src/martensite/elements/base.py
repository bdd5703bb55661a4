"""What every element answers to the system that couples it.

At frozen phase fractions and temperature an element is a linear spring: the elongation is
`free` + `compliance` · force. That is all a mechanism ever sees of it, whatever the law.
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.elements.limits import Limits
from martensite.laws.base import AbstractLaw, Fractions
from martensite.parameters import Parametrised
from martensite.registry import Registry
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.thermal.base import Environment

ELEMENTS: Registry[AbstractElement] = Registry("element", "martensite.elements")


class Spring(NamedTuple):
    """Elongation = free + compliance · force, from the length at zero strain."""

    free: Scalar
    """Elongation at zero force [m]."""
    compliance: Scalar
    """Elongation per force [m/N]."""


class AbstractElement(Parametrised):
    """Interface of an element; `law` is its stress–strain–temperature law."""

    law: AbstractLaw
    limits: Limits

    def initial_fractions(self) -> Fractions:
        """Phase state at the start."""
        raise NotImplementedError

    def heat_capacity_total(self) -> Scalar:
        """Heat capacity without transformation [J/K]."""
        raise NotImplementedError

    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        """Heat released by the whole forward transformation [J] at (stress, temperature)."""
        raise NotImplementedError

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Heat flow to the environment [W]."""
        raise NotImplementedError

    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Spring:
        """The element as a linear spring at frozen fractions and temperature [K]."""
        raise NotImplementedError

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Stress [Pa] that drives the law, from the force [N]."""
        raise NotImplementedError

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Strain [-] of the law, from the elongation [m]."""
        raise NotImplementedError

    def ohms(self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar) -> Scalar:
        """Resistance [ohm]."""
        raise NotImplementedError
