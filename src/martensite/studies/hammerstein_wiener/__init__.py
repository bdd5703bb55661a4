"""Study `hammerstein-wiener`: a wire identified in two stages, and a PID controller tuned on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("hammerstein-wiener")
class HammersteinWiener(TableStudy):
    """A wire identified in two stages and controlled, on a simulated bench similar to the paper's."""

    def compute_part(self, key: str) -> Mapping[str, Any]:
        """Return the fits or loops.

        `full` uses five sealed records instead of two, six other benches instead of three, and controllers tuned on
        other models.
        """
        from martensite.studies.hammerstein_wiener.fit_numbers import compute_fit
        from martensite.studies.hammerstein_wiener.loop_numbers import compute_loop

        return (compute_fit if key == "fit" else compute_loop)(full=self.full)
