"""Fit parameters of a scenario to a log: long work, which tells how far it is.

A request is that of `identify.asked`; with `state`, the key of an earlier search of the same
problem, it goes on from there, and with `finish` it only looks at where that was.

Notes: first {"problem": {parameters, records, state}}, then {"stage", "cost", "values", …}, now
and then with "curves". The answer is that of `identify.outcome` with the key `fit` for the call
`fit_files`. Once it shall stop it ends with the best so far.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from martensite.app.drawer import Drawer
from martensite.app.identify.asked import task_of_request
from martensite.app.identify.outcome import outcome
from martensite.app.identify.watching import Watching, measured, parameter
from martensite.app.messages import wanted
from martensite.app.worker import Desk
from martensite.base.errors import SolveError
from martensite.fit.task import Arranged, LogFit

ENDED = ("reason", "simulations", "jacobians", "seconds", "history")
"""What cannot be computed again from the numbers found."""


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Arrange the fit, search, and describe what was found."""
    arranged = task_of_request(request, desk).arranged()
    key, path = _state(request, desk)
    training = arranged.problem.training
    desk.tell(
        {
            "problem": {
                "parameters": [parameter(free) for free in training.free],
                "records": [measured(one) for one in training.experiments],
                "noisy": sorted(arranged.problem.noise),
                "notes": list(arranged.notes),
                "state": key,
            }
        }
    )
    import_module("scipy.stats")  # takes a second, which there may not be once it shall stop
    if wanted(request, "finish", bool, False):
        desk.stop.set()
    watching = Watching(training, desk.tell, desk.stop)
    fit = searched(arranged, watching, path)
    watching.ended(fit)
    return {**outcome(fit), "fit": _noted(request, fit, desk, key)}


def searched(arranged: Arranged, watching: Watching, path: Path) -> LogFit:
    """The fit, kept in a file.

    Raises:
        SolveError: it was stopped before anything was computed.
    """
    try:
        return arranged.solved(watching, path)
    except KeyboardInterrupt:
        raise SolveError("The fit was stopped before its first run had ended.") from None


def _state(request: Mapping[str, Any], desk: Desk) -> tuple[str, Path]:
    """A file for the state of the search, with that of an earlier one if it is to go on."""
    drawer = Drawer(desk.folder)
    key, path = drawer.place("search.json")
    if request.get("state") is not None:
        shutil.copyfile(drawer.path(wanted(request, "state", str)), path)
    return key, path


def _noted(request: Mapping[str, Any], fit: LogFit, desk: Desk, state: str) -> str:
    """A file from which the call `fit_files` makes others; its key."""
    key, path = Drawer(desk.folder).place("fit.json")
    ended = {name: getattr(fit, name) for name in ENDED}
    noted = {"request": {**request, "state": None, "finish": False}, "state": state}
    path.write_text(json.dumps({**noted, "ended": ended}), encoding="utf-8")
    return key
