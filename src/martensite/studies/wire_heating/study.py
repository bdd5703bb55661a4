"""The study: its claims and its figure, from the numbers that the thesis prints."""

from __future__ import annotations

from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.wire_heating.printed import Printed


@STUDIES.register("wire-heating")
class WireHeating(AbstractStudy):
    """Chapter 3 of Kossoski's thesis rebuilt: film coefficient, heat balance, two closures."""

    title = "Heating of a shape-memory wire by a voltage: Kossoski's thesis, chapter 3"
    cites = ("kossoski2018", "lefevre-ede", "dynalloy-f1140")

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the thesis's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def claims(self) -> list[Claim]:
        """Every claim with its verdict."""
        from martensite.studies.wire_heating import claims

        return claims.claims(self.printed)

    def figure(self, path: Path) -> None:
        """Steady temperatures, film coefficient, and the two closures over time."""
        from martensite.plot.files import write_figure
        from martensite.studies.wire_heating.figure import draw

        write_figure(draw(self.printed), Path(path))
