"""The study of the parallel platform."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import TableStudy


@STUDIES.register("platform")
class Platform(TableStudy):
    """The parallel platform rebuilt: kinematics, stroke, response times, ON/OFF control."""

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Geometry, equations, response, control."""
        from martensite_studies.platform import (
            control_numbers,
            equation_numbers,
            geometry_numbers,
            response_numbers,
        )

        return {
            "geometry": lambda: geometry_numbers.compute_geometry(self.printed),
            "equations": lambda: equation_numbers.compute_equations(self.printed),
            "response": lambda: response_numbers.compute_response(self.printed),
            "control": lambda: control_numbers.compute_control(self.printed),
        }
