"""Running for the page: on plain floats at once, and in C as soon as it is compiled.

Compiling takes a second or two, once for every structure: a changed number runs what is there.
"""

from __future__ import annotations

import threading
from collections.abc import Hashable

from martensite.errors import MartensiteError
from martensite.io.scenario import Scenario
from martensite.parameters import structure
from martensite.runtimes.c99 import compiler
from martensite.simulate.result import Result

_ready: set[Hashable] = set()
_begun: set[Hashable] = set()


def run(scenario: Scenario) -> tuple[Result, str]:
    """The run, and the runtime that made it."""
    if scenario.outside:
        return scenario.run(), "floats"
    key = structure(scenario.whole)
    if key in _ready:
        return scenario.run(runtime="c"), "c"
    result = scenario.run(runtime="floats")
    if key not in _begun and compiler() is not None:
        _begun.add(key)
        threading.Thread(target=_compile, args=(scenario, key), daemon=True).start()
    return result, "floats"


def _compile(scenario: Scenario, key: Hashable) -> None:
    """Compile by running; a structure that does not run in C stays on floats."""
    try:
        scenario.run(runtime="c")
    except (MartensiteError, ArithmeticError, MemoryError, OSError):
        return
    _ready.add(key)
