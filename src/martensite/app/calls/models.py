"""Call of a model that the page runs by hand: its data and module."""

from __future__ import annotations

from martensite.app.documents import read_request_scenario
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.static_site.stepped_model import describe_stepped
from martensite.app.worker import Desk
from martensite.base.errors import InputError


def build_model(request: Request, desk: Desk) -> JsonTable:
    """Return a scenario for the static page, with the WebAssembly of its runs.

    {"text": TOML, "changes": {…}, "paths": ["mechanism.mass"]} -> {"scenario": {…}, "module": base 64}

    Parameters at `paths` can change while the model runs.
    """
    paths = require_entry(request, "paths", list)
    if not all(isinstance(path, str) for path in paths):
        raise BadMessageError("`paths` must be names of parameters.")
    scenario = read_request_scenario(request, desk)
    if scenario.initial or scenario.restart_at:
        raise InputError("This scenario sets its initial state, so it cannot run by hand.")
    return describe_stepped(scenario.text, tuple(paths))
