"""Heat loss at the ends of an element: lumped, by the exact fin between two clamps.

A wire of length l with a uniform source and ends clamped at ambient temperature is cooler near the clamps. With b = m
l/2, m = √(4 h/(k d)), and the contact conductance G_c of one clamp, its steady mean overtemperature is reduced by 1 -
φ,

    φ = tanh b/[b (1 + β tanh b)],   β = k A m/G_c,

so that the total loss is G = h S/(1 - φ) per kelvin of mean overtemperature. The healing length 1/m is the range of a
clamp. `axial-wire` resolves the profile.
"""

from __future__ import annotations

import math
from abc import abstractmethod

from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, param
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import Cylinder

ENDS: Registry[AbstractEnds] = Registry("ends", "martensite.physics.thermal")

PARABOLA_LIMIT = 0.01
"""Half lengths per healing length below which the profile is a parabola."""


class AbstractEnds(Parametrised):
    """Interface of a model of the ends."""

    @abstractmethod
    def conductance(self, xp: Namespace, film: Scalar, shape: Cylinder) -> Scalar:
        """Return the heat flow per mean overtemperature [W/K] of a cylinder with a film [W/(m² K)]."""


@ENDS.register("adiabatic")
class AdiabaticEnds(AbstractEnds):
    """Adiabatic ends."""

    @override
    def conductance(self, xp: Namespace, film: Scalar, shape: Cylinder) -> Scalar:
        return film * (math.pi * shape.diameter * shape.length)


@ENDS.register("clamped")
class ClampedEnds(AbstractEnds):
    """Both ends in clamps at ambient temperature."""

    thermal_conductivity: Number = param("W/m/K", "thermal conductivity", above=0.0, high=1e4, typical="15 W/m/K")
    contact: Number = param("W/K", "contact conductance of one clamp", above=0.0, high=1e9, default=1e3)

    def conductance(self, xp: Namespace, film: Scalar, shape: Cylinder) -> Scalar:
        """Return h S/(1 - φ) [W/K]."""
        section = 0.25 * math.pi * shape.diameter * shape.diameter
        along = self.thermal_conductivity * section
        healing = xp.sqrt(4.0 * film / (self.thermal_conductivity * shape.diameter))
        b = xp.maximum(0.5 * healing * shape.length, PARABOLA_LIMIT)
        heat = xp.tanh(b)
        contact = 2.0 * b * along / (shape.length * self.contact)
        remainder = 1.0 - heat / (b * (1.0 + contact * heat))
        return 4.0 * along / shape.length * b * b / remainder
