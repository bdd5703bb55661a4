"""What a resistance model and a source answer.

A source turns the drive signal u (volt, ampere, watt or kelvin) and the resistance of the
element into a current. Only I²R of the element heats it; leads and series resistance do not.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.parameters import Parametrised
from martensite.registry import Registry
from martensite.runtimes.namespace import Namespace, Scalar

RESISTANCES: Registry[AbstractResistance] = Registry("resistance", "martensite.electrical")
SOURCES: Registry[AbstractSource] = Registry("drive", "martensite.electrical")


class AbstractResistance(Parametrised):
    """Interface of a resistance model."""

    def resistance(
        self,
        xp: Namespace,
        fraction: Scalar,
        strain: Scalar,
        temperature: Scalar,
        area: Scalar,
        length: Scalar,
    ) -> Scalar:
        """Resistance [ohm] of a conductor of section `area` [m²] and `length` [m]."""
        raise NotImplementedError


class AbstractSource(Parametrised):
    """Interface of a source; `unit` is the SI unit of its drive signal."""

    unit: ClassVar[str] = "1"
    sets_temperature: ClassVar[bool] = False
    """True if the signal is the temperature of the element itself."""

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Current [A] through an element of `resistance` [ohm]."""
        raise NotImplementedError
