"""The study of Hammerstein-Wiener models of a wire."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite_studies.tables import Printed, TableStudy

SEALED = (101, 102, 103, 104, 105)
"""Seeds of records that nothing was chosen with."""


@STUDIES.register("hammerstein-wiener")
class HammersteinWiener(TableStudy):
    """A wire identified in two stages and controlled, on a simulated bench of the paper's kind."""

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Take the paper's numbers as printed, or others in their place.

        Args:
            printed: the paper's numbers.
            full: five sealed records instead of two, six other benches instead of three, and
                controllers tuned on other models as well.
        """
        super().__init__(printed)
        self.full = full

    def computations(self) -> dict[str, Callable[[], Mapping[str, Any]]]:
        """Fits, loops."""
        from martensite_studies.hammerstein_wiener.fit_numbers import compute_fits
        from martensite_studies.hammerstein_wiener.loop_numbers import compute_loops

        seeds = SEALED if self.full else SEALED[:2]
        return {
            "fits": lambda: compute_fits(seeds, full=self.full),
            "loops": lambda: compute_loops(full=self.full),
        }
