"""The study of the finger's calibration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import Printed, TableStudy


@STUDIES.register("finger-calibration")
class FingerCalibration(TableStudy):
    """Section 5.2 of the finger paper on synthetic records: two searches, and what data hold."""

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Take the paper's numbers as printed, or others in their place.

        Args:
            printed: the paper's numbers.
            full: coordinate search from all four starts instead of two.
        """
        super().__init__(printed)
        self.full = full

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Searches, data, gauges."""
        from martensite_studies.finger_calibration import data_numbers, gauge_numbers
        from martensite_studies.finger_calibration.search_numbers import compute_searches

        return {
            "searches": lambda: compute_searches(self.printed, full=self.full),
            "test": lambda: data_numbers.compute_data(self.printed),
            "gauges": lambda: gauge_numbers.compute_gauges(self.printed),
        }

    def figure(self, path: Path) -> None:
        """Write the figure, with as many starts as the claims."""
        from martensite.show.figures.files import write_figure
        from martensite_studies.finger_calibration.figure import draw_figure

        write_figure(draw_figure(self.printed, full=self.full), path)
