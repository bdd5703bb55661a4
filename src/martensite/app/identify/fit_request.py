"""From the request for a fit to its task: the records, the scenario, what is free, how to search.

"text": TOML, and the table as `identify.mapped_table` takes it
"free": [{"name": "A_s", "low": 313.0, "high": 363.0, "start": 340.0}]    SI; all but the name
"each": [{"name": "offset.strain"}, {"name": "delay"}]                    may be left out
"compare": ["strain"], "hold_out": "auto" (or names), "method": "trf", "loss": "linear",
"proposed": "lagoudas"    a scenario that was proposed for the logs: their rows are those that it explains
"starts": 0, "seed": 0, "noise": {"strain": 2e-4}, "step": null
"""

from __future__ import annotations

from typing import Any, cast

from martensite.app.documents import build_packaged, check_files
from martensite.app.identify.log_kinds import propose_models
from martensite.app.identify.mapped_table import read_records
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.worker import Desk
from martensite.base.errors import DataError, InputError, ParameterError
from martensite.fit.experiment_kinds.base import Proposal
from martensite.fit.fit_task import FitSearch, FitTask
from martensite.fit.logs import AUTO, Log
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record

MOST_STARTS = 64
MOST_ROWS = 50_000
"""Rows of a record: each is a step of every run where the scenario follows it."""


def build_scenario(request: Request, record: Record) -> Scenario:
    """Return the scenario of a request, with a record that it may follow.

    Raises:
        InputError: the scenario is invalid, or follows a column that the record lacks.
    """
    text = require_entry(request, "text", str)
    check_files(text, {})
    return build_packaged(text, log=record)


def read_task(request: Request, desk: Desk) -> FitTask:
    """Return the task of a request.

    Raises:
        InputError: an entry is invalid or does not fit.
    """
    proposal = find_proposal(request, desk)
    records = list(proposal.rows) if proposal else read_records(request, desk)
    long = next((one for one in records if len(one) > MOST_ROWS), None)
    if long is not None:
        raise DataError(f"Record `{long.name}` has {len(long):,} rows; thin it out to at most {MOST_ROWS:,}.")
    logs = tuple(Log(one, build_scenario(request, one), name=one.name) for one in records)
    free = read_ranges(request, "free")
    if not free:
        raise ParameterError("Nothing is free; choose at least one parameter to be found.")
    compared = [str(name) for name in require_entry(request, "compare", list, [])]
    return FitTask(
        logs=logs,
        free=free,
        each=_list_each(request, proposal),
        hold_out=_read_hold_out(request),
        columns=compared or (list(proposal.columns) if proposal else None),
        noise=_read_noise(request),
        step=None if request.get("step") is None else require_entry(request, "step", float),
        search=_read_search(request),
    )


def find_proposal(request: Request, desk: Desk) -> Proposal | None:
    """Return the proposal that a request goes by, for its logs as they are now.

    Raises:
        DataError: nothing is proposed by that name.
    """
    name = require_entry(request, "proposed", str, "")
    return propose_models(read_records(request, desk), {}).find(name) if name else None


def list_assumptions(request: Request, desk: Desk) -> list[str]:
    """Return the assumptions of the scenario that is proposed for a request."""
    return list(propose_models(read_records(request, desk), {}).notes)


def list_rows(request: Request, desk: Desk) -> list[Record]:
    """Return the records that a scenario is to explain: those of a proposal, or those of the logs."""
    proposal = find_proposal(request, desk)
    return list(proposal.rows) if proposal else read_records(request, desk)


def _list_each(request: Request, proposal: Proposal | None) -> list[str | SearchRange]:
    """Return the parameters of single records, with the bounds of the proposal if it has them."""
    known = {text.partition("=")[0].strip(): text for text in proposal.each} if proposal else {}
    return [known.get(one.name, one) for one in read_ranges(request, "each")]


def read_ranges(request: Request, name: str) -> list[SearchRange]:
    """Return the free parameters of an entry of a request.

    Raises:
        BadMessageError: the entry holds something else.
    """
    found: list[SearchRange] = []
    for entry in require_entry(request, name, list, []):
        if not isinstance(entry, dict):
            raise BadMessageError(f"`{name}` must hold tables with a `name`.")
        table = cast("JsonTable", entry)
        low, high, start = (_read_number(table, key) for key in ("low", "high", "start"))
        scale = None if table.get("scale") is None else require_entry(table, "scale", str)
        found.append(SearchRange(require_entry(table, "name", str), low, high, start, scale))
    return found


def _read_number(table: Request, key: str) -> float | None:
    return None if table.get(key) is None else require_entry(table, key, float)


def _read_hold_out(request: Request) -> str | list[str]:
    given = request.get("hold_out", AUTO)
    if isinstance(given, list):
        return [str(name) for name in cast("list[Any]", given)]
    return require_entry(request, "hold_out", str, AUTO)


def _read_noise(request: Request) -> dict[str, float]:
    given = require_entry(request, "noise", dict, {})
    return {str(name): require_entry(given, name, float) for name in given}


def _read_search(request: Request) -> FitSearch:
    usual = FitSearch()
    starts = require_entry(request, "starts", int, usual.starts)
    if not 0 <= starts <= MOST_STARTS:
        raise InputError(f"Further starts must be 0 to {MOST_STARTS}, but are {starts}.")
    return FitSearch(
        require_entry(request, "method", str, usual.method),
        require_entry(request, "loss", str, usual.loss),
        starts,
        require_entry(request, "seed", int, usual.seed),
    )
