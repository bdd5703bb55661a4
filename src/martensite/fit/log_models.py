"""Models from logs alone: experiment, scenario, parameters and held-out test.

The experiment is recognised, and scenarios are proposed. Each is fitted from several starts and tested on held-out
data. The simplest is chosen unless a richer scenario predicts clearly better (`log_trials`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, SolveError
from martensite.base.toml_text import as_toml
from martensite.fit.api import build_task
from martensite.fit.column_matching import read_columns
from martensite.fit.column_noise import FollowedNoise, find_input_noise
from martensite.fit.experiment_kinds.base import Proposal, RecognisedExperiment, propose_scenarios, recognise_experiment
from martensite.fit.experiment_kinds.loops import find_column, smooth_drive
from martensite.fit.experiment_kinds.survey import DEFORMATIONS, LOADS
from martensite.fit.experiment_kinds.values import write_value
from martensite.fit.experiment_kinds.winding import wind_angles
from martensite.fit.fit import Fit
from martensite.fit.log_evidence import (
    AssumedMove,
    ShiftedTemperature,
    count_jitter,
    list_dependent,
    list_temperatures,
    trace_assumptions,
)
from martensite.fit.log_trials import (
    INTERRUPTION,
    Keep,
    ModelTrials,
    Stage,
    TriedModel,
    choose_model,
    read_proposal,
    rebuild_problem,
)
from martensite.fit.logs import AUTO, Source
from martensite.fit.problem import Problem
from martensite.fit.proposal_changes import change_proposals, list_held
from martensite.logs.lab_files import LabFile
from martensite.logs.reader import read_parts
from martensite.scenario.exact_text import exact_text
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import read_scenario
from martensite.search.time_box import TimeBox
from martensite.signals.records import Record

UNCERTAIN = 10.0
"""Half width [K] of the interval above which a transformation temperature is undetermined."""
TIME_BOX = 60.0
"""Processor time limit of all trials [s]."""


@dataclass(frozen=True)
class LogModel:
    """Model made from logs."""

    experiment: RecognisedExperiment
    chosen_model: TriedModel
    tried_models: tuple[TriedModel, ...]
    notes: tuple[str, ...]
    """Assumptions, changes of the logs, and failures."""
    records: tuple[Record, ...] = ()
    """Records as in the logs."""
    heading_options: tuple[str, ...] | None = ()
    """Texts for `--as` that reproduce the column assignment; None if it differs between files."""
    stop_reason: str = ""
    """Stop reason of an early end: `interruption` or `time box`."""
    moves: tuple[AssumedMove, ...] = ()
    """Sensitivity of the parameters to each assumed value."""
    untested_assumptions: tuple[str, ...] = ()
    """Paths of assumed values whose effect on the parameters was not computed."""

    @property
    def fit(self) -> Fit:
        """Return the fit of the chosen model to all records."""
        return self.chosen_model.fit

    @property
    def predicts(self) -> bool:
        """Return whether the model predicts the main output of the experiment, tested on held-out data."""
        return bool(self.chosen_model.pooled_errors) and self.chosen_model.pooled_errors[0].predicts

    @property
    def follows_logs(self) -> bool:
        """Return whether the scenario follows logged columns, and not columns computed from them."""
        log_columns = {one.name: set(one.columns) for one in self.records}
        needed = [{*one.follows.values(), *one.columns.values()} for one in self.fit.problem.experiments]
        computed_columns = {
            read_columns([text])[0].output for text in self.chosen_model.proposal.columns if "*" in text
        }
        whole = all(
            need - computed_columns <= log_columns[one.name]
            for need, one in zip(needed, self.chosen_model.proposal.rows, strict=True)
        )
        drive = self.experiment.drive or "temperature"
        same = all(
            len(own) == len(one) and (drive not in own.columns or np.array_equal(own[drive], one[drive]))
            for own, one in zip(self.records, self.chosen_model.proposal.rows, strict=False)
        )
        return whole and same and self.heading_options is not None

    @cached_property
    def input_noise(self) -> tuple[list[FollowedNoise], list[str]]:
        """Return the noise of drives that no interval includes, with remarks; loops are smoothed instead."""
        if self.experiment.kind.axis:
            return [], []
        return find_input_noise(self.fit.problem)

    @cached_property
    def dependent(self) -> dict[str, tuple[str, ...]]:
        """Return the parameters that depend on assumed values, with the paths of these values."""
        return list_dependent(self.fit, self.moves)

    @cached_property
    def undetermined(self) -> dict[str, str]:
        """Return the parameters that the logs do not determine, with the reason."""
        fit = self.fit
        reasons = dict(fit.undetermined)
        for free in fit.problem.free:
            low, high = fit.uncertainty.widen_interval(free.name)
            if free.unit == "K" and high - low > 2.0 * UNCERTAIN and free.name not in reasons:
                reasons[free.name] = f"its 95 % interval is ± {0.5 * (high - low):.2g} K"
        return reasons

    @cached_property
    def temperatures(self) -> list[ShiftedTemperature]:
        """Return the transformation temperatures at zero stress and at each load."""
        return list_temperatures(self.fit, self.moves)

    @property
    def time_constant(self) -> tuple[float, float, float] | None:
        """Return the time constant [s] of a cooling element, with its interval; None for other experiments."""
        return self.experiment.kind.find_time_constant(self.fit)

    def predict_record(self, record: Record) -> dict[str, Any]:
        """Return the predictions of another record, output -> (rows,) in SI, with the mean offset of fitted records.

        Jitter in the drive of a loop is smoothed, as in the fit.

        Raises:
            InputError: the record lacks a drive or compared column.
            SolveError: the run fails.
        """
        proposal, numbers = self.chosen_model.proposal, self.fit.numbers
        if self.experiment.kind.axis and self.experiment.drive in record.columns:
            record = smooth_drive(record, self.experiment.drive)
        scenario = read_scenario(self.write_scenario(), log=record)
        task = build_task(scenario, [record], [self.fit.problem.free[0].path])
        task = task.with_changes(hold_out="none", columns=list(proposal.columns), step=self.fit.problem.step)
        problem = task.arrange(check=False).problem
        evaluation = problem.evaluate(problem.start)
        if evaluation is None:
            raise SolveError(f"The run of record `{record.name}` fails with the fitted parameters.")
        outputs = problem.experiments[0].outputs
        zeros = {one: [x for n, x in numbers.items() if n.startswith(f"offset.{one}@")] for one in outputs}
        return {
            one: evaluation.fitted_records[0].model[:, k] + (float(np.mean(zeros[one])) if zeros[one] else 0.0)
            for k, one in enumerate(outputs)
        }

    def write_scenario(self) -> str:
        """Return the scenario with the fitted parameters, as TOML."""
        fit, places = self.fit, read_proposal(self.chosen_model.proposal).places
        shared = [free for free in fit.problem.free if free.record is None]
        settings = {
            places.path(leaf.path): exact_text(leaf.value, leaf.declared.unit)
            for leaf in fit.system().leaves()
            if any(free.moves(leaf.path) for free in shared)
        }
        return as_toml(change_document(self.chosen_model.proposal.document, settings))


def _read_files(
    logs: Sequence[Source], new_headings: Mapping[str, str], interval: float | None
) -> tuple[list[Record], list[str], list[LabFile]]:
    """Return the records of logs, remarks on reading them, and the files."""
    records: list[Record] = []
    files: list[LabFile] = []
    for log in logs:
        parts = [] if isinstance(log, Record) else read_parts(log, new_headings, interval, known=True)
        files += parts
        records += [log] if isinstance(log, Record) else [one.record for one in parts]
    if not records:
        raise DataError("A fit needs at least one log; none given.")
    names = [one.name for one in records]
    numbered = [
        replace(one, name=f"{one.name}-{names[:k].count(one.name) + 1}") if names.count(one.name) > 1 else one
        for k, one in enumerate(records)
    ]
    notes = [f"`{file.record.name}`: {note}" for file in files for note in _describe_file(file)]
    return numbered, notes, files


def _name_columns(files: Sequence[LabFile], logs: int) -> tuple[str, ...] | None:
    """Return texts that assign the columns of files with headings `name [unit]` and unknown names."""
    own = [one for one in files if one.has_renamed_columns]
    assignments = {tuple(f"{c.number}={c.name}[{c.unit}]" if c.si else f"{c.number}=-" for c in f.columns) for f in own}
    if not own:
        return ()
    return assignments.pop() if len(assignments) == 1 and len(own) == logs else None


def _describe_file(file: LabFile) -> list[str]:
    """Return the columns identified by their values, and remarks on reading."""
    guessed = [f"{one.number} as `{one.name} [{one.unit}]`" for one in file.columns if one.source == "values"]
    notes = [f"by their values columns are taken, {', '.join(guessed)} (`--as`)."] if guessed else []
    return [*notes, *file.notes]


def model_logs(
    logs: Source | Sequence[Source],
    *,
    experiment: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    new_headings: Mapping[str, str] | None = None,
    interval: float | None = None,
    free: Sequence[str] = (),
    fixed: Sequence[str] = (),
    hold_out: str = AUTO,
    starts: int | None = None,
    time_box: float = TIME_BOX,
    tell: Stage | None = None,
    keep: Keep | None = None,
) -> LogModel:
    """Build a model of logs without a scenario: propose, fit, and test on held-out data.

    Args:
        logs: files, or records in SI.
        experiment: kind of experiment, if known; see `martensite.fit.experiment_kinds`.
        overrides: settings of the experiment, by dotted path, such as `element.diameter`.
        new_headings: meaning of columns, by heading or number, which replaces a guess (`read_lab_file`).
        interval: time between rows [s] of files without times.
        free: texts of free parameters, such as `C_A=5..12 MPa/K`, in place of the proposed parameters.
        fixed: names of fixed parameters, each with `=VALUE` if the value is known.
        hold_out: held-out data, as in `fit_logs`, by default each record in turn, or parts of one or two.
        starts: number of further local searches, by default as proposed.
        time_box: processor time limit [s].
        tell: callback with a progress sentence.
        keep: callback after every evaluation, with the problem and the best point.

    Raises:
        DataError: logs cannot be read or recognised, or lack required columns.
        InputError: a free, fixed or held-out name is unknown.
        SolveError: no proposal can be run.
    """
    sources = [logs] if isinstance(logs, (str, Path, Record)) else list(logs)
    records, notes, files = _read_files(sources, new_headings or {}, interval)
    assignments = (
        _name_columns(files, len(sources))
        if not new_headings
        else tuple(f"{key}={text}" for key, text in new_headings.items())
    )
    whole, overrides, wound = wind_angles(records, overrides or {})
    notes += wound
    recognised_experiment = recognise_experiment(whole, experiment)
    moving, still = _part_still(whole, recognised_experiment.measured)
    notes += still
    words = {one.record.name: one.header_entries for one in files}
    proposals, assumptions = propose_scenarios(recognised_experiment, moving, overrides, words)
    notes += assumptions.sentences
    offered, proposals = proposals, change_proposals(proposals, free, fixed)

    def announce(text: str) -> None:
        if tell is not None:
            tell(f"{recognised_experiment.name}: {text}")

    trials = ModelTrials(recognised_experiment.kind, TimeBox(time_box), announce, starts, hold_out, keep)
    trials.run(proposals)
    notes = list(dict.fromkeys([*notes, *trials.notes]))
    best = choose_model(trials.tried_models)
    if trials.stop_reason != INTERRUPTION:
        best = replace(best, fit=count_jitter(best.fit, best.proposal.jitter))

    def rebuild(path: str, text: str) -> Problem:
        changed, _ = propose_scenarios(recognised_experiment, moving, {**overrides, path: text}, words)
        return rebuild_problem(change_proposals(changed, free, fixed), best)

    assumed = _select_assumed(assumptions.assumed, best.proposal)
    given = [*overrides, *_list_given(fixed)]
    fixed_parameters = list_held(offered, best.proposal, read_proposal(best.proposal), given)
    notes += [
        f"`{path}` is held at {write_value(*x)}: the logs do not determine it." for path, x in fixed_parameters.items()
    ]
    assumed |= {path: value for path, (value, _) in fixed_parameters.items()}
    moves = [] if trials.stop_reason == INTERRUPTION else trace_assumptions(best.fit, assumed, rebuild)
    traced = {one.path for one in moves}
    untested = tuple(path for path in assumed if path not in traced)
    tried = tuple(trials.tried_models)
    return LogModel(
        recognised_experiment,
        best,
        tried,
        tuple(notes),
        tuple(records),
        assignments,
        trials.stop_reason,
        tuple(moves),
        untested,
    )


def _list_given(fixed: Sequence[str]) -> list[str]:
    """Return the names of fixed parameters whose value is given."""
    parts = (text.partition("=") for text in fixed)
    return [name.strip() for name, equals, _ in parts if equals]


def _select_assumed(assumed: Mapping[str, float], proposal: Proposal) -> dict[str, float]:
    """Return the assumed values that the scenario of a proposal has; other loads may have others."""
    load = {f"mechanism.{name}" for name in proposal.document.get("mechanism", {})}
    return {path: x for path, x in assumed.items() if path in load or not path.startswith("mechanism.")}


def _part_still(records: Sequence[Record], measured: Sequence[str]) -> tuple[list[Record], list[str]]:
    """Return the records in which all compared outputs change, and remarks on the others.

    Raises:
        DataError: a column is missing in a record.
    """
    for one in records:
        lost = next((name for name in measured if not set(_list_alike(name)) & set(one.columns)), None)
        if lost is not None:
            raise DataError(f"Record `{one.name}` has no column `{lost}`, which others have; fit it apart.")
    columns = {one.name: [find_column(one, name, _list_alike(name)) for name in measured] for one in records}
    still = {one.name: name for one in records for name in columns[one.name] if not np.nanstd(one[name]) > 0.0}
    notes = [f"`{column}` never changes in `{name}`, which is left out." for name, column in still.items()]
    return [one for one in records if one.name not in still], notes


def _list_alike(name: str) -> tuple[str, ...]:
    """Return the equivalent columns: strain or position, stress or force, or the column alone."""
    return next((tuple(group) for group in (DEFORMATIONS, LOADS) if name in group), (name,))
