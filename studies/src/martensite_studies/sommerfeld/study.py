"""The study of the Sommerfeld effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import TableStudy


@STUDIES.register("sommerfeld")
class Sommerfeld(TableStudy):
    """Chapters 4 and 5 of Kossoski's thesis rebuilt: the Sommerfeld effect, and a hot wire."""

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Beam, ramps, wire."""
        from martensite_studies.sommerfeld import beam_numbers, ramp_numbers, wire_numbers

        return {
            "beam": lambda: beam_numbers.compute_beam(self.printed),
            "ramps": lambda: ramp_numbers.compute_ramps(self.printed),
            "wire": lambda: wire_numbers.compute_wire(self.printed),
        }
