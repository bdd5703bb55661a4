"""Build fit problems from scenarios and logs, and solve them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from martensite.base.errors import InputError
from martensite.fit.fit import Fit
from martensite.fit.fit_file import read_fit_file
from martensite.fit.fit_task import Columns, FitTask
from martensite.fit.free_parameters import split_list
from martensite.fit.logs import Log, Model, Source, check_matching
from martensite.fit.problem import Problem
from martensite.fit.search_monitor import Tell
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record

Ranges = str | Sequence[str | SearchRange]


def read_problem(
    scenario: Model | Sequence[Model],
    logs: Source | Sequence[Source],
    free: Ranges,
    *,
    each: Ranges = (),
    hold_out: str | Sequence[str] | None = None,
    columns: Columns | None = None,
    noise: Mapping[str, str | float] | None = None,
    step: float | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Problem:
    """Return the fit problem of scenarios and logs, from files.

    Args:
        scenario: one scenario or file for all logs, or one for each log.
        logs: files with headings, `data:<data set>/<file>`, or records; missing samples are NaN.
        free: parameters common to all logs: `A_s`, `A_s=40..90 degC`, `A_s=40..90 degC@60 degC`.
        each: separate parameters of each log: as in `free`, and `offset`, `offset.OUTPUT`, `delay`.
        hold_out: held-out data: auto (default), none, names of records, or `25 %`.
        columns: compared outputs: `OUTPUT`, `OUTPUT=COLUMN` or `OUTPUT=COLUMN*FACTOR`. The default is all outputs that
            logs and system have in common, without the drives.
        noise: output -> standard deviation of its measurement, with unit or in SI.
        step: longest step of all runs [s], by default the step of the scenario, or a step chosen by the tolerance.
        overrides: changes to the scenarios, by dotted path.

    Raises:
        InputError: an entry is unknown, missing, or inconsistent.
        SolveError: a run at the start values fails.
    """
    task = build_task(scenario, logs, free).with_changes(
        each=_list_ranges(each), hold_out=hold_out, columns=columns, noise=noise, step=step, settings=overrides
    )
    return task.arrange().problem


def fit_logs(
    scenario: Model | Sequence[Model],
    logs: Source | Sequence[Source] | None = None,
    free: Ranges | None = None,
    *,
    each: Ranges = (),
    hold_out: str | Sequence[str] | None = None,
    columns: Columns | None = None,
    noise: Mapping[str, str | float] | None = None,
    step: float | None = None,
    overrides: Mapping[str, Any] | None = None,
    method: str | None = None,
    loss: str | None = None,
    starts: int | None = None,
    seed: int | None = None,
    tell: Tell | None = None,
    state: str | Path | None = None,
) -> Fit:
    """Fit parameters of scenarios to logs.

    A fit file as `scenario` replaces `logs` and `free`; other arguments override its entries
    (`martensite.fit.fit_file`).

    Args:
        scenario: as in `read_problem`, or a fit file.
        logs: as in `read_problem`.
        free: as in `read_problem`.
        each: as in `read_problem`.
        hold_out: as in `read_problem`.
        columns: as in `read_problem`.
        noise: as in `read_problem`.
        step: as in `read_problem`.
        overrides: as in `read_problem`.
        method: trf (default), coordinate, or evolution; see `solve`.
        loss: linear (default), soft-l1, huber, or cauchy.
        starts: number of further local searches, from the best of many points within the bounds.
        seed: seed of these points.
        tell: callback after every evaluation.
        state: file that stores the search, so that it can be resumed.

    Raises:
        InputError: an entry is unknown, missing, or inconsistent.
        SolveError: the runs fail at the start and at all points tried.
    """
    task = _read_task(scenario) if logs is None or free is None else build_task(scenario, logs, free)
    task = task.with_changes(
        each=_list_ranges(each),
        hold_out=hold_out,
        columns=columns,
        noise=noise,
        step=step,
        settings=overrides,
        search={"method": method, "loss": loss, "starts": starts, "seed": seed},
    )
    return task.arrange().choose_drift().solve(tell, None if state is None else Path(state))


def build_task(scenario: Model | Sequence[Model], logs: Source | Sequence[Source], free: Ranges) -> FitTask:
    """Return the task of logs, one scenario or one for each log, and free parameters.

    Raises:
        DataError: the number of scenarios is neither 1 nor the number of logs.
    """
    sources = [logs] if isinstance(logs, (str, Path, Record)) else list(logs)
    models = [scenario] if isinstance(scenario, (str, Path, Scenario)) else list(scenario)
    pairs = zip(sources, check_matching(sources, models), strict=True)
    return FitTask(tuple(Log(source, model) for source, model in pairs), _list_ranges(free))


def _list_ranges(given: Ranges) -> list[str | SearchRange]:
    if isinstance(given, str):
        return list(split_list(given))
    return [one for x in given for one in (split_list(x) if isinstance(x, str) else [x])]


def _read_task(path: Model | Sequence[Model]) -> FitTask:
    if not isinstance(path, (str, Path)):
        raise InputError("A fit needs `logs` and `free`; only a fit file stands alone.")
    return read_fit_file(path)
