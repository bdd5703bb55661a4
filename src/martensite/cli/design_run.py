"""The run of a design for the command line: read the options, search, compare with a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from martensite.base.errors import InputError, ParameterError
from martensite.cli.options import quantity
from martensite.cli.waiting import share_bar

if TYPE_CHECKING:
    from martensite.design.optimise.designed import Designed
    from martensite.scenario.scenario import Scenario


@dataclass(frozen=True)
class Given:
    """What the command line says about a design."""

    free: Sequence[str]
    minimise: str | None
    maximise: str | None
    subject: Sequence[str]
    life: str | None
    case: Sequence[str]
    grid: int | None
    sample: int
    descents: int
    seed: int

    def check(self) -> None:
        """Raise `ParameterError` for a number out of range."""
        if self.sample < 1 or self.sample & (self.sample - 1):
            raise ParameterError(
                f"Option `--sample` must be a power of 2, such as 64, but is {self.sample}."
            )
        if self.descents < 1:
            raise ParameterError(f"Option `--descents` must be at least 1, but is {self.descents}.")
        if self.grid is not None and self.grid < 2:
            raise ParameterError(f"Option `--grid` must be at least 2, but is {self.grid}.")


def run_design(scenario: Scenario, given: Given, *, saved: bool) -> Designed:
    """Do what the command line says.

    Args:
        scenario: where the search begins.
        given: the options.
        saved: whether the scenario will be written with the numbers found.

    Raises:
        InputError: the scenario is no open loop, or an option does not fit it.
        SolveError: no design can be run.
    """
    from martensite.cli.design_saved import require_written, written
    from martensite.design.optimise.optimise import optimise_design
    from martensite.design.optimise.search import Search

    if scenario.bench is not None:
        raise InputError(
            "A scenario with sensors or controllers cannot be designed: take it without them, and "
            "tune its controller after that."
        )
    if saved:
        require_written(scenario, given.free)
    with share_bar("designing") as tell:
        found = optimise_design(
            scenario.system, scenario.waveform, scenario.duration, given.free,
            minimise=given.minimise, maximise=given.maximise, subject=given.subject,
            life=None if given.life is None else quantity("life", given.life, "1"),
            cases=given.case, samples=scenario.samples, step=scenario.step,
            search=Search(sample=given.sample, descents=given.descents, seed=given.seed),
            written=written(scenario), watch=tell,
        )  # fmt: skip
        if given.grid is None:
            return found
        from martensite.design.optimise.judged import Scales
        from martensite.design.optimise.scan import scan

        watch = None if tell is None else partial(tell, "grid")
        compared = scan(found.designs, Scales(found.question), given.grid, watch)
        return replace(found, scan=compared)
