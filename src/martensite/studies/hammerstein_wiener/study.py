"""The study: its claims and its figure, from the numbers that the paper prints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from martensite.runtimes.c99 import compiler
from martensite.studies.base import STUDIES, AbstractStudy, Claim
from martensite.studies.hammerstein_wiener.printed import MODELS, Printed

WITHOUT = "hundreds of runs over 140 000 samples need a C compiler (gcc, clang)"
SEALED = (101, 102, 103, 104, 105)
"""Seeds of records that nothing was chosen with."""


@STUDIES.register("hammerstein-wiener")
class HammersteinWiener(AbstractStudy):
    """A wire identified in two stages and controlled, on a simulated bench of the paper's kind."""

    title = "Hammerstein-Wiener models of a wire: what they repeat, and what they do not"
    cites = ("copaci2019", "leal2016", "martensite")
    guide = """\
The paper identifies a Flexinol wire that lifts 1 kg in two stages, PWM duty to temperature and
temperature to position, each a Hammerstein-Wiener model from a toolbox; it then tunes a PID
controller on the model and runs it on model and wire. It prints two fits, two errors and figures;
its records are not published.

Here the same is done on a simulated bench of its wire, load, current and sample time, which is
none of this library's laws: its hysteresis is a Preisach model with measured branches. Then it is
asked what the paper could not ask: what the models do off the cadence of their record. The bench
is the study's own, so that there is no scenario of it.

Look at the slow ramps: the published structure repeats the cadence of its record and takes
hysteresis for lag, while plays hold at every rate. One model whose latent heat acts back is good
enough to tune a controller on.
"""

    def __init__(self, printed: Printed | None = None, *, full: bool = False) -> None:
        """Take the paper's numbers as printed, or others in their place.

        Args:
            printed: the paper's numbers.
            full: five sealed records instead of two, six other benches instead of three, and
                controllers tuned on other models as well.
        """
        self.printed, self.full = printed or Printed(), full

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """Every claim with its verdict; without a C compiler one that says so."""
        from martensite.studies.hammerstein_wiener import fit_claims, loop_claims

        if compiler() is None:
            return {"a C compiler": lambda: [_absent()]}
        seeds = SEALED if self.full else SEALED[:2]
        return {
            "open loop": lambda: fit_claims.claims(self.printed, seeds, full=self.full),
            "closed loop": lambda: loop_claims.claims(self.printed, full=self.full),
        }

    def figure(self, path: Path) -> None:
        """Records with both models, their loops, and steps of model and bench."""
        from martensite.plot.files import write_figure
        from martensite.studies.hammerstein_wiener.figure import draw

        write_figure(draw(), Path(path))


def _absent() -> Claim:
    """What takes the place of all claims where they cannot be computed."""
    unknown, verdict = (None, None), "not checkable"
    return Claim("compiler", "all of this study", MODELS, *unknown, "1", None, verdict, WITHOUT)
