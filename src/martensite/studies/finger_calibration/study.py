"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from collections.abc import Callable
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
    guide = """\
The paper of the finger finds five numbers of its wire from one slow test, E_M, T_L, Δσ, σ_L and
dσ/dT, by coordinate search within printed ranges. Its record is in a figure that is not in the
text at hand.

Here records are made with its own Table 1 and white noise of 1°, and the same five numbers are
searched for, by coordinate search and by least squares with exact derivatives: what search and
test are worth shows where the answer is known.

Look at the paths: coordinate search stops in a narrow valley across all axes, with an error that
looks like noise; least squares do not. And look at the intervals: the test determines four
numbers of the five, and those only for a spring whose place is known.
"""
    scenario_files = ("scenario.toml",)

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Take the paper's numbers as printed, or others in their place.

        Args:
            printed: the paper's numbers.
            full: coordinate search from all four starts instead of two.
        """
        self.printed, self.full = printed or Printed(), full

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict; without a C compiler one that says so."""
        from martensite.studies.finger_calibration import (
            data_claims,
            gauge_claims,
            search_claims,
        )

        if compiler() is None:
            return {"a C compiler": lambda: [_absent()]}
        return {
            "both searches": lambda: search_claims.claims(self.printed, full=self.full),
            "what the test determines": lambda: data_claims.claims(self.printed),
            "what it leaves open": lambda: gauge_claims.claims(self.printed),
        }

    def figure(self, path: Path) -> None:
        """Paths and costs of both searches, records with their fits, and intervals."""
        from martensite.plot.files import write_figure
        from martensite.studies.finger_calibration.figure import draw

        write_figure(draw(self.printed, full=self.full), Path(path))


def _absent() -> Claim:
    """What takes the place of all claims where they cannot be computed."""
    unknown, verdict = (None, None), "not checkable"
    return Claim("compiler", "all of this study", METHOD, *unknown, "1", None, verdict, WITHOUT)
