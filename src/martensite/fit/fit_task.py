"""Fit tasks: logs, their scenarios, free parameters, and search options.

A task becomes a problem in steps. Every log gets a separate scenario, built with the log if the scenario follows it.
Then driving and compared columns are separated, parts are held out, and steps are chosen. The problem is checked
(`start_checks`) before the search.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.base.parameters import find_paths
from martensite.fit.column_matching import ComparedColumn, match_columns, read_columns, read_noise, refuse_swapped
from martensite.fit.condition_tables import INPUTS, is_condition_table
from martensite.fit.descents import INTERRUPTED, MOST_EVALUATIONS, OUT_OF_TIME
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.free_parameters import FIT_FORMS, is_nuisance, read_ranges
from martensite.fit.logs import (
    ALL,
    AUTO,
    EACH,
    NONE,
    LoadedLog,
    Log,
    choose_held_out,
    describe_gaps,
    describe_untimed,
    read_logs,
)
from martensite.fit.path_places import measure_places
from martensite.fit.problem import Problem, build_problem
from martensite.fit.search_monitor import Tell
from martensite.fit.solve import predict_each, solve_problem
from martensite.fit.start_checks import check_start, find_silent_outputs
from martensite.fit.step_choice import choose_step, describe_step_error
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import SearchRange
from martensite.search.free_text import FreeText, parse_free
from martensite.signals.records import Record
from martensite.signals.table import Table
from martensite.simulate.drive_waveforms import Waveforms, by_name

Columns = str | Sequence[str] | Mapping[str, str]


@dataclass(frozen=True)
class FitSearch:
    """Options of the search for the optimum; see `solve`."""

    method: str = "trf"
    loss: str = "linear"
    starts: int = 0
    seed: int = 0
    most: int = MOST_EVALUATIONS


@dataclass(frozen=True)
class FitTask:
    """Task of a fit: logs, free parameters, and options."""

    logs: tuple[Log, ...]
    free: Sequence[str | SearchRange]
    each: Sequence[str | SearchRange] = ()
    hold_out: str | Sequence[str] = AUTO
    columns: Columns | None = None
    """Compared outputs, `OUTPUT=COLUMN*FACTOR`; None for all common outputs of logs and system."""
    noise: Mapping[str, str | float] = field(default_factory=dict[str, str | float])
    step: float | None = None
    """Longest step of all runs [s]; None for the step of the scenario, or a step chosen by the tolerance."""
    search: FitSearch = FitSearch()

    def arrange(self, *, check: bool = True) -> ArrangedFit:
        """Return the complete problem.

        Args:
            check: True to check the start. Otherwise the search may begin without any transformation.

        Raises:
            InputError: logs, scenario and free parameters are inconsistent.
            SolveError: a test run for the choice of the step fails.
        """
        if not self.logs:
            raise InputError("A fit needs at least one log; none given.")
        logs = [] if self.columns else [one for one in self.logs if one.interval is None]
        tables = [one for one in logs if is_condition_table(one.source, one.new_headings)]
        if tables:
            return self._arrange_tables(len(tables))
        loaded_logs = read_logs(self.logs)
        systems = [one.scenario.system for one in loaded_logs]
        paths = list_paths(loaded_logs[0].scenario)
        free = read_ranges(spell_paths(self.free, paths), systems)
        each = read_ranges(spell_paths(self.each, paths), systems, own=True)
        followed = {c: one.record.units[c] for one in loaded_logs for c in one.scenario.follows.values()}
        (noise, input_noise), wanted = (
            read_noise(self.noise, systems[0].outputs(), followed),
            read_columns(self.columns),
        )
        experiments, notes = _build_experiments(loaded_logs, self, wanted)
        if not wanted:
            experiments, more = _drop_silent_outputs(experiments, free, each)
            notes += more
        stepped, more = _choose_steps(experiments, loaded_logs, self.step)
        whole = build_problem(stepped, free, each=each, noise=noise, input_noise=input_noise)
        follows = list(dict.fromkeys(loaded_logs[0].scenario.follows.values()))
        notes += [*more, *(check_start(whole.training, follows) if check else ())]
        models: dict[str, tuple[Scenario, Callable[[Record], Scenario]]] = {
            one.name: (one.scenario, one.log.model) for one in loaded_logs
        }
        return ArrangedFit(whole, models, self.search, tuple(notes), self.hold_out == EACH)

    def _arrange_tables(self, count: int) -> ArrangedFit:
        from martensite.fit.condition_fits import arrange_conditions

        if count < len(self.logs):
            raise InputError("A table of conditions and a log over time are fitted one after the other, not together.")
        conditions = arrange_conditions(self)
        models: dict[str, tuple[Scenario, Callable[[Record], Scenario]]] = {
            one.name: (conditions.scenario, lambda record: conditions.scenario)
            for one in conditions.problem.experiments
        }
        return ArrangedFit(conditions.problem, models, self.search, conditions.notes, conditions.leaves_each_out)

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
        """Return the task with the given changes."""
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
    """Problem with its origin."""

    problem: Problem
    models: dict[str, tuple[Scenario, Callable[[Record], Scenario]]]
    """Record -> its scenario, and a function that builds it with another record."""
    search: FitSearch = FitSearch()
    notes: tuple[str, ...] = ()
    leaves_each_out: bool = False
    """True if every record is also left out in turn."""

    def choose_drift(self, tell: Tell | None = None) -> ArrangedFit:
        """Return the fit with the law of drift that predicts later cycles best, if the free parameters allow several.

        Raises:
            KeyboardInterrupt: the comparison was interrupted.
            SolveError: no law can be fitted.
        """
        from martensite.fit.drift_choice import choose_drift

        problem, notes = choose_drift(
            self.problem, lambda one: solve_problem(one, **vars(self.search), tell=tell, inputs=False)
        )
        return replace(self, problem=problem, notes=(*self.notes, *notes))

    def solve(self, tell: Tell | None = None, state: Path | None = None) -> Fit:
        """Solve the fit; see `solve` for reports and saved states.

        Raises:
            DataError: the headings of a record seem to be swapped.
            SolveError: the runs fail at the start and at all points tried.
        """
        fit = solve_problem(self.problem, **vars(self.search), tell=tell, state=state)
        first, _ = next(iter(self.models.values()))
        if fit.reason in (INTERRUPTED, OUT_OF_TIME):
            return replace(fit, scenario=first, notes=self.notes)
        if first.follows:
            refuse_swapped(fit, self.models)
        cautions = tuple(describe_step_error(fit))
        if self.leaves_each_out:
            weighed = replace(self.problem, prior_scale=fit.problem.prior_scale)
            fit = replace(fit, transfer=predict_each(weighed, vars(self.search), tell))
        return replace(fit, scenario=first, notes=(*self.notes, *fit.notes), cautions=cautions)


def list_paths(scenario: Scenario) -> dict[str, str]:
    """Return path in the scenario, as for `--set` -> path in the system, if they differ."""
    paths = {scenario.places.path(leaf.path): leaf.path for leaf in scenario.system.leaves()}
    own = set(paths.values())
    words = {word: places for word, places in INPUTS.items() if " " not in word and not find_paths(word, own)}
    paths |= {word: paths[place] for word, places in words.items() for place in places if place in paths}
    return {name: path for name, path in paths.items() if name != path and name not in own}


def spell_paths(ranges: str | Sequence[str | SearchRange], paths: Mapping[str, str]) -> list[FreeText | SearchRange]:
    """Return the free parameters with paths in the system; `paths` maps paths of the scenario to these."""
    given = [ranges] if isinstance(ranges, str) else ranges
    parsed = [parse_free(one, *FIT_FORMS) if isinstance(one, str) else one for one in given]
    return [replace(one, name=paths.get(one.name, one.name)) for one in parsed]


def _choose_steps(
    experiments: Sequence[Experiment], loaded_logs: Sequence[LoadedLog], step: float | None
) -> tuple[list[Experiment], list[str]]:
    stepped: list[Experiment] = []
    notes: list[str] = []
    for one, source in zip(experiments, loaded_logs, strict=True):
        given = source.scenario.step if step is None else step
        if given is None:
            one, more = choose_step(one, source.scenario.tolerance)
            notes += more
        else:
            one = replace(one, step=given)
        stepped.append(one)
    return stepped, notes


def _build_experiments(
    loaded_logs: Sequence[LoadedLog], task: FitTask, wanted: Sequence[ComparedColumn]
) -> tuple[list[Experiment], list[str]]:
    """Return one experiment per record, without steps, and remarks on its columns."""
    experiments: list[Experiment] = []
    notes: list[str] = []
    for one in loaded_logs:
        system, follows = one.scenario.system, one.scenario.follows
        columns, record, more = match_columns(one.record, system, wanted, follows)
        notes += [*more, *describe_gaps(one, columns.values())]
        notes += _describe_held(record, system, one.scenario.waveform, follows)
        experiments.append(
            Experiment(
                one.name,
                system,
                one.scenario.waveform,
                record,
                columns,
                weights=dict.fromkeys(columns, one.log.weight),
                lead=one.scenario.lead,
                follows=follows,
                groups=one.log.groups,
            )
        )
    held_out_stretches = _choose_held_out(loaded_logs, experiments, task.hold_out)
    experiments = [
        replace(one, held_out_intervals=stretches)
        for one, stretches in zip(experiments, held_out_stretches, strict=True)
    ]
    return experiments, [*notes, *describe_untimed(loaded_logs)]


def _describe_held(
    record: Record, system: AbstractSystem, waveform: Waveforms, follows: Mapping[str, str]
) -> list[str]:
    """Return the columns with levels that are constant between rows."""
    tables = {column: by_name(system, waveform)[drive] for drive, column in follows.items()}
    level_columns = [
        column for column, one in tables.items() if isinstance(one, Table) and len(one.times) > len(record) + 1
    ]
    return [
        f"Column `{name}` of record `{record.name}` is held: each level acts from its row on until the next."
        for name in level_columns
    ]


def _choose_held_out(
    loaded_logs: Sequence[LoadedLog], experiments: Sequence[Experiment], hold_out: str | Sequence[str]
) -> list[Any]:
    names, flags = [one.name for one in loaded_logs], [one.log.is_held_out for one in loaded_logs]
    if all(flags):
        raise InputError("All records are held out, and none is left to be fitted.")
    rule = NONE if any(flags) and hold_out == AUTO else hold_out
    places = [measure_places(one) for one in experiments] if rule == AUTO else None
    held_out_stretches = choose_held_out(rule, names, [one.times.tolist() for one in experiments], places)
    return [ALL if flag else one for flag, one in zip(flags, held_out_stretches, strict=True)]


def _drop_silent_outputs(
    all_experiments: list[Experiment], free: Sequence[SearchRange], each: Sequence[SearchRange]
) -> tuple[list[Experiment], list[str]]:
    """Return the experiments without outputs that no free parameter affects in any record."""
    own = [one for one in each if not is_nuisance(one.name)]
    training = build_problem(all_experiments, free, each=own).training
    quiet = find_silent_outputs(training)
    pairs = [(one.name, name) for one in training.experiments for name in one.outputs]
    heard = {name for record, name in pairs if (record, name) not in quiet}
    lost = sorted({name for _, name in quiet} - heard)
    moved_columns = [{n: c for n, c in one.columns.items() if n not in lost} for one in all_experiments]
    if not lost or not all(moved_columns):
        return all_experiments, []
    experiments = [replace(one, columns=columns) for one, columns in zip(all_experiments, moved_columns, strict=True)]
    return experiments, [f"Nothing that is free moves `{name}`, which is not compared." for name in lost]
