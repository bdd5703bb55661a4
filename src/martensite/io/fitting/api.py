"""`read_problem` and `fit`: from scenarios and logs to a problem, and to its solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from martensite.errors import InputError
from martensite.identify.fitting.free import Wish
from martensite.identify.fitting.problem import Problem
from martensite.identify.fitting.watch import Tell
from martensite.io.fitting.hold_out import AUTO
from martensite.io.fitting.task import Log, LogFit, Model, Search, Source, Task, check_matching
from martensite.io.fitting.wishes import split_list
from martensite.io.scenario import Scenario
from martensite.signals.records import Record

Wishes = str | Sequence[str | Wish]


def read_problem(
    scenario: Model | Sequence[Model],
    logs: Source | Sequence[Source],
    free: Wishes,
    *,
    each: Wishes = (),
    hold_out: str | Sequence[str] = AUTO,
    columns: str | Sequence[str] | Mapping[str, str] | None = None,
    noise: Mapping[str, str | float] | None = None,
    step: float | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Problem:
    """What is to be fitted to what, from files.

    Args:
        scenario: one for all logs, or one for each: files, or scenarios.
        logs: files with headings, `data:<data set>/<file>`, or records; missing samples are NaN.
        free: parameters common to all logs: `A_s`, `A_s=40..90 degC`, `A_s=40..90 degC@60 degC`.
        each: what every log has for itself: such parameters, `offset`, `offset.OUTPUT`, `delay`.
        hold_out: what is kept back from the fit: auto, none, names of records, or `25 %`.
        columns: outputs that are compared, `OUTPUT`, `OUTPUT=COLUMN` or `OUTPUT=COLUMN*FACTOR`;
            all that logs and system share if left out, but for what drives.
        noise: output -> standard deviation of its measurement, with unit or in SI.
        step: longest step of all runs [s]; that of the scenario, or one to its tolerance.
        overrides: changes to the scenarios, by dotted path.

    Raises:
        InputError: something is unknown, missing, or does not fit; one sentence says what.
        SolveError: a run at the start values fails.
    """
    task = task_of(
        scenario, logs, free, each=each, hold_out=hold_out, columns=columns, noise=noise,
        step=step, overrides=overrides,
    )  # fmt: skip
    return task.arranged().problem


def fit(
    scenario: Model | Sequence[Model],
    logs: Source | Sequence[Source] | None = None,
    free: Wishes | None = None,
    *,
    each: Wishes = (),
    hold_out: str | Sequence[str] = AUTO,
    columns: str | Sequence[str] | Mapping[str, str] | None = None,
    noise: Mapping[str, str | float] | None = None,
    step: float | None = None,
    overrides: Mapping[str, Any] | None = None,
    method: str = "trf",
    loss: str = "linear",
    starts: int = 0,
    seed: int = 0,
    tell: Tell | None = None,
    state: str | Path | None = None,
) -> LogFit:
    """Fit parameters of scenarios to logs.

    With the path of a fit file as its only argument it does what that says; see
    `martensite.io.fitting.documents`.

    Args:
        scenario: as in `read_problem`, or a fit file.
        logs: as in `read_problem`.
        free: as in `read_problem`.
        each: as in `read_problem`.
        hold_out: as in `read_problem`.
        columns: as in `read_problem`.
        noise: as in `read_problem`.
        step: as in `read_problem`.
        overrides: as in `read_problem`, also for a fit file.
        method: trf, coordinate, or evolution; see `solve`.
        loss: linear, soft-l1, huber, or cauchy.
        starts: further local searches, from the best of many points within the bounds.
        seed: of those points.
        tell: called after every evaluation.
        state: a file in which the search is kept, and taken up again.

    Raises:
        InputError: something is unknown, missing, or does not fit; one sentence says what.
        SolveError: the runs fail at the start, and at every point tried.
    """
    if logs is None or free is None:
        task = _of_file(scenario, overrides or {})
    else:
        task = task_of(
            scenario, logs, free, each=each, hold_out=hold_out, columns=columns, noise=noise,
            step=step, overrides=overrides, search=Search(method, loss, starts, seed),
        )  # fmt: skip
    return task.arranged().solved(tell, None if state is None else Path(state))


def task_of(
    scenario: Model | Sequence[Model],
    logs: Source | Sequence[Source],
    free: Wishes,
    *,
    each: Wishes = (),
    hold_out: str | Sequence[str] = AUTO,
    columns: str | Sequence[str] | Mapping[str, str] | None = None,
    noise: Mapping[str, str | float] | None = None,
    step: float | None = None,
    overrides: Mapping[str, Any] | None = None,
    search: Search | None = None,
) -> Task:
    """The task that the arguments of `fit` describe."""
    sources = [logs] if isinstance(logs, (str, Path, Record)) else list(logs)
    models = [scenario] if isinstance(scenario, (str, Path, Scenario)) else list(scenario)
    pairs = zip(sources, check_matching(sources, models), strict=True)
    return Task(
        tuple(Log(source, model, settings=overrides or {}) for source, model in pairs),
        _wishes(free), _wishes(each), hold_out, columns, noise or {}, step, search or Search(),
    )  # fmt: skip


def _wishes(given: Wishes) -> list[str | Wish]:
    """Free parameters; a text may list several with commas."""
    if isinstance(given, str):
        return list(split_list(given))
    return [one for x in given for one in (split_list(x) if isinstance(x, str) else [x])]


def _of_file(path: Model | Sequence[Model], overrides: Mapping[str, Any]) -> Task:
    from martensite.io.fitting.documents import read_fit_file

    if not isinstance(path, (str, Path)):
        raise InputError("A fit needs `logs` and `free`; only a fit file stands alone.")
    task = read_fit_file(path)
    logs = (replace(one, settings={**one.settings, **overrides}) for one in task.logs)
    return replace(task, logs=tuple(logs))
