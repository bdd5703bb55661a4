"""A model of a static page, built on request by a server."""

from __future__ import annotations

import base64
import functools

from martensite.app.messages import JsonTable
from martensite.app.static_site.flat_inputs import list_waveforms
from martensite.app.static_site.input_map import measure_map
from martensite.app.static_site.run_module import RunSource, write_source
from martensite.app.static_site.scenario_table import describe_static
from martensite.export.wasm.module import find_wasm_compiler

KEPT = 8
"""Number of cached models."""


@functools.lru_cache(KEPT)
def describe_stepped(text: str, paths: tuple[str, ...]) -> JsonTable:
    """Return the data of a scenario for the page, and the module of its runs in base 64."""
    find_wasm_compiler()
    made = measure_map(text, paths)
    source = write_source(made.scenario, list_waveforms(made.scenario))
    module = _compile_source(source)
    return {"scenario": describe_static("", text, made, source, ""), "module": module}


@functools.lru_cache(KEPT)
def _compile_source(source: RunSource) -> str:
    """Return the module in base 64, compiled once per structure."""
    return base64.b64encode(source.compile()).decode()
