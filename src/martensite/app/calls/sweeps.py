"""Calls about sweeps: plan, time and run one; read, delete what is stored."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from martensite.app.documents import scenario_of
from martensite.app.gallery import built
from martensite.app.messages import BadMessageError, wanted
from martensite.app.sweeping.asked import checked, how_of, sized, wanted_of
from martensite.app.sweeping.drawn import Drawn
from martensite.app.sweeping.live import Live, named
from martensite.app.sweeping.shelf import Shelf, busy, slug
from martensite.app.sweeping.stored import asked_of, scenario_in, summary
from martensite.app.sweeping.timing import chunk_for, timed
from martensite.app.sweeping.words import command
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.design.backends.base import StoppedError
from martensite.design.backends.processes import cores
from martensite.design.sweep.api import begin
from martensite.design.sweep.extras import extra
from martensite.design.sweep.indices import sensitivity
from martensite.design.sweep.job import Wanted, plan_of, prepared
from martensite.design.sweep.pareto import pareto_front
from martensite.design.sweep.reading import read_sweep
from martensite.design.sweep.store import Store
from martensite.design.sweep.summary import statuses
from martensite.scenario.exact_text import exact_text
from martensite.scenario.scenario import Scenario


def list_sweeps(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """The sweeps in the folder, the newest first: `{}` -> `{"sweeps": [{key, title, …}]}`."""
    shelf = Shelf(desk.folder)
    return {"sweeps": [summary(key, path) for key, path in shelf.all().items()]}


def plan_sweep(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Check what is asked of a sweep: how many runs it has, or what is wrong with each field.

    Request as of the job `sweep` -> {"faults": {field: sentence}, "runs": …, "command": …, …}
    """
    scenario = scenario_of(request, desk)
    plan, faults = checked(scenario, request)
    if plan is None:
        return {"faults": faults, "runs": None, "command": "", "cautions": []}
    workers, step = how_of(request).workers, str(request.get("step") or "")
    words = command(slug(scenario.title), wanted_of(request), workers, step)
    return {
        "faults": faults,
        "runs": plan.size,
        "command": words,
        "cautions": plan.cautions(),
        "runtime": plan.course.runtime,
    }


