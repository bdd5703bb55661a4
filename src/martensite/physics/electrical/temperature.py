"""Prescribed temperature: a chamber or bath that imposes the temperature of the element.

For isobaric and isothermal tests. No current flows; the heat balance is not solved.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSource


@SOURCES.register("temperature")
class PrescribedTemperature(AbstractSource):
    """The drive signal is the temperature of the element [K]."""

    unit: ClassVar[str] = "K"
    sets_temperature: ClassVar[bool] = True

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """No current."""
        return 0.0 * resistance
