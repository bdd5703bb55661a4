"""The study: its claims and its figure, from the numbers that the thesis prints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.sommerfeld.printed import Printed


@STUDIES.register("sommerfeld")
class Sommerfeld(AbstractStudy):
    """Chapters 4 and 5 of Kossoski's thesis rebuilt: the Sommerfeld effect, and a hot wire."""

    title = "Sommerfeld effect of a motor on a beam, and a wire against it: Kossoski's thesis"
    cites = ("kossoski2018", "elahinia2002", "dynalloy-f1140")
    guide = """\
A motor with an unbalance sits at the tip of an aluminium beam. Near the resonance more voltage
makes more vibration and hardly more speed, until the motor jumps past it: the Sommerfeld effect.
A shape-memory wire from clamp to tip, switched ON/OFF, brings the jump forward.

Rebuilt are the jump from rest at constant voltages, the slow ramps with and without the wire, and
the wire on a bench of its own, from the numbers that the thesis prints and, where these do not
suffice, from calibrated ones.

Look at the difference between printed and calibrated: the jump at constant voltages follows from
the printed numbers, the slow ramps do not. With motor and damping calibrated to the ramp, one
more fitted number, the slack of the wire, meets what was measured with it; that is a fit, not a
prediction.
"""
    scenario_files = ("scenario.toml",)

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the thesis's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        from martensite.studies.sommerfeld import beam_claims, ramp_claims, wire_claims

        return {
            "motor and beam": lambda: beam_claims.claims(self.printed),
            "slow ramps": lambda: ramp_claims.claims(self.printed),
            "the wire": lambda: wire_claims.claims(self.printed),
        }

    def figure(self, path: Path) -> None:
        """Jump and plateau, hysteresis, ramps with and without the wire, its fit, its bench."""
        from martensite.plot.files import write_figure
        from martensite.studies.sommerfeld.figure import draw

        write_figure(draw(self.printed), Path(path))
