"""The study: what is stated about the record against the record, and the model against both."""

from __future__ import annotations

from collections.abc import Callable
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
    guide = """\
A Flexinol wire of 0.381 mm and 190 mm, without load, was heated by a staircase of voltage from
1.0 to 4.5 V, and its current and the temperature that a camera reads were recorded. Where the
wire becomes austenite its resistance falls. The record is published but not part of the package.

What is stated about the record is checked on the record. Then the model is set beside it in three
variants: with the maker's sheet and nothing fitted, with resistivities taken from this record,
and with the film coefficient calibrated as well. Last, resistance over martensite fraction and
temperature is identified from the plateaus.

Look at the intervals rather than at the fits: that the resistance falls is certain, by how much
is not, since level and offset of the supply cannot be told apart. The calibrated film coefficient
is several times that of free convection; it is apparent and is not to be used for another wire.
"""
    scenario_files = ("scenario.toml",)
    data = ("flexinol-electrothermal",)

    def __init__(self, stated: Stated | None = None) -> None:
        """Take the numbers as stated, or others in their place."""
        self.stated = stated or Stated()

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        from martensite.studies.electrothermal import (
            model_claims,
            record_claims,
            resistance_claims,
        )

        return {
            "what is stated, on the record": lambda: record_claims.claims(self.stated),
            "the model beside the record": lambda: model_claims.claims(self.stated),
            "resistance identified": lambda: resistance_claims.claims(self.stated),
        }

    def figure(self, path: Path) -> None:
        """Resistance against current and camera temperature, measured, simulated, identified."""
        from martensite.plot.files import write_figure
        from martensite.studies.electrothermal.figure import draw

        write_figure(draw(self.stated), Path(path))
