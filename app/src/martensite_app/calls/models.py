"""Call of a model that the page steps by itself, by hand: what it needs to know, and the module."""

from __future__ import annotations

import base64
import functools
from collections.abc import Callable

from martensite.base.errors import InputError
from martensite_app.documents import read_request_scenario
from martensite_app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite_app.worker import Desk

KEPT = 8
"""Models that are kept; one takes some seconds."""


def build_model(request: Request, desk: Desk) -> JsonTable:
    """A scenario as the static page has it, with the WebAssembly of its runs.

    {"text": TOML, "changes": {…}, "paths": ["mechanism.mass"]} -> {"scenario": {…}, "module": base 64}

    Of its numbers, those at `paths` can be changed while the model runs.
    """
    paths = require_entry(request, "paths", list)
    if not all(isinstance(path, str) for path in paths):
        raise BadMessageError("`paths` must be names of numbers.")
    scenario = read_request_scenario(request, desk)
    if scenario.initial or scenario.restart_at:
        raise InputError(
            "This scenario names the state in which it begins: it does not run by hand, which begins at rest."
        )
    if scenario.whole.sample_time():
        raise InputError(
            "A controller in discrete time drives this mechanism: it does not run by hand. "
            "Open one without, such as `Wire and dead weight`."
        )
    return _build_model(scenario.text, tuple(paths))


@functools.lru_cache(KEPT)
def _build_model(text: str, paths: tuple[str, ...]) -> JsonTable:
    from martensite_app.static_site.flat_inputs import waveforms_of
    from martensite_app.static_site.input_map import measure_map
    from martensite_app.static_site.run_module import require_compiler, write_source
    from martensite_app.static_site.scenario_table import describe_static

    require_compiler()
    made = measure_map(text, paths)
    source = write_source(made.scenario, waveforms_of(made.scenario))
    module = _compile_source(source.digest, source.compile)
    return {"scenario": describe_static("", text, made, source, ""), "module": module}


_modules: dict[str, str] = {}


def _compile_source(digest: str, compile_it: Callable[[], bytes]) -> str:
    """The module in base 64: compiled once for every structure."""
    if digest not in _modules:
        _modules[digest] = base64.b64encode(compile_it()).decode()
    return _modules[digest]
