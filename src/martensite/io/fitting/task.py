"""A task: logs, the scenarios that are to explain them, and what is free; from it a problem.

Every log gets a scenario of its own, built with it where the scenario follows a log. Then what
drives is told from what is compared, parts are kept back, steps are chosen, and the whole is
looked at (`checks`) before anything is searched for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from martensite.errors import DataError, InputError
from martensite.identify.fitting.experiment import Experiment
from martensite.identify.fitting.fit import Fit
from martensite.identify.fitting.free import Wish
from martensite.identify.fitting.problem import Problem, problem
from martensite.identify.fitting.solve import MOST, solve
from martensite.identify.fitting.watch import Tell
from martensite.identify.fitting.words import listed
from martensite.io.fitting.checks import look, silent
from martensite.io.fitting.compared import columns_of
from martensite.io.fitting.hold_out import ALL, AUTO, NONE, held_out
from martensite.io.fitting.steps import remarks_on_step, with_step
from martensite.io.fitting.swapped import refuse_swapped
from martensite.io.fitting.wishes import Compared, read_columns, read_noise, read_wishes
from martensite.io.recorded import from_zero
from martensite.io.scenario import Scenario, load, read
from martensite.io.tables import UNTIMED, read_table
from martensite.signals.records import Record

INTERRUPTED = "interrupted"
Source = str | Path | Record
Model = str | Path | Scenario


@dataclass(frozen=True)
class Log:
    """A record to be explained, and by what."""

    source: Source
    """A file, `data:<data set>/<file>`, or a record."""
    scenario: Model
    columns: tuple[str, ...] | None = None
    """Headings of a file that has none."""
    interval: float | None = None
    """Time between rows [s] of a file without times."""
    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Changes to the scenario, by dotted path."""
    weight: float = 1.0
    """Of its squared residuals."""
    held: bool = False
    """Whether it is kept back."""
    name: str = ""
    """In reports; that of the file if left out."""

    def read(self) -> Record:
        """The record, with NaN for missing samples."""
        if isinstance(self.source, Record):
            return self.source
        return read_table(self.source, self.columns, interval=self.interval, gaps=True)

    def model(self, record: Record) -> Scenario:
        """The scenario for a record."""
        given = self.scenario
        if not isinstance(given, Scenario):
            return load(given, self.settings, log=record)
        if self.settings or given.follows:
            return read(given.text, given.path, self.settings, log=record)
        return given


@dataclass(frozen=True)
class Search:
    """How the optimum is looked for; see `solve`."""

    method: str = "trf"
    loss: str = "linear"
    starts: int = 0
    seed: int = 0
    most: int = MOST


@dataclass(frozen=True)
class LogFit(Fit):
    """A fit to logs."""

    scenario: Scenario | None = None
    """That of the first record, as it was before the fit."""
    notes: tuple[str, ...] = ()
    """What was noticed before the search."""
    cautions: tuple[str, ...] = ()
    """What halving the steps changes at its end, if that is noticeable."""


@dataclass(frozen=True)
class Task:
    """What is to be fitted to what, and how."""

    logs: tuple[Log, ...]
    free: Sequence[str | Wish]
    each: Sequence[str | Wish] = ()
    hold_out: str | Sequence[str] = AUTO
    columns: str | Sequence[str] | Mapping[str, str] | None = None
    """Outputs that are compared, `OUTPUT=COLUMN*FACTOR`; all that logs and system share if None."""
    noise: Mapping[str, str | float] = field(default_factory=dict[str, str | float])
    step: float | None = None
    """Longest step of all runs [s]; that of the scenario, or one to its tolerance, if None."""
    search: Search = Search()

    def arranged(self) -> Arranged:
        """The problem, ready to be solved.

        Raises:
            InputError: logs, scenario and wishes do not fit each other.
            SolveError: a run that is to show the step fails.
        """
        return _arranged(self)


@dataclass(frozen=True)
class Arranged:
    """A problem, and where it came from."""

    problem: Problem
    models: dict[str, tuple[Scenario, Callable[[Record], Scenario]]]
    """Record -> its scenario, and what makes it with another record."""
    search: Search = Search()
    notes: tuple[str, ...] = ()

    def solved(self, tell: Tell | None = None, state: Path | None = None) -> LogFit:
        """The fit; see `solve` for what is told and kept.

        Raises:
            DataError: the headings of a record seem to be swapped.
            SolveError: the runs fail at the start, and at every point tried.
        """
        how = self.search
        fit = solve(
            self.problem, method=how.method, loss=how.loss, starts=how.starts, seed=how.seed,
            most=how.most, tell=tell, state=state,
        )  # fmt: skip
        if fit.reason != INTERRUPTED:
            refuse_swapped(fit, self.models)
        first, _ = next(iter(self.models.values()))
        cautions = tuple(remarks_on_step(fit))
        known = {one.name: getattr(fit, one.name) for one in fields(fit)}
        return LogFit(**known, scenario=first, notes=self.notes, cautions=cautions)


@dataclass(frozen=True)
class _Read:
    """A log that has been read."""

    log: Log
    name: str
    record: Record
    scenario: Scenario


