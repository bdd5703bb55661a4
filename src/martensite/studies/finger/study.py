"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.finger.printed import Printed


@STUDIES.register("finger")
class FingerStudy(AbstractStudy):
    """The finger rebuilt: heat and law, bending at two powers, a slow loop, other crystals."""

    title = "Finite element modeling and simulation of a robotic finger actuated by SMA wires"
    cites = ("finger-paper", "heintze2008", "furst2012", "ullrich2014")

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the paper's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def claims(self) -> list[Claim]:
        """Every claim with its verdict."""
        from martensite.studies.finger import (
            bending_claims,
            crystal_claims,
            loop_claims,
            wire_claims,
        )

        parts = (wire_claims, bending_claims, crystal_claims, loop_claims)
        return [claim for part in parts for claim in part.claims(self.printed)]

    def figure(self, path: Path) -> None:
        """Angle over time at two powers, the slow loop, intermediate powers, and geometry."""
        from martensite.plot.files import write_figure
        from martensite.studies.finger.figure import draw

        write_figure(draw(self.printed), Path(path))
