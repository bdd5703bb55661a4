"""Study `finger-calibration`: information in the calibration test of the finger."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("finger-calibration")
class FingerCalibration(TableStudy):
    """Section 5.2 of the finger paper on synthetic records: two searches, and parameter identifiability."""

    def compute_part(self, key: str) -> Mapping[str, Any]:
        """Return the numbers of a part; `full` runs coordinate search from four starts instead of two."""
        from martensite.studies.finger_calibration.search_numbers import compute_search

        if key == "search":
            return compute_search(self.printed, full=self.full)
        return super().compute_part(key)

    def figure(self, path: Path) -> None:
        """Write the figure, with the starts of the claims."""
        from martensite.show.figures.style import write_figure
        from martensite.studies.finger_calibration.figure import draw_figure

        write_figure(draw_figure(self.printed, full=self.full), path)