def _arranged(task: Task) -> Arranged:
    if not task.logs:
        raise InputError("A fit needs at least one log; none given.")
    found = _read(task.logs)
    systems = [one.scenario.system for one in found]
    free, each = read_wishes(task.free, systems), read_wishes(task.each, systems, own=True)
    noise, wanted = read_noise(task.noise, systems), read_columns(task.columns)
    made, notes = _experiments(found, task, wanted)
    if not wanted:
        made, more = _audible(made, free, each)
        notes += more
    stepped: list[Experiment] = []
    for one, source in zip(made, found, strict=True):
        step = task.step if task.step is not None else source.scenario.step
        if step is not None:
            stepped.append(replace(one, step=step))
            continue
        one, more = with_step(one, source.scenario.tolerance)
        stepped.append(one)
        notes += more
    whole = problem(stepped, free, each=each, noise=noise)
    notes += look(whole.training, list(dict.fromkeys(found[0].scenario.follows.values())))
    models = {one.name: (one.scenario, one.log.model) for one in found}
    return Arranged(whole, models, task.search, tuple(notes))


def _read(logs: Sequence[Log]) -> list[_Read]:
    found: list[_Read] = []
    for log in logs:
        record = log.read()
        scenario = log.model(record)
        if scenario.follows:
            record = from_zero(record)
        found.append(_Read(log, log.name or _name(record), record, scenario))
    names = [one.name for one in found]
    return [
        replace(one, name=f"{one.name}-{names[:k].count(one.name) + 1}")
        if names.count(one.name) > 1
        else one
        for k, one in enumerate(found)
    ]


def _name(record: Record) -> str:
    """A short name: that of the file."""
    last = record.name.rpartition("/")[2]
    return last.rpartition(".")[0] or last if "/" in record.name else last


def _experiments(
    found: Sequence[_Read], task: Task, wanted: Sequence[Compared]
) -> tuple[list[Experiment], list[str]]:
    """One experiment per record, without steps, and what to say of its columns."""
    held = _held(found, task.hold_out)
    made: list[Experiment] = []
    notes: list[str] = []
    for one, stretches in zip(found, held, strict=True):
        system, follows = one.scenario.system, one.scenario.follows
        columns, record, more = columns_of(one.record, system, wanted, follows)
        notes += [*more, *_gaps(one, columns.values())]
        made.append(
            Experiment(
                one.name,
                system,
                one.scenario.waveform,
                record,
                columns,
                held=stretches,
                weights=dict.fromkeys(columns, one.log.weight),
                lead=one.scenario.lead,
            )
        )
    return made, [*notes, *_untimed(found)]


def _untimed(found: Sequence[_Read]) -> list[str]:
    """A sentence about records whose rows are so far apart as nobody has said."""
    names = [one.name for one in found if one.log.interval is None and one.record.interval]
    if not names:
        return []
    return [f"{listed(names)} without times: rows are taken as {UNTIMED:g} s apart."]


def _held(found: Sequence[_Read], hold_out: str | Sequence[str]) -> list[Any]:
    names, flags = [one.name for one in found], [one.log.held for one in found]
    if all(flags):
        raise InputError("All records are held out, and none is left to be fitted.")
    rule = NONE if any(flags) and hold_out == AUTO else hold_out
    held = held_out(rule, names, [one.record.times for one in found])
    return [ALL if flag else one for flag, one in zip(flags, held, strict=True)]


def _gaps(one: _Read, columns: Any) -> list[str]:
    """Sentences about samples that a log misses."""
    follows, record = one.scenario.follows.values(), one.record
    notes: list[str] = []
    for name in dict.fromkeys([*follows, *columns]):
        missing = sum(map(math.isnan, record.columns.get(name, ())))
        if missing:
            then = "bridged by straight lines" if name in follows else "passed over"
            notes.append(
                f"{missing} of {len(record)} samples of `{name}` in record `{record.name}` are "
                f"missing and {then}."
            )
    if record.dropped:
        notes.append(f"{record.dropped} rows of record `{record.name}` could not be read.")
    return notes


def _audible(
    made: list[Experiment], free: Sequence[Wish], each: Sequence[Wish]
) -> tuple[list[Experiment], list[str]]:
    """Experiments without the outputs that no free parameter moves in any record."""
    training = problem(made, free, each=_of_systems(each)).training
    quiet = silent(training)
    heard = {
        output for one in training.experiments for output in one.outputs
        if (one.name, output) not in quiet
    }  # fmt: skip
    lost = [name for name in dict.fromkeys(name for _, name in quiet) if name not in heard]
    kept = [{n: c for n, c in one.columns.items() if n not in lost} for one in made]
    if not lost or not all(kept):
        return made, []
    notes = [f"Nothing that is free moves `{name}`, which is not compared." for name in lost]
    return [replace(one, columns=c) for one, c in zip(made, kept, strict=True)], notes


def _of_systems(each: Sequence[Wish]) -> list[Wish]:
    return [one for one in each if one.name != "delay" and one.name.partition(".")[0] != "offset"]


def check_matching(logs: Sequence[Source], scenarios: Sequence[Model]) -> list[Model]:
    """One scenario for every log.

    Raises:
        DataError: they are neither one nor equally many.
    """
    if len(scenarios) == 1:
        return list(scenarios) * len(logs)
    if len(scenarios) != len(logs):
        raise DataError(
            f"{len(logs)} logs have {len(scenarios)} scenarios; give one for all, or one each."
        )
    return list(scenarios)
