"""Calls about fits: search parameters, and write files of the result."""

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
from martensite.app.messages import JsonTable, Request, require_choice, require_entry
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import DataError, SolveError
from martensite.base.files import write_file
from martensite.fit.fit import Fit
from martensite.fit.fit_task import ArrangedFit
from martensite.fit.material_files import write_material

ENDED = ("reason", "simulations", "jacobians", "seconds", "history")
"""Fields that cannot be recomputed from the fitted values."""


def run_fit(request: Request, desk: Desk) -> JsonTable:
    """Fit parameters of a scenario to a log: long work.

    The request is that of `identify.fit_request`. `state`, the key of an earlier search of the same problem, continues
    it; `finish` only evaluates its result.

    Notes: first {"problem": {parameters, records, state}}, then {"stage", "cost", "values", …}, sometimes with
    "curves". The answer is that of `identify.fit_outcome`, with the key `fit` for the call `fit_files`. After a stop it
    is the best result so far.
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
    import_module("scipy.stats")  # takes a second, too long after a stop request
    if require_entry(request, "finish", bool, False):
        desk.stop.set()
    watching = FitProgress(training, desk.tell, desk.stop)
    fit = search_parameters(arranged, watching, path)
    watching.finish(fit)
    proposal = find_proposal(request, desk)
    entries = [*describe_preparation(request, desk), *(list_assumptions(request, desk) if proposal else ())]
    again = {"prepared": entries, "command": write_command(request, fit, proposal)}
    return {**describe_outcome(fit, proposal), **again, "fit": _keep_fit(request, fit, desk, key)}


def search_parameters(arranged: ArrangedFit, watching: FitProgress, path: Path) -> Fit:
    """Return the fit, stored in a file."""
    try:
        return arranged.solve(watching, path)
    except KeyboardInterrupt:
        raise SolveError("The fit was stopped before its first run had ended.") from None


def _place_state(request: Request, desk: Desk) -> tuple[str, Path]:
    """Return key and file for the state of the search, copied from an earlier search to continue."""
    drawer = desk.files
    key, path = drawer.place("search.json")
    if request.get("state") is not None:
        shutil.copyfile(drawer.path(require_entry(request, "state", str)), path)
    return key, path


def _keep_fit(request: Request, fit: Fit, desk: Desk, state: str) -> str:
    key, path = desk.files.place("fit.json")
    ended = {name: getattr(fit, name) for name in ENDED}
    noted = {"request": {**request, "state": None, "finish": False}, "state": state}
    write_file(path, json.dumps({**noted, "ended": ended}))
    return key


ENDINGS = {"material": "toml", "report": "html", "terminal": "zip"}


def write_fit_file(request: Request, desk: Desk) -> dict[str, str]:
    """Write a file of a finished fit.

    {"key": of the fit, "what": "material"} -> {"key": …, "name": …}

    `material` is a material file (TOML) with values, intervals, and hashes of the data; `report` an HTML page with
    figures; `terminal` a folder to repeat the fit on the command line: records, scenario, command, and preparation
    steps. The fit is recomputed at its values, without a search.
    """
    what = require_choice(request, "what", "file", ENDINGS)
    drawer = desk.files
    stored_fit = _read_kept(drawer, require_entry(request, "key", str))
    fit = _repeat_fit(stored_fit, desk)
    source = fit.problem.experiments[0].record.source
    name = source.stem if source is not None else "fit"
    key, path = drawer.place(f"{name}.{ENDINGS[what]}")
    desk.tell({"stage": "writing"})
    if what == "terminal":
        request = require_entry(stored_fit, "request", dict)
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


def _repeat_fit(stored_fit: Request, desk: Desk) -> Fit:
    request = require_entry(stored_fit, "request", dict)
    arranged = read_task(request, desk).arrange(check=not request.get("proposed"))
    ended = Event()
    ended.set()
    watching = FitProgress(arranged.problem.training, desk.tell, ended)
    state = desk.files.path(require_entry(stored_fit, "state", str))
    parameters = search_parameters(arranged, watching, state)
    table = {name: require_entry(stored_fit, "ended", dict)[name] for name in ENDED}
    history = tuple((int(runs), float(cost)) for runs, cost in table.pop("history"))
    return replace(parameters, **table, history=history)


def _read_kept(drawer: UploadFolder, key: str) -> JsonTable:
    try:
        stored_fit = json.loads(drawer.path(key).read_text(encoding="utf-8"))
        if isinstance(stored_fit, dict) and {"request", "state", "ended"} <= stored_fit.keys():
            return stored_fit
    except ValueError:
        pass
    raise DataError("This file contains no fit.")
