"""Call of a model that the page runs by hand: its data and module."""

from __future__ import annotations

from martensite.app.documents import read_request_scenario
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.static_site.run_module import can_step
from martensite.app.static_site.stepped_model import describe_stepped
from martensite.app.worker import Desk
from martensite.base.errors import InputError


def build_model(request: Request, desk: Desk) -> JsonTable:
    """Return a scenario for the static page, with the WebAssembly of its runs.

    {"text": TOML, "changes": {…}, "paths": ["mechanism.mass"]} -> {"scenario": {…}, "module": base 64}

    Parameters at `paths` can change while the model runs. With `"ready": true` the answer is a run of the page: any
    scenario whose module needs no compilation.
    """
    paths = require_entry(request, "paths", list)
    if not all(isinstance(path, str) for path in paths):
        raise BadMessageError("`paths` must be names of parameters.")
    scenario = read_request_scenario(request, desk)
    ready = require_entry(request, "ready", bool, False)
    if not can_step(scenario):
        raise InputError("This scenario sets its initial state, so it cannot run by hand.")
    return describe_stepped(scenario.text, tuple(paths), ready)
