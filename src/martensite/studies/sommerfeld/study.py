"""The study: its claims and its figure, from the numbers that the thesis prints."""

from __future__ import annotations

from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.sommerfeld.printed import Printed


@STUDIES.register("sommerfeld")
class Sommerfeld(AbstractStudy):
    """Chapters 4 and 5 of Kossoski's thesis rebuilt: the Sommerfeld effect, and a hot wire."""

    title = "Sommerfeld effect of a motor on a beam, and a wire against it: Kossoski's thesis"
    cites = ("kossoski2018", "elahinia2002", "dynalloy-f1140")

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the thesis's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def claims(self) -> list[Claim]:
        """Every claim with its verdict."""
        from martensite.studies.sommerfeld import beam_claims, ramp_claims, wire_claims

        return [
            *beam_claims.claims(self.printed),
            *ramp_claims.claims(self.printed),
            *wire_claims.claims(self.printed),
        ]

    def figure(self, path: Path) -> None:
        """Jump and plateau, hysteresis, ramps with and without the wire, its fit, its bench."""
        from martensite.plot.files import write_figure
        from martensite.studies.sommerfeld.figure import draw

        write_figure(draw(self.printed), Path(path))
