"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from pathlib import Path

from martensite.runtimes.c99 import compiler
from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.finger_calibration.printed import METHOD, Printed

WITHOUT = "each search takes hundreds to thousands of runs, which needs a C compiler (gcc, clang)"


@STUDIES.register("finger-calibration")
class FingerCalibration(AbstractStudy):
    """Section 5.2 of the finger paper on synthetic records: two searches, and what data hold."""

    title = "Calibration of a robotic finger: coordinate search, and what the test determines"
    cites = ("finger-paper", "kolda2003", "branch1999", "martensite")

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Take the paper's numbers as printed, or others in their place.

        Args:
            printed: the paper's numbers.
            full: coordinate search from all four starts instead of two.
        """
        self.printed, self.full = printed or Printed(), full

    def claims(self) -> list[Claim]:
        """Every claim with its verdict; without a C compiler one that says so."""
        from martensite.studies.finger_calibration import (
            data_claims,
            gauge_claims,
            search_claims,
        )

        if compiler() is None:
            return [_absent()]
        return [
            *search_claims.claims(self.printed, full=self.full),
            *data_claims.claims(self.printed),
            *gauge_claims.claims(self.printed),
        ]

    def figure(self, path: Path) -> None:
        """Paths and costs of both searches, records with their fits, and intervals."""
        from martensite.plot.files import write_figure
        from martensite.studies.finger_calibration.figure import draw

        write_figure(draw(self.printed, full=self.full), Path(path))


def _absent() -> Claim:
    """What takes the place of all claims where they cannot be computed."""
    unknown, verdict = (None, None), "not checkable"
    return Claim("compiler", "all of this study", METHOD, *unknown, "1", None, verdict, WITHOUT)
