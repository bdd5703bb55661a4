"""A task: logs, the scenarios that are to explain them, what is free, and how to search."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from martensite.fit.fit import Fit
from martensite.fit.hold_out import AUTO
from martensite.fit.logs import Log
from martensite.fit.problem import Problem
from martensite.fit.search_monitor import Tell
from martensite.fit.solve import MOST_EVALUATIONS, solve_problem
from martensite.fit.step_choice import describe_step_error
from martensite.fit.swapped_columns import refuse_swapped
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record

INTERRUPTED = "interrupted"
Columns = str | Sequence[str] | Mapping[str, str]


@dataclass(frozen=True)
class FitSearch:
    """How the optimum is looked for; see `solve`."""

    method: str = "trf"
    loss: str = "linear"
    starts: int = 0
    seed: int = 0
    most: int = MOST_EVALUATIONS


@dataclass(frozen=True)
class FitTask:
    """What is to be fitted to what, and how."""

    logs: tuple[Log, ...]
    free: Sequence[str | SearchRange]
    each: Sequence[str | SearchRange] = ()
    hold_out: str | Sequence[str] = AUTO
    columns: Columns | None = None
    """Outputs that are compared, `OUTPUT=COLUMN*FACTOR`; all that logs and system share if None."""
    noise: Mapping[str, str | float] = field(default_factory=dict[str, str | float])
    step: float | None = None
    """Longest step of all runs [s]; that of the scenario, or one to its tolerance, if None."""
    search: FitSearch = FitSearch()

    def arrange(self) -> ArrangedFit:
        """The problem, ready to be solved.

        Raises:
            InputError: logs, scenario and free parameters do not fit each other.
            SolveError: a run that is to show the step fails.
        """
        from martensite.fit.arrangement import arrange_task

        return arrange_task(self)

    def with_changes(
        self,
        *,
        each: Sequence[str | SearchRange] = (),
        hold_out: str | Sequence[str] | None = None,
        columns: Columns | None = None,
        noise: Mapping[str, str | float] | None = None,
        step: float | None = None,
        settings: Mapping[str, Any] | None = None,
        search: Mapping[str, Any] | None = None,
    ) -> FitTask:
        """The task with what is given in place of its own; the rest stays as it is."""
        logs = (replace(x, settings={**x.settings, **(settings or {})}) for x in self.logs)
        given = {name: value for name, value in (search or {}).items() if value is not None}
        return replace(
            self,
            logs=tuple(logs),
            each=each or self.each,
            hold_out=self.hold_out if hold_out is None else hold_out,
            columns=columns or self.columns,
            noise={**self.noise, **(noise or {})},
            step=self.step if step is None else step,
            search=replace(self.search, **given),
        )


@dataclass(frozen=True)
class ArrangedFit:
    """A problem, and where it came from."""

    problem: Problem
    models: dict[str, tuple[Scenario, Callable[[Record], Scenario]]]
    """Record -> its scenario, and what makes it with another record."""
    search: FitSearch = FitSearch()
    notes: tuple[str, ...] = ()

    def solve(self, tell: Tell | None = None, state: Path | None = None) -> Fit:
        """The fit; see `solve` for what is told and kept.

        Raises:
            DataError: the headings of a record seem to be swapped.
            SolveError: the runs fail at the start, and at every point tried.
        """
        fit = solve_problem(self.problem, **vars(self.search), tell=tell, state=state)
        if fit.reason != INTERRUPTED:
            refuse_swapped(fit, self.models)
        first, _ = next(iter(self.models.values()))
        cautions = tuple(describe_step_error(fit))
        return replace(fit, scenario=first, notes=self.notes, cautions=cautions)
