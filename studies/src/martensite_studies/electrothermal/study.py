"""The study of the electrothermal staircase."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import TableStudy


@STUDIES.register("electrothermal-staircase")
class ElectrothermalStaircase(TableStudy):
    """Resistance against current of a Flexinol wire under a staircase of voltage.

    The record is not part of the package. Without it the claims that need it are `not
    checkable`, and the figure shows the model alone; both say how to fetch it.
    """

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Record, model, resistance."""
        from martensite_studies.electrothermal import (
            model_numbers,
            record_numbers,
            resistance_numbers,
        )

        return {
            "record": lambda: record_numbers.compute_record(self.printed),
            "model": lambda: model_numbers.compute_model(self.printed),
            "resistance": lambda: resistance_numbers.compute_resistance(self.printed),
        }
