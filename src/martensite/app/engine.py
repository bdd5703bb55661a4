"""Runs for the page: on plain floats at first, and in C once compiled.

Compilation takes seconds, once per structure and machine. Structures compiled earlier on this machine, and long first
runs, use C at once.
"""

from __future__ import annotations

import hashlib
import threading
import time
from collections.abc import Callable, Hashable
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from martensite.app.messages import JsonTable
from martensite.base.caches import cache_folder, make_cache
from martensite.base.errors import MartensiteError
from martensite.base.parameters import describe_structure
from martensite.kernels.compiler import find_compiler
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result

LONG_RUN = 10.0
"""Estimated seconds on floats from which a run waits for the compiler."""
TRIAL_PIECES = 40
"""Number of pieces of a run, one of which is tried."""

_ready: set[Hashable] = set()
_begun: set[Hashable] = set()


def run_fast(scenario: Scenario, tell: Callable[[JsonTable], None]) -> tuple[Result, str]:
    """Return the run, and its runtime; `tell` takes progress notes."""

    def watch(doing: str, share: float) -> None:
        tell({"doing": doing, "done": share})

    key = describe_structure(scenario.whole)
    if find_compiler() is None or (key in _begun and key not in _ready):
        return scenario.run(runtime="floats", tell=watch), "floats"
    if key in _ready or _locate_mark(key).exists() or _is_long(scenario):
        if key not in _ready:
            tell({"doing": "compiling this structure, once", "done": None})
        return _run_in_c(scenario, key, watch), "c"
    result = scenario.run(runtime="floats", tell=watch)
    _begun.add(key)
    threading.Thread(target=_compile_structure, args=(scenario, key), daemon=True).start()
    return result, "floats"


def _run_in_c(scenario: Scenario, key: Hashable, watch: Callable[[str, float], None] | None = None) -> Result:
    result = scenario.run(runtime="c", tell=watch)
    if key not in _ready:
        _ready.add(key)
        with suppress(OSError):
            make_cache("c")
            _locate_mark(key).touch()
    return result


def _compile_structure(scenario: Scenario, key: Hashable) -> None:
    """Compile by a run; a structure that fails in C stays on floats."""
    with suppress(MartensiteError, ArithmeticError, MemoryError, OSError):
        _run_in_c(scenario, key)


def _is_long(scenario: Scenario) -> bool:
    samples = max(2, scenario.samples // TRIAL_PIECES)
    piece = replace(scenario, duration=scenario.duration / TRIAL_PIECES, samples=samples)
    start = time.perf_counter()
    with suppress(MartensiteError):  # the run shows it better
        piece.run(runtime="floats")
    return TRIAL_PIECES * (time.perf_counter() - start) > LONG_RUN


def _locate_mark(key: Hashable) -> Path:
    """Return the marker file of a structure compiled on this machine."""
    words = f"{version('martensite')} {key!r}"
    return cache_folder() / "c" / f"{hashlib.sha256(words.encode()).hexdigest()[:24]}.known"
