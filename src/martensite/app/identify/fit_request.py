"""The task of a fit request: records, scenario, free parameters, search.

"text": TOML, and the table of `identify.mapped_table`
"free": [{"name": "A_s", "low": 313.0, "high": 363.0, "start": 340.0}]    SI; all but the name
"each": [{"name": "offset.strain"}, {"name": "delay"}]                    can be omitted
"compare": ["strain"], "hold_out": "auto" (or names), "method": "trf", "loss": "linear",
"proposed": "lagoudas"    a proposed scenario, which is fitted to its own rows
"starts": 0, "seed": 0, "noise": {"strain": 2e-4}, "step": null
"""

from __future__ import annotations

from typing import Any, cast

from martensite.app.documents import build_packaged, check_files
from martensite.app.identify.log_kinds import propose_models
from martensite.app.identify.mapped_table import read_records
from martensite.app.messages import Request, list_tables, read_optional, require_entry
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
"""Largest number of rows of a record; each can be a step of each run."""


def build_scenario(request: Request, record: Record) -> Scenario:
    """Return the scenario of a request, with a record that it can follow."""
    text = require_entry(request, "text", str)
    check_files(text, {})
    return build_packaged(text, log=record)


def read_task(request: Request, desk: Desk) -> FitTask:
    """Return the task of a request."""
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
        step=read_optional(request, "step", float),
        search=_read_search(request),
    )


def find_proposal(request: Request, desk: Desk) -> Proposal | None:
    """Return the proposal of a request for its present logs, or None."""
    name = require_entry(request, "proposed", str, "")
    return propose_models(read_records(request, desk), {}).find(name) if name else None


def list_assumptions(request: Request, desk: Desk) -> list[str]:
    """Return the assumptions of the proposed scenarios of a request."""
    return list(propose_models(read_records(request, desk), {}).notes)


def list_rows(request: Request, desk: Desk) -> list[Record]:
    """Return the rows to fit: those of a proposal, or the logs."""
    proposal = find_proposal(request, desk)
    return list(proposal.rows) if proposal else read_records(request, desk)


def _list_each(request: Request, proposal: Proposal | None) -> list[str | SearchRange]:
    """Return the parameters of single records, with bounds of the proposal."""
    proposed = {text.partition("=")[0].strip(): text for text in proposal.each} if proposal else {}
    return [proposed.get(one.name, one) for one in read_ranges(request, "each")]


def read_ranges(request: Request, name: str) -> list[SearchRange]:
    """Return the free parameters of an entry of a request."""
    entries: list[SearchRange] = []
    for table in list_tables(request, name):
        low, high, start = (read_optional(table, key, float) for key in ("low", "high", "start"))
        scale = read_optional(table, "scale", str)
        entries.append(SearchRange(require_entry(table, "name", str), low, high, start, scale))
    return entries


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
