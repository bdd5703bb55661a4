"""Calls about sweeps: plan, time, run, read and delete."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from martensite.app.documents import build_packaged, read_request_scenario
from martensite.app.messages import JsonTable, Request, require_entry
from martensite.app.sweeping.sweep_drawing import SweepDrawing, SweepProgress, name_statuses
from martensite.app.sweeping.sweep_folder import SweepFolder, find_store, hold_store, make_slug, summarise_store
from martensite.app.sweeping.sweep_request import (
    check_request,
    choose_chunk,
    read_texts,
    read_wanted,
    read_workers,
    require_size,
    time_block,
    write_command,
)
from martensite.app.worker import Desk
from martensite.base.errors import DataError, StoppedError
from martensite.design.sweep.api import begin_sweep
from martensite.design.sweep.backends.processes import count_cores
from martensite.design.sweep.indices import compute_sensitivity
from martensite.design.sweep.job import SweepRequest, build_plan, prepare_plan
from martensite.design.sweep.pareto import find_pareto_front
from martensite.design.sweep.reading import count_statuses, read_sweep
from martensite.design.sweep.store import Store
from martensite.scenario.exact_text import exact_text
from martensite.scenario.scenario import Scenario


def list_sweeps(request: Request, desk: Desk) -> JsonTable:
    """Return the sweeps in the folder, the newest first: `{}` -> `{"sweeps": [{key, title, …}]}`."""
    shelf = SweepFolder(desk.folder)
    return {"sweeps": [summarise_store(key, path) for key, path in shelf.all().items()]}


def plan_sweep(request: Request, desk: Desk) -> JsonTable:
    """Return the number of runs of a sweep, or the errors by field.

    Request of the job `sweep` -> {"faults": {field: sentence}, "runs": …, "command": …, …}
    """
    scenario = read_request_scenario(request, desk)
    plan, faults = check_request(scenario, request)
    if plan is None:
        return {"faults": faults, "runs": None, "command": "", "cautions": []}
    workers, step = read_workers(request).workers, str(request.get("step") or "")
    words = write_command(make_slug(scenario.title), read_wanted(request), workers, step)
    return {
        "faults": faults,
        "runs": plan.size,
        "command": words,
        "cautions": plan.cautions(),
        "runtime": plan.course.runtime,
    }


def estimate_time(request: Request, desk: Desk) -> JsonTable:
    """Estimate the duration of a sweep from one block of its runs.

    Request of the job `sweep` -> {"seconds": …, "tried": runs of the block, "took": its time, …}
    """
    plan, sweep_request = prepare_plan(read_request_scenario(request, desk), read_wanted(request))
    one = time_block(require_size(plan))
    workers = read_workers(request).workers or count_cores()
    return {
        "seconds": one.total(plan.size, workers),
        "tried": one.runs,
        "took": one.seconds,
        "workers": workers,
        "step": sweep_request.step,
        "runtime": sweep_request.runtime,
    }


NAMED = 5
"""Number of failed runs that are named."""


def run_sweep(request: Request, desk: Desk) -> JsonTable:
    """Run variants of a scenario into a store, or continue a store (a job).

    {"text": TOML, "over": […], "sample": …, "measures": […], "seed", "step", "runtime", "workers"} or {"resume": key,
    "workers": 0}
    -> {"key": key, "stopped": "a sentence, if it was cancelled", "done": …, "runs": …, …}

    Notes have a number, the state, and the new runs (`sweeping.sweep_progress`). After a cancellation finished runs are
    kept.
    """
    desk.tell({"phase": "preparing", "number": 0})
    key, path, scenario, sweep_request = _find_store(request, desk)
    if desk.stop.is_set():
        return {"key": None, "stopped": "Cancelled before the first run."}
    sweep = begin_sweep(scenario, sweep_request, path, read_workers(request))
    live = SweepProgress(sweep, key, desk)
    began = time.monotonic()
    with hold_store(path), _catch_stop(desk) as sentences:
        live.run()
    return {
        "key": key,
        "stopped": sentences[0] if sentences else "",
        "seconds": time.monotonic() - began,
        "cautions": sweep.plan.cautions(),
        **_count_ended(sweep.store),
    }


def _find_store(request: Request, desk: Desk) -> tuple[str, Path, Scenario, SweepRequest]:
    shelf, key = SweepFolder(desk.folder), require_entry(request, "resume", str, "")
    if key:
        path = shelf.path(key)
        with hold_store(path):
            spec = Store(path).spec
        return key, path, build_packaged(spec["scenario"]), SweepRequest.of_spec(spec)
    scenario, sweep_request = read_request_scenario(request, desk), read_wanted(request)
    read_workers(request)
    plan, sweep_request = prepare_plan(scenario, sweep_request)
    sweep_request = replace(sweep_request, chunk=choose_chunk(require_size(plan)))
    return *shelf.new(scenario.title), scenario, sweep_request


@contextmanager
def _catch_stop(desk: Desk) -> Iterator[list[str]]:
    """Catch the error of a cancelled sweep and yield its sentence; other errors pass."""
    entries: list[str] = []
    try:
        yield entries
    except StoppedError as error:
        if not desk.stop.is_set():
            raise
        entries.append(str(error))


def _count_ended(store: Store) -> JsonTable:
    counts, rows = count_statuses(store, NAMED)
    return {
        "done": sum(counts.values()),
        "runs": int(store.group["status"].shape[0]),
        "counts": name_statuses(counts),
        "failed": [[int(status), counts[status], first] for status, first in sorted(rows.items())],
    }


def read_points(request: Request, desk: Desk) -> JsonTable:
    """Return the drawn data of a sweep so far.

    {"key": …}
    -> {"layout": {…}, "points": {"rows", "status", "columns"}, "done", "runs", "state", …}
    """
    key = require_entry(request, "key", str)
    path = SweepFolder(desk.folder).path(key)
    drawing = SweepDrawing(Store(path))
    drawing.store.require_sound()
    sweep_request = SweepRequest.of_spec(drawing.spec)
    step = f"{sweep_request.step!r} s" if sweep_request.step is not None else ""
    return {
        **_count_ended(drawing.store),
        **summarise_store(key, path),
        "layout": drawing.layout(),
        "points": drawing.points(drawing.store.list_finished_chunks()),
        "command": write_command(make_slug(drawing.spec["title"]), sweep_request, step=step),
    }


def read_row(request: Request, desk: Desk) -> JsonTable:
    """Return the scenario of one run of a sweep, with exact values.

    {"key": …, "row": 12} -> {"text": TOML, "values": [SI], "status": …}
    """
    spec = Store(find_store(request, desk.folder)).spec
    row = require_entry(request, "row", int)
    plan = build_plan(build_packaged(spec["scenario"]), SweepRequest.of_spec(spec))
    if not 0 <= row < plan.size:
        raise DataError(f"There is no run {row} in this sweep of {plan.size:,} runs.")
    values = plan.values(range(row, row + 1))[0].tolist()
    changes = {
        one.target.name: exact_text(value, one.target.unit) for one, value in zip(plan.axes, values, strict=True)
    }
    scenario = build_packaged(spec["scenario"], changes)
    return {"text": scenario.text, "values": values, "changes": changes}


MOST_LISTED = 2000
"""Largest number of listed runs of a front."""
NO_FRONT: Request = {"rows": [], "values": {}, "count": 0, "compared": 0, "left_out": []}


def find_front(request: Request, desk: Desk) -> JsonTable:
    """Return the Pareto front of a sweep so far.

    {"key": …, "minimise": ["energy"], "maximise": ["stroke"]}
    -> {"rows": […], "values": {name: [SI]}, "compared": …, "left_out": [[number, "why"]], "why": …}
    """
    table = read_sweep(find_store(request, desk.folder))
    try:
        front = find_pareto_front(table, read_texts(request, "minimise", []), read_texts(request, "maximise", []))
    except DataError as error:  # as long as no run is there
        return {**NO_FRONT, "why": str(error)}
    never = len(table.status) - table.missing - table.failed - front.compared
    counts = ((table.missing, "not made yet"), (table.failed, "failed"), (never, "what is wanted never happened"))
    runs = front.runs[:: max(-(-len(front.runs) // MOST_LISTED), 1)]
    return {
        "rows": runs.tolist(),
        "values": {name: one.values[runs].tolist() for name, one in front.columns(table).items()},
        "count": len(front.runs),
        "compared": front.compared,
        "left_out": [[count, why] for count, why in counts if count],
        "why": "",
    }


def estimate_indices(request: Request, desk: Desk) -> JsonTable:
    """Return the fraction of a measure's variance by varied parameter.

    {"key": …, "measure": "stroke"}
    -> {"method", "used", "names": […], "indices": {kind: {"values": […], "wide": […]}}, "remarks"}
    """
    table = read_sweep(find_store(request, desk.folder))
    (sensitivity,) = compute_sensitivity(table, [require_entry(request, "measure", str)])
    kinds = sensitivity.indices if sensitivity.deviation else {}
    return {
        "measure": sensitivity.measure,
        "method": sensitivity.method,
        "used": sensitivity.used,
        "names": [sensitivity.names[k] for k in sensitivity.order],
        "indices": {
            kind: {"values": one.values[sensitivity.order], "wide": one.wide[sensitivity.order]}
            for kind, one in kinds.items()
        },
        "remarks": sensitivity.remarks,
    }


def delete_sweep(request: Request, desk: Desk) -> JsonTable:
    """Delete a sweep that is not running: `{"key": …}` -> `{}`."""
    SweepFolder(desk.folder).delete(require_entry(request, "key", str))
    return {}
