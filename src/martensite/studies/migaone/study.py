"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.migaone.printed import Printed


@STUDIES.register("migaone")
class MigaOne(AbstractStudy):
    """The MigaOne-15 paper rebuilt: geometry, h(T), steady states, sine response, speed."""

    title = "Shape memory alloy modeling and simulation: a MigaOne-15 actuator with h(T)"
    cites = (
        "migaone-paper",
        "liang1990",
        "dynalloy-f1140",
        "dynalloy-table-copy",
        "fingercontrol",
    )

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the paper's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def claims(self) -> list[Claim]:
        """Every claim with its verdict."""
        from martensite.studies.migaone import film_claims, motion_claims, wire_claims

        return [
            *wire_claims.claims(self.printed),
            *film_claims.claims(self.printed),
            *motion_claims.claims(self.printed),
        ]

    def figure(self, path: Path) -> None:
        """Stroke under the sine, voltage and temperature, h(T), steady temperatures."""
        from martensite.plot.files import write_figure
        from martensite.studies.migaone.figure import draw

        write_figure(draw(self.printed), Path(path))
