"""The study of the MigaOne-15 actuator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.migaone.bench import SCENARIO
from martensite_studies.tables import TableStudy


@STUDIES.register("migaone")
class MigaOne(TableStudy):
    """The MigaOne-15 paper rebuilt: geometry, h(T), steady states, sine response, speed."""

    scenario_files = (str(SCENARIO),)

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Wire, film coefficient, motion."""
        from martensite_studies.migaone import film_numbers, motion_numbers, wire_numbers

        return {
            "wire": lambda: wire_numbers.compute_wire(self.printed),
            "film": lambda: film_numbers.compute_film(self.printed),
            "motion": lambda: motion_numbers.compute_motion(self.printed),
        }
