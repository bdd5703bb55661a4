"""A model that the page runs by itself, built on request by a server."""

from __future__ import annotations

import base64
import functools
from dataclasses import replace

from martensite.app.documents import build_packaged
from martensite.app.messages import JsonTable
from martensite.app.static_site.flat_inputs import list_waveforms
from martensite.app.static_site.input_map import measure_map
from martensite.app.static_site.packaged_modules import has_module, provide_module
from martensite.app.static_site.run_module import RunSource, write_source
from martensite.app.static_site.scenario_table import describe_static
from martensite.base.errors import InputError
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result

KEPT = 8
"""Number of cached models."""
PIECES, SAMPLES = 100, 11
"""Pieces of a run, the first of which is computed to describe its outputs, and samples of this piece."""


@functools.lru_cache(KEPT)
def describe_stepped(text: str, paths: tuple[str, ...], ready: bool = False) -> JsonTable:
    """Return the data of a scenario for the page, and the module of its runs in base 64.

    Raises:
        InputError: the module is missing, and cannot be compiled or, with `ready`, would have to be.
    """
    scenario = build_packaged(text)
    source = write_source(scenario, list_waveforms(scenario))
    if ready and not has_module(source):
        raise InputError("The module of this structure is not compiled.")
    module = _encode_module(source)  # the first, since it may need a compiler
    input_map = measure_map(text, paths)
    table = describe_static("", text, input_map, source, "", result=_run_piece(input_map.scenario))
    return {"scenario": table, "module": module}


@functools.lru_cache(KEPT)
def _encode_module(source: RunSource) -> str:
    return base64.b64encode(provide_module(source)).decode()


def _run_piece(scenario: Scenario) -> Result:
    period = scenario.whole.sample_time()
    piece = replace(scenario, duration=max(scenario.duration / PIECES, 2.0 * period), samples=SAMPLES)
    return piece.run(runtime="floats")
