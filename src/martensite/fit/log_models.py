"""From logs alone to a model: which experiment, which scenario, its numbers, and whether it predicts.

The experiment is recognised, scenarios are proposed, each is fitted from several starts and judged by what it did not
see. The one that predicts best is kept; of two that are alike, the one with fewer free numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError, SolveError
from martensite.base.toml_text import as_toml
from martensite.fit.api import build_task
from martensite.fit.column_matching import read_columns
from martensite.fit.column_noise import FollowedNoise, find_input_noise
from martensite.fit.cross_validation import HeldOutError, PooledError, cross_validate, pool_errors, with_start
from martensite.fit.experiment_kinds.base import (
    AbstractExperimentKind,
    Proposal,
    RecognisedExperiment,
    propose_scenarios,
    recognise_experiment,
)
from martensite.fit.experiment_kinds.driven import add_waist
from martensite.fit.fit import Fit
from martensite.fit.logs import Source
from martensite.fit.problem import Problem
from martensite.fit.solve import solve_problem
from martensite.logs.lab_files import LabFile
from martensite.logs.reader import read_parts
from martensite.scenario.exact_text import exact_text
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.signals.records import Record

ALIKE = 1.05
"""Ratio of held-out errors below which the model with fewer numbers is kept."""
EVALUATIONS = 60
"""Evaluations of one local search."""
GOOD = 93.0
"""Held-out fit [%] of a simple law beyond which rounder transformations are not tried."""
TRANSFORMED = 0.05
"""Least range of the martensite fraction in a fit that says something of a transformation."""

Stage = Callable[[str], None]


@dataclass(frozen=True)
class TriedModel:
    """A proposal, its fit to all records, and what it predicts."""

    proposal: Proposal
    fit: Fit
    errors: tuple[HeldOutError, ...]

    @cached_property
    def pooled(self) -> list[PooledError]:
        """Return the held-out errors by output; the first is what the experiment is about."""
        return pool_errors(self.errors)


@dataclass(frozen=True)
class LogModel:
    """Model made from logs."""

    experiment: RecognisedExperiment
    chosen: TriedModel
    tried: tuple[TriedModel, ...]
    notes: tuple[str, ...]
    """Assumptions, changes of the logs, and failures."""
    records: tuple[Record, ...] = ()
    """Records as in the logs."""
    named: tuple[str, ...] | None = ()
    """Texts for `--as` that reproduce the reading of the logs; None if the files differ too much for it."""

    @property
    def fit(self) -> Fit:
        """Return the fit of the chosen model to all records."""
        return self.chosen.fit

    @property
    def predicts(self) -> bool:
        """Return whether the model predicts the main output of the experiment, by held-out data."""
        return self.chosen.pooled[0].predicts

    @property
    def follows_logs(self) -> bool:
        """Return whether the scenario follows columns that the logs hold, and not ones that were computed from them."""
        held = {one.name: set(one.columns) for one in self.records}
        needed = [{*one.follows.values(), *one.columns.values()} for one in self.fit.problem.experiments]
        made = {read_columns([text])[0].output for text in self.chosen.proposal.columns if "*" in text}
        whole = all(need - made <= held[one.name] for need, one in zip(needed, self.chosen.proposal.rows, strict=True))
        same = not self.experiment.kind.cuts_rows or all(
            own.times[0] == one.times[0] and own["temperature"][0] == one["temperature"][0]
            for own, one in zip(self.records, self.chosen.proposal.rows, strict=False)
        )
        return whole and same and self.named is not None

    @cached_property
    def input_noise(self) -> tuple[list[FollowedNoise], list[str]]:
        """Return the noise of what drives, which no interval counts, and sentences about it."""
        return find_input_noise(self.fit.problem)

    @property
    def time_constant(self) -> tuple[float, float, float] | None:
        """Return the time constant [s] of an element left to cool, with its interval; None for other experiments."""
        return self.experiment.kind.find_time_constant(self.fit)

    def predict_record(self, record: Record) -> dict[str, Any]:
        """Output -> (rows,) in SI of what the model says of another record, with the mean zero of those fitted.

        Raises:
            InputError: the record lacks a column that drives or is compared.
            SolveError: the run fails.
        """
        proposal, numbers = self.chosen.proposal, self.fit.numbers
        scenario = read_scenario(self.write_scenario(), log=record)
        task = build_task(scenario, [record], [self.fit.problem.free[0].path])
        task = task.with_changes(hold_out="none", columns=list(proposal.columns), step=self.fit.problem.step)
        problem = task.arrange(check=False).problem
        found = problem.evaluate(problem.start)
        if found is None:
            raise SolveError(f"The run of record `{record.name}` fails with the fitted parameters.")
        outputs = problem.experiments[0].outputs
        zeros = {one: [x for n, x in numbers.items() if n.startswith(f"offset.{one}@")] for one in outputs}
        return {
            one: found.fitted[0].model[:, k] + (float(np.mean(zeros[one])) if zeros[one] else 0.0)
            for k, one in enumerate(outputs)
        }

    def write_scenario(self) -> str:
        """Return the scenario with the numbers found, as TOML."""
        fit, places = self.fit, _read_proposal(self.chosen.proposal).places
        shared = [free for free in fit.problem.free if free.record is None]
        found = {
            places.path(leaf.path): exact_text(leaf.value, leaf.declared.unit)
            for leaf in fit.system().leaves()
            if any(free.moves(leaf.path) for free in shared)
        }
        return as_toml(change_document(self.chosen.proposal.document, found))


def _read_files(
    logs: Sequence[Source], named: Mapping[str, str], interval: float | None
) -> tuple[list[Record], list[str], list[LabFile]]:
    """Return the records of logs, sentences about how they were read, and the files."""
    found: list[Record] = []
    files: list[LabFile] = []
    for log in logs:
        parts = [] if isinstance(log, Record) else read_parts(log, named, interval, known=True)
        files += parts
        found += [log] if isinstance(log, Record) else [one.record for one in parts]
    if not found:
        raise DataError("A fit needs at least one log; none given.")
    names = [one.name for one in found]
    numbered = [
        replace(one, name=f"{one.name}-{names[:k].count(one.name) + 1}") if names.count(one.name) > 1 else one
        for k, one in enumerate(found)
    ]
    notes = [f"`{file.record.name}`: {note}" for file in files for note in _describe_file(file)]
    return numbered, notes, files


def _name_columns(files: Sequence[LabFile], logs: int) -> tuple[str, ...] | None:
    """Return texts that name the columns of files with headings `name [unit]` and unknown names."""
    own = [one for one in files if one.renamed]
    said = {tuple(f"{c.number}={c.name}[{c.unit}]" if c.si else f"{c.number}=-" for c in f.columns) for f in own}
    if not own:
        return ()
    return said.pop() if len(said) == 1 and len(own) == logs else None


def _describe_file(file: LabFile) -> list[str]:
    """Return the columns that were told by their values, and what was noticed on reading."""
    guessed = [f"{one.number} as `{one.name} [{one.unit}]`" for one in file.columns if one.known == "values"]
    said = [f"by their values columns are taken, {', '.join(guessed)} (`--as`)."] if guessed else []
    return [*said, *file.notes]


def model_logs(
    logs: Source | Sequence[Source],
    *,
    experiment: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    named: Mapping[str, str] | None = None,
    interval: float | None = None,
    tell: Stage | None = None,
) -> LogModel:
    """Build a model of logs without a scenario: proposed, fitted, and judged by held-out data.

    Args:
        logs: files, or records in SI.
        experiment: what they hold, where it is known; see `martensite.fit.experiment_kinds`.
        overrides: settings of the experiment, by dotted path, such as `element.diameter`.
        named: what columns of files are, by heading or number, where it is not to be guessed (`read_lab_file`).
        interval: time between rows [s] of files without times.
        tell: told what is being done.

    Raises:
        DataError: logs that cannot be read, or recognised, or lack what is indispensable.
        SolveError: no proposal can be run.
    """
    sources = [logs] if isinstance(logs, (str, Path, Record)) else list(logs)
    records, notes, files = _read_files(sources, named or {}, interval)
    said = _name_columns(files, len(sources)) if not named else tuple(f"{key}={text}" for key, text in named.items())
    seen = recognise_experiment(records, experiment)
    moving, still = _part_still(records, seen.measured)
    notes += still
    proposals, more = propose_scenarios(seen, moving, overrides or {})
    notes += more
    tried: list[TriedModel] = []
    while proposals:
        one = proposals.pop(0)
        if tell is not None:
            tell(f"{seen.name}: {one.name}")
        try:
            tried.append(_try_proposal(one, seen.kind))
        except (SolveError, ParameterError) as error:
            notes.append(f"Left out: {one.name}. {error}")
        if tried and not proposals and seen.kind.shows_shape and one.spread:
            best = _choose_model(tried)
            if best.pooled[0].fit_percent < GOOD:
                proposals.append(add_waist(best.proposal, best.fit.numbers))
    if not tried:
        raise SolveError(f"None of the proposed models can be run. {' '.join(notes)}")
    return LogModel(seen, _choose_model(tried), tuple(tried), tuple(dict.fromkeys(notes)), tuple(records), said)


def _part_still(records: Sequence[Record], measured: Sequence[str]) -> tuple[list[Record], list[str]]:
    """Return the records in which all that is to be explained changes, and sentences about the others.

    Raises:
        DataError: a column is missing in one of the records.
    """
    for one in records:
        lost = next((name for name in measured if name not in one.columns), None)
        if lost is not None:
            raise DataError(f"Record `{one.name}` has no column `{lost}`, which others have; fit it apart.")
    still = {one.name: name for one in records for name in measured if not np.nanstd(one[name]) > 0.0}
    notes = [f"`{column}` never changes in `{name}`, which is left out." for name, column in still.items()]
    return [one for one in records if one.name not in still], notes


def _read_proposal(proposal: Proposal) -> Scenario:
    return read_scenario(proposal.text, log=proposal.rows[0])


def _try_proposal(proposal: Proposal, kind: AbstractExperimentKind) -> TriedModel:
    scenario = _read_proposal(proposal)
    task = build_task(scenario, list(proposal.rows), list(proposal.free))
    task = task.with_changes(each=list(proposal.each), hold_out="none", columns=list(proposal.columns))
    problem = task.arrange(check=False).problem
    fit = _solve_from_starts(problem, proposal)
    fit = replace(fit, scenario=scenario)
    errors = cross_validate(fit, problem.free, kind=kind, own_zero=kind.own_zero and bool(proposal.each))
    return TriedModel(proposal, fit, tuple(errors))


def _solve_from_starts(problem: Problem, proposal: Proposal) -> Fit:
    """Return the best of several local searches at whose end something transforms, if there is one."""
    fits: list[Fit] = []
    most = EVALUATIONS if proposal.spread else 2 * EVALUATIONS  # loops are cheap
    for start in ({}, *proposal.others):
        try:
            begun = with_start(problem, start)
            fits.append(solve_problem(begun, starts=0 if fits else proposal.spread, most=most, inputs=False))
        except SolveError:
            continue
    if not fits:
        raise SolveError(f"Every run of the proposal `{proposal.name}` fails.")
    moving = [fit for fit in fits if find_transformed(fit) > TRANSFORMED]
    return min(moving or fits, key=lambda fit: fit.cost)


def find_transformed(fit: Fit) -> float:
    """Return the largest range of the martensite fraction in a fitted record."""
    most = 0.0
    for k, one in enumerate(fit.problem.experiments):
        system = fit.system(k)
        runner = one.runner(
            fit.problem.step, [system.label(port, "martensite_fraction") for port in system.actuators()]
        )
        run = runner.run_one(np.array(runner.compiled.values(system)))
        most = max(most, 0.0 if run is None else float(np.ptp(run, axis=0).max()))
    return most


def _choose_model(tried: Sequence[TriedModel]) -> TriedModel:
    """Return the model with the least held-out error; of those that are alike the one with the fewest numbers."""

    def error(one: TriedModel) -> float:
        return one.pooled[0].rms if one.pooled else math.inf

    least = min(map(error, tried))
    return min((one for one in tried if error(one) <= ALIKE * least), key=lambda one: len(one.fit.problem.free))