def estimate_time(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Estimate how long a sweep will take, from one block of its runs.

    Request as of the job `sweep` -> {"seconds": …, "tried": runs of the block, "took": its time, …}
    """
    plan, asked = prepared(scenario_of(request, desk), wanted_of(request))
    one = timed(sized(plan))
    workers = how_of(request).workers or cores()
    return {
        "seconds": one.total(plan.size, workers),
        "tried": one.runs,
        "took": one.seconds,
        "workers": workers,
        "step": asked.step,
        "runtime": asked.runtime,
    }


NAMED = 5
"""Failed runs that are named."""


def run_sweep(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Run many variants of a scenario into a store of the folder, or go on with one (a job).

    {"text": TOML, "over": […], "sample": …, "measures": […], "seed", "step", "runtime", "workers"}
    or {"resume": key, "workers": 0}
    -> {"key": key, "stopped": "a sentence, if it was cancelled", "done": …, "runs": …, …}

    Notes have a number, the state, and the runs made since the last one (`sweeping.live`).
    Cancelled, it keeps what was made.
    """
    extra("zarr")
    desk.tell({"phase": "preparing", "number": 0})
    key, path, scenario, asked = _find_store(request, desk)
    if desk.stop.is_set():
        return {"key": None, "stopped": "Cancelled before the first run; nothing was made."}
    begun = begin(scenario, asked, path, how_of(request))
    live = Live(begun, key, desk)
    began = time.monotonic()
    with busy(path), _catch_stop(desk) as said:
        live.run()
    return {
        "key": key,
        "stopped": said[0] if said else "",
        "seconds": time.monotonic() - began,
        "cautions": begun.plan.cautions(),
        **_count_ended(begun.store),
    }


def _find_store(request: Mapping[str, Any], desk: Desk) -> tuple[str, Path, Scenario, Wanted]:
    """Key and store, and what is asked for: anew, or as a store has it."""
    shelf, key = Shelf(desk.folder), wanted(request, "resume", str, "")
    if key:
        path = shelf.path(key)
        with busy(path):
            spec = Store(path).spec
        return key, path, scenario_in(spec), asked_of(spec)
    scenario, asked = scenario_of(request, desk), wanted_of(request)
    how_of(request)
    plan, asked = prepared(scenario, asked)
    asked = replace(asked, chunk=chunk_for(sized(plan)))
    return *shelf.new(scenario.title), scenario, asked


@contextmanager
def _catch_stop(desk: Desk) -> Iterator[list[str]]:
    """Takes the sentence of a sweep that was cancelled; other reasons to stop are passed on."""
    said: list[str] = []
    try:
        yield said
    except StoppedError as error:
        if not desk.stop.is_set():
            raise
        said.append(str(error))


def _count_ended(store: Store) -> dict[str, Any]:
    """How many runs are there, and how they ended."""
    counts, rows = statuses(store, NAMED)
    return {
        "done": sum(counts.values()),
        "runs": int(store.group["status"].shape[0]),
        "counts": named(counts),
        "failed": [[int(status), counts[status], first] for status, first in sorted(rows.items())],
    }


NAMED = 5


def read_points(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """All that is drawn of a sweep, as far as it is made.

    {"key": …}
    -> {"layout": {…}, "points": {"rows", "status", "columns"}, "done", "runs", "state", …}
    """
    key = wanted(request, "key", str)
    path = Shelf(desk.folder).path(key)
    drawn = Drawn(Store(path))
    counts, rows = statuses(drawn.store, NAMED)
    asked = asked_of(drawn.spec)
    step = f"{asked.step!r} s" if asked.step else ""
    return {
        **summary(key, path),
        "layout": drawn.layout(),
        "points": drawn.points(drawn.store.made()),
        "counts": named(counts),
        "failed": [[int(status), counts[status], first] for status, first in sorted(rows.items())],
        "command": command(slug(drawn.spec["title"]), asked, step=step),
    }


def read_row(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """The scenario of one run of a sweep, with exactly its numbers.

    {"key": …, "row": 12} -> {"text": TOML, "values": [SI], "status": …}
    """
    spec = Store(Shelf(desk.folder).path(wanted(request, "key", str))).spec
    row = wanted(request, "row", int)
    plan = plan_of(scenario_in(spec), asked_of(spec))
    if not 0 <= row < plan.size:
        raise DataError(f"There is no run {row} in this sweep of {plan.size:,} runs.")
    values = plan.values(range(row, row + 1))[0].tolist()
    changes = {
        one.target.name: exact_text(value, one.target.unit)
        for one, value in zip(plan.axes, values, strict=True)
    }
    scenario = built(spec["scenario"], changes)
    return {"text": scenario.text, "values": values, "changes": changes}


MOST_LISTED = 2000
"""Runs of a front that are listed."""
NO_FRONT: Mapping[str, Any] = {"rows": [], "values": {}, "count": 0, "compared": 0, "left_out": []}


def find_front(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """The runs of a sweep that no other beats, as far as it is made.

    {"key": …, "minimise": ["energy"], "maximise": ["stroke"]}
    -> {"rows": […], "values": {name: [SI]}, "compared": …, "left_out": [[number, "why"]], "why": …}
    """
    table = read_sweep(Shelf(desk.folder).path(wanted(request, "key", str)))
    try:
        front = pareto_front(
            table, _read_names(request, "minimise"), _read_names(request, "maximise")
        )
    except DataError as error:  # as long as no run is there
        return {**NO_FRONT, "why": str(error)}
    never = len(table.status) - table.missing - table.failed - front.compared
    counts = (
        (table.missing, "not made yet"),
        (table.failed, "failed"),
        (never, "what is wanted never happened"),
    )
    runs = front.runs[:: max(-(-len(front.runs) // MOST_LISTED), 1)]
    return {
        "rows": runs.tolist(),
        "values": {name: one.values[runs].tolist() for name, one in front.columns(table).items()},
        "count": len(front.runs),
        "compared": front.compared,
        "left_out": [[count, why] for count, why in counts if count],
        "why": "",
    }


def _read_names(request: Mapping[str, Any], name: str) -> list[str]:
    given = wanted(request, name, list, [])
    if not all(isinstance(one, str) for one in given):
        raise BadMessageError(f"`{name}` must be a list of texts.")
    return given


def estimate_indices(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """How much of the variance of a measure every varied number explains.

    {"key": …, "measure": "stroke"}
    -> {"method", "used", "names": […], "indices": {kind: {"values": […], "wide": […]}}, "remarks"}
    """
    table = read_sweep(Shelf(desk.folder).path(wanted(request, "key", str)))
    (found,) = sensitivity(table, [wanted(request, "measure", str)])
    kinds = found.indices if found.deviation else {}
    return {
        "measure": found.measure,
        "method": found.method,
        "used": found.used,
        "names": [found.names[k] for k in found.order],
        "indices": {
            kind: {"values": one.values[found.order], "wide": one.wide[found.order]}
            for kind, one in kinds.items()
        },
        "remarks": found.remarks,
    }


def delete_sweep(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Delete a sweep: `{"key": …}` -> `{}`. One that is running is refused."""
    Shelf(desk.folder).delete(wanted(request, "key", str))
    return {}
