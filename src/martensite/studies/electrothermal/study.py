"""The study: what is stated about the record against the record, and the model against both."""

from __future__ import annotations

from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.electrothermal.printed import Stated


@STUDIES.register("electrothermal-staircase")
class ElectrothermalStaircase(AbstractStudy):
    """Resistance against current of a Flexinol wire under a staircase of voltage.

    The record is not part of the package. Without it the claims that need it are `not
    checkable`, and the figure shows the model alone; both say how to fetch it.
    """

    title = "Electrothermal staircase: resistance against current of a Flexinol wire"
    cites = (
        "leal2016", "dynalloy-f1140", "churchill1975", "lefevre-ede", "liang1990", "furst2012",
    )  # fmt: skip

    def __init__(self, stated: Stated | None = None) -> None:
        """Take the numbers as stated, or others in their place."""
        self.stated = stated or Stated()

    def claims(self) -> list[Claim]:
        """Every claim with its verdict."""
        from martensite.studies.electrothermal import (
            model_claims,
            record_claims,
            resistance_claims,
        )

        parts = (record_claims, model_claims, resistance_claims)
        return [claim for part in parts for claim in part.claims(self.stated)]

    def figure(self, path: Path) -> None:
        """Resistance against current and camera temperature, measured, simulated, identified."""
        from martensite.plot.files import write_figure
        from martensite.studies.electrothermal.figure import draw

        write_figure(draw(self.stated), Path(path))
