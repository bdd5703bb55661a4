"""The study of the robotic finger."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import TableStudy


@STUDIES.register("finger")
class FingerStudy(TableStudy):
    """The finger rebuilt: heat and law, bending at two powers, a slow loop, other crystals."""

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Wire, bending, crystals, loop."""
        from martensite_studies.finger import (
            bending_numbers,
            crystal_numbers,
            loop_numbers,
            wire_numbers,
        )

        return {
            "wire": lambda: wire_numbers.compute_wire(self.printed),
            "bending": lambda: bending_numbers.compute_bending(self.printed),
            "crystals": lambda: crystal_numbers.compute_crystals(self.printed),
            "loop": lambda: loop_numbers.compute_loop(self.printed),
        }
