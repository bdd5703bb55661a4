"""The study: its claims and its figure, from the numbers that the thesis prints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.wire_heating.printed import Printed


@STUDIES.register("wire-heating")
class WireHeating(AbstractStudy):
    """Chapter 3 of Kossoski's thesis rebuilt: film coefficient, heat balance, two closures."""

    title = "Heating of a shape-memory wire by a voltage: Kossoski's thesis, chapter 3"
    cites = ("kossoski2018", "lefevre-ede", "dynalloy-f1140")
    guide = """\
A vertical wire of 0.375 mm and 100 mm under 500 g is heated by nine voltages from 0.5 V to 1.3 V.
The thesis takes its film coefficient from the correlation of LeFevre and Ede and tabulates steady
temperatures.

Rebuilt are the film coefficient, the steady heat balance, and the heating over time. The balance
does not close with the resistances that are printed, nor with the same numbers read as ohms per
metre.

Look at the two closures, both on the bench: A has the correlation and one effective resistance, B
the resistances per metre and one effective film coefficient. Both are fitted to the very rows
that they are compared with; they differ by a factor of three in the time constant, and nothing
printed decides between them.
"""
    scenario_files = ("closure-a.toml", "closure-b.toml")

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the thesis's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        from martensite.studies.wire_heating import claims

        return {"film coefficient, heat balance, closures": lambda: claims.claims(self.printed)}

    def figure(self, path: Path) -> None:
        """Steady temperatures, film coefficient, and the two closures over time."""
        from martensite.plot.files import write_figure
        from martensite.studies.wire_heating.figure import draw

        write_figure(draw(self.printed), Path(path))
