"""The study of the heated wire."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import TableStudy


@STUDIES.register("wire-heating")
class WireHeating(TableStudy):
    """Chapter 3 of Kossoski's thesis rebuilt: film coefficient, heat balance, two closures."""

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """All numbers at once."""
        from martensite_studies.wire_heating.numbers import compute_steady

        return {"steady": lambda: compute_steady(self.printed)}
