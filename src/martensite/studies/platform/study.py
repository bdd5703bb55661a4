"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.platform.printed import Printed


@STUDIES.register("platform")
class Platform(AbstractStudy):
    """The parallel platform rebuilt: kinematics, stroke, response times, ON/OFF control."""

    title = "Modeling and simulation of a shape memory alloy spring actuated parallel manipulator"
    cites = ("ranjith2018", "liang1990", "hadi2010", "dynalloy-f1140")
    guide = """\
A triangular plate on a universal joint is turned about two axes by shape-memory springs at its
three vertices, one of them hot and two cold. The paper prints response times to 25° at two
voltages, the stroke of a spring, and an ON/OFF control of the angle.

Rebuilt are kinematics and springs, the response as printed and with three sets of numbers that
were calibrated to the two times, and the control. The stroke of a spring is met with nothing
fitted.

Look at the response times: by the printed equations their ratio can be no less than (5/3)² =
2.78, and the paper has 1.67, so that a current limit or a lag must have been there. The
calibrated sets do not tell each other apart; the current, or the time to 30°, would.
"""
    scenario_files = ("scenario.toml",)

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the paper's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        from martensite.studies.platform import (
            control_claims,
            equation_claims,
            geometry_claims,
            response_claims,
        )

        return {
            "geometry and stroke": lambda: geometry_claims.claims(self.printed),
            "equations": lambda: equation_claims.claims(self.printed),
            "response times": lambda: response_claims.claims(self.printed),
            "ON/OFF control": lambda: control_claims.claims(self.printed),
        }

    def figure(self, path: Path) -> None:
        """Response at two voltages, ON/OFF control, hysteresis, overshoot, reach."""
        from martensite.plot.files import write_figure
        from martensite.studies.platform.figure import draw

        write_figure(draw(self.printed), Path(path))
