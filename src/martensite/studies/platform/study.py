"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.platform.printed import Printed


@STUDIES.register("platform")
class Platform(AbstractStudy):
    """The parallel platform rebuilt: kinematics, stroke, response times, ON/OFF control."""

    title = "Modeling and simulation of a shape memory alloy spring actuated parallel manipulator"
    cites = ("ranjith2018", "liang1990", "hadi2010", "dynalloy-f1140")

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the paper's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def claims(self) -> list[Claim]:
        """Every claim with its verdict."""
        from martensite.studies.platform import (
            control_claims,
            equation_claims,
            geometry_claims,
            response_claims,
        )

        parts = (geometry_claims, equation_claims, response_claims, control_claims)
        return [claim for part in parts for claim in part.claims(self.printed)]

    def figure(self, path: Path) -> None:
        """Response at two voltages, ON/OFF control, hysteresis, overshoot, reach."""
        from martensite.plot.files import write_figure
        from martensite.studies.platform.figure import draw

        write_figure(draw(self.printed), Path(path))
