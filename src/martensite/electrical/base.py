"""What a resistance model and a source answer.

A source turns the drive signal u (volt, ampere, watt or kelvin) and the resistance of the
element into a current. Only I²R of the element heats it; leads and series resistance do not.
"""

from __future__ import annotations

from typing import ClassVar, NamedTuple

from martensite.parameters import Parametrised, param
from martensite.registry import Registry
from martensite.runtimes.namespace import Namespace, Scalar

RESISTANCES: Registry[AbstractResistance] = Registry("resistance", "martensite.electrical")
SOURCES: Registry[AbstractSource] = Registry("drive", "martensite.electrical")


class Conductor(NamedTuple):
    """The shape that carries the current."""

    area: Scalar
    """Section [m²]."""
    length: Scalar
    """[m]"""


class AbstractResistance(Parametrised):
    """Interface of a resistance model."""

    def resistance(
        self,
        xp: Namespace,
        fraction: Scalar,
        strain: Scalar,
        temperature: Scalar,
        shape: Conductor,
    ) -> Scalar:
        """Resistance [ohm] at martensite `fraction`, `strain` and `temperature` [K]."""
        raise NotImplementedError


class AbstractSource(Parametrised):
    """Interface of a source; `unit` is the SI unit of its drive signal."""

    unit: ClassVar[str] = "1"
    sets_temperature: ClassVar[bool] = False
    """True if the signal is the temperature of the element itself."""

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Current [A] through an element of `resistance` [ohm]."""
        raise NotImplementedError


class AbstractSupply(AbstractSource):
    """Interface of a source with a real supply: limited in current and in voltage."""

    series_resistance: Scalar = param(
        "ohm", "resistance outside the element", low=0.0, high=1e6, default=0.0
    )
    current_limit: Scalar = param("A", "current limit", above=0.0, high=1e6, default=1e6)
    voltage_limit: Scalar = param("V", "supply voltage", above=0.0, high=1e9, default=1e9)

    def most(self, xp: Namespace, resistance: Scalar) -> Scalar:
        """Largest current [A] that the supply drives through an element of `resistance` [ohm]."""
        reachable = self.voltage_limit / (resistance + self.series_resistance)
        return xp.minimum(reachable, self.current_limit)
