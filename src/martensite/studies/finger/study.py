"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.finger.printed import Printed


@STUDIES.register("finger")
class FingerStudy(AbstractStudy):
    """The finger rebuilt: heat and law, bending at two powers, a slow loop, other crystals."""

    title = "Finite element modeling and simulation of a robotic finger actuated by SMA wires"
    cites = ("finger-paper", "heintze2008", "furst2012", "ullrich2014")
    guide = """\
A robotic finger is bent by a wire of 0.1 mm and 440 mm that is led over the joint there and back,
against a spring. It is heated by 1.4 W or 2 W, with the wire at three distances r from the hinge.
The paper couples the Müller-Achenbach-Seelecke law to a finite-element model; here the same law
pulls on the mechanism `finger`.

The measured angles are in a figure that is not in the text at hand, so that most angles and times
are not checkable. What the text says can be checked in kind: a larger r bends less at the same
power, and the time constants depend on the power.

Look at what this hangs on: the trend in r follows only if brackets and spring, whose places are
not printed, are where the wire can transform to the end. Put the spring at 25 mm on the bench,
and the trend turns round. The slow test with which the paper was calibrated is not quasi-
stationary.
"""
    scenario_files = ("scenario.toml",)

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the paper's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        from martensite.studies.finger import (
            bending_claims,
            crystal_claims,
            loop_claims,
            wire_claims,
        )

        return {
            "heat balance and thresholds of the wire": lambda: wire_claims.claims(self.printed),
            "bending at two powers": lambda: bending_claims.claims(self.printed),
            "single crystal and polycrystal": lambda: crystal_claims.claims(self.printed),
            "the calibration loop": lambda: loop_claims.claims(self.printed),
        }

    def figure(self, path: Path) -> None:
        """Angle over time at two powers, the slow loop, intermediate powers, and geometry."""
        from martensite.plot.files import write_figure
        from martensite.studies.finger.figure import draw

        write_figure(draw(self.printed), Path(path))
