"""Run many variants of a scenario into a store of the server's folder, or go on with one (a job).

{"text": TOML, "over": […], "sample": …, "measures": […], "seed", "step", "runtime", "workers"}
or {"resume": key, "workers": 0}
-> {"key": key, "stopped": "a sentence, if it was cancelled", "done": …, "runs": …, …}

Notes have a number, the state, and the runs made since the last one (`sweeping.live`). Cancelled,
it keeps what was made.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from martensite.app.documents import scenario_of
from martensite.app.messages import wanted
from martensite.app.sweeping.asked import how_of, sized, wanted_of
from martensite.app.sweeping.live import Live, named
from martensite.app.sweeping.shelf import Shelf, busy
from martensite.app.sweeping.stored import asked_of, scenario_in
from martensite.app.sweeping.timing import chunk_for
from martensite.app.worker import Desk
from martensite.design.backends.base import StoppedError
from martensite.design.sweep.api import begin
from martensite.design.sweep.extras import extra
from martensite.design.sweep.job import Wanted, prepared
from martensite.design.sweep.store import Store
from martensite.design.sweep.summary import statuses
from martensite.scenario.scenario import Scenario

NAMED = 5
"""Failed runs that are named."""


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Begin or go on, and run to the end or until it is stopped."""
    extra("zarr")
    desk.tell({"phase": "preparing", "number": 0})
    key, path, scenario, asked = _where(request, desk)
    if desk.stop.is_set():
        return {"key": None, "stopped": "Cancelled before the first run; nothing was made."}
    begun = begin(scenario, asked, path, how_of(request))
    live = Live(begun, key, desk)
    began = time.monotonic()
    with busy(path), _stopping(desk) as said:
        live.run()
    return {
        "key": key,
        "stopped": said[0] if said else "",
        "seconds": time.monotonic() - began,
        "cautions": begun.plan.cautions(),
        **_ended(begun.store),
    }


def _where(request: Mapping[str, Any], desk: Desk) -> tuple[str, Path, Scenario, Wanted]:
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
def _stopping(desk: Desk) -> Iterator[list[str]]:
    """Takes the sentence of a sweep that was cancelled; other reasons to stop are passed on."""
    said: list[str] = []
    try:
        yield said
    except StoppedError as error:
        if not desk.stop.is_set():
            raise
        said.append(str(error))


def _ended(store: Store) -> dict[str, Any]:
    """How many runs are there, and how they ended."""
    counts, rows = statuses(store, NAMED)
    return {
        "done": sum(counts.values()),
        "runs": int(store.group["status"].shape[0]),
        "counts": named(counts),
        "failed": [[int(status), counts[status], first] for status, first in sorted(rows.items())],
    }
