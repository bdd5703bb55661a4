"""Calls about fits: search parameters, and write files of what was found."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from threading import Event

from martensite.app.identify.fit_command import write_command, write_terminal_files
from martensite.app.identify.fit_progress import FitProgress, describe_measured, describe_outcome, describe_parameter
from martensite.app.identify.fit_request import find_proposal, list_assumptions, read_task
from martensite.app.identify.mapped_table import describe_preparation
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import DataError, SolveError
from martensite.base.files import write_file
from martensite.fit.fit import Fit
from martensite.fit.fit_task import ArrangedFit
from martensite.fit.material_files import write_material

ENDED = ("reason", "simulations", "jacobians", "seconds", "history")
"""Fields that cannot be computed again from the fitted values."""


def run_fit(request: Request, desk: Desk) -> JsonTable:
    """Fit parameters of a scenario to a log: long work, which tells how far it is.

    A request is that of `identify.fit_request`; with `state`, the key of an earlier search of the
    same problem, it goes on from there, and with `finish` it only looks at where that was.

    Notes: first {"problem": {parameters, records, state}}, then {"stage", "cost", "values", …}, now
    and then with "curves". The answer is that of `identify.fit_outcome` with the key `fit` for the
    call `fit_files`. Once it shall stop it ends with the best so far.
    """
    arranged = read_task(request, desk).arrange(check=not request.get("proposed"))
    key, path = _place_state(request, desk)
    training = arranged.problem.training
    desk.tell(
        {
            "problem": {
                "parameters": [describe_parameter(free) for free in training.free],
                "records": [describe_measured(one) for one in training.experiments],
                "noisy": sorted(arranged.problem.noise),
                "notes": list(arranged.notes),
                "state": key,
            }
        }
    )
    import_module("scipy.stats")  # takes a second, which there may not be once it shall stop
    if require_entry(request, "finish", bool, False):
        desk.stop.set()
    watching = FitProgress(training, desk.tell, desk.stop)
    fit = search_parameters(arranged, watching, path)
    watching.finish(fit)
    proposal = find_proposal(request, desk)
    said = [*describe_preparation(request, desk), *(list_assumptions(request, desk) if proposal else ())]
    again = {"prepared": said, "command": write_command(request, fit, proposal)}
    return {**describe_outcome(fit, proposal), **again, "fit": _keep_fit(request, fit, desk, key)}


def search_parameters(arranged: ArrangedFit, watching: FitProgress, path: Path) -> Fit:
    """Return the fit, kept in a file.

    Raises:
        SolveError: it was stopped before anything was computed.
    """
    try:
        return arranged.solve(watching, path)
    except KeyboardInterrupt:
        raise SolveError("The fit was stopped before its first run had ended.") from None


def _place_state(request: Request, desk: Desk) -> tuple[str, Path]:
    """Return a file for the state of the search, with that of an earlier one if it is to go on."""
    drawer = UploadFolder(desk.folder)
    key, path = drawer.place("search.json")
    if request.get("state") is not None:
        shutil.copyfile(drawer.path(require_entry(request, "state", str)), path)
    return key, path


def _keep_fit(request: Request, fit: Fit, desk: Desk, state: str) -> str:
    """Return a file from which the call `fit_files` makes others; its key."""
    key, path = UploadFolder(desk.folder).place("fit.json")
    ended = {name: getattr(fit, name) for name in ENDED}
    noted = {"request": {**request, "state": None, "finish": False}, "state": state}
    write_file(path, json.dumps({**noted, "ended": ended}))
    return key


ENDINGS = {"material": "toml", "report": "html", "terminal": "zip"}


def write_fit_file(request: Request, desk: Desk) -> dict[str, str]:
    """Write a file of a finished fit.

    {"key": of the fit, "what": "material"} -> {"key": …, "name": …}

    `material` is a material file (TOML) with numbers, intervals, and hashes of the data; `report` a
    page of HTML with figures; `terminal` what repeats the fit on the command line: records as they were
    fitted, the scenario, the command, and what was done to the logs. The fit is computed again at the numbers
    that were found, without a search.
    """
    what = require_entry(request, "what", str)
    if what not in ENDINGS:
        raise BadMessageError(f"`what` must be one of {', '.join(ENDINGS)}, but is {what!r}.")
    drawer = UploadFolder(desk.folder)
    kept = _read_kept(drawer, require_entry(request, "key", str))
    fit = _repeat_fit(kept, desk)
    source = fit.problem.experiments[0].record.source
    name = source.stem if source is not None else "fit"
    key, path = drawer.place(f"{name}.{ENDINGS[what]}")
    desk.tell({"stage": "writing"})
    if what == "terminal":
        request = require_entry(kept, "request", dict)
        steps = describe_preparation(request, desk)
        write_terminal_files(request, fit, find_proposal(request, desk), steps, path)
    else:
        _write_file(fit, what, path)
    return {"key": key, "name": path.name}


def _write_file(fit: Fit, what: str, path: Path) -> None:
    if what == "material":
        write_material(fit, path, scenario=fit.scenario)
        return
    from martensite.show.pages import write_report

    write_report(fit, path, scenario=fit.scenario)


def _repeat_fit(kept: Request, desk: Desk) -> Fit:
    request = require_entry(kept, "request", dict)
    arranged = read_task(request, desk).arrange(check=not request.get("proposed"))
    ended = Event()
    ended.set()
    watching = FitProgress(arranged.problem.training, desk.tell, ended)
    state = UploadFolder(desk.folder).path(require_entry(kept, "state", str))
    found = search_parameters(arranged, watching, state)
    known = {name: require_entry(kept, "ended", dict)[name] for name in ENDED}
    history = tuple((int(runs), float(cost)) for runs, cost in known.pop("history"))
    return replace(found, **known, history=history)


def _read_kept(drawer: UploadFolder, key: str) -> JsonTable:
    try:
        found = json.loads(drawer.path(key).read_text(encoding="utf-8"))
        if isinstance(found, dict) and {"request", "state", "ended"} <= found.keys():
            return found
    except ValueError:
        pass
    raise DataError("This file contains no fit.")
