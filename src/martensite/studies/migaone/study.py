"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from collections.abc import Callable
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
    guide = """\
A MigaOne-15 wire actuator lifts 400 g under a slow sine of voltage. The paper fits its film
coefficient h(T) as a parabola to four steady temperatures and simulates the motion with it.

Rebuilt are the geometry of its tables, the fit of h(T), the steady temperatures, the response to
the sine in four variants, and the actuation time. The text at hand has no figures, and the paper
states neither the amplitude of the sine nor the transformation temperatures: these are assumed.

Look at what cannot be: Table 1 prints a diameter ten times too small, the printed R² is beyond
any parabola through the printed points, and the quoted resistance does not give the powers that
Table 2 implies. The curvature of h(T) rests on four points and on an assumed ambient temperature.
"""
    scenario_files = ("scenario.toml",)

    def __init__(self, printed: Printed | None = None) -> None:
        """Take the paper's numbers as printed, or others in their place."""
        self.printed = printed or Printed()

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict, part by part."""
        from martensite.studies.migaone import film_claims, motion_claims, wire_claims

        return {
            "geometry and resistance of the wire": lambda: wire_claims.claims(self.printed),
            "film coefficient and steady temperatures": lambda: film_claims.claims(self.printed),
            "motion under the sine": lambda: motion_claims.claims(self.printed),
        }

    def figure(self, path: Path) -> None:
        """Stroke under the sine, voltage and temperature, h(T), steady temperatures."""
        from martensite.plot.files import write_figure
        from martensite.studies.migaone.figure import draw

        write_figure(draw(self.printed), Path(path))
