"""What this processor could do at most, measured: arithmetic, division, memory; one core.

What: loops in C over vectors that stay in registers give multiplications and additions per
second, and divisions per second; a copy between two arrays larger than any cache gives bytes per
second. Operations of a kernel are counted in its graph: every arithmetic operation and comparison
is one, an elementary function too.
"""

from __future__ import annotations

import ctypes
import statistics
import time
from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from martensite.kernels.compiler import load_library
from martensite.simulate.compiled import CompiledSystem

FREE = frozenset({"input", "constant", "item", "result", "detach", "store", "solved", "eps"})
TYPICAL = 3
"""Turns of a solve, which ends when it is done."""
_WIDTH, _CHAINS = 8, 12
_SOURCE = f"""
typedef double vector __attribute__((vector_size({8 * _WIDTH})));
#define BODY(operation) {{ \\
    vector x[{_CHAINS}], y; \\
    for (int l = 0; l < {_WIDTH}; l++) y[l] = *factor; \\
    for (int k = 0; k < {_CHAINS}; k++) x[k] = y; \\
    for (long i = 0; i < turns; i++) \\
        for (int k = 0; k < {_CHAINS}; k++) {{ operation; }} \\
    double sum = 0.0; \\
    for (int k = 0; k < {_CHAINS}; k++) for (int l = 0; l < {_WIDTH}; l++) sum += x[k][l]; \\
    *factor = sum; \\
}}
void products(long turns, double *factor) BODY(x[k] = x[k] * y + y)
void quotients(long turns, double *factor) BODY(x[k] = y / x[k])
"""


class Peaks(NamedTuple):
    """Of one core."""

    operations: float
    """Multiplications and additions [1/s]; not fused, as in the kernels."""
    divisions: float
    """[1/s]"""
    bytes: float
    """Read or written by a copy [1/s]."""


class Work(NamedTuple):
    """Of one step of one run."""

    operations: int
    divisions: int


def best(run: Callable[[], object], repeats: int = 5) -> float:
    """CPU seconds of the median call."""
    times: list[float] = []
    for _ in range(repeats):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return statistics.median(times)


@cache
def peaks(turns: int = 1_000_000, megabytes: int = 256) -> Peaks:
    """Measured now."""
    library = load_library(_SOURCE)
    factor = ctypes.c_double()

    def looped(name: str) -> Callable[[], None]:
        def run() -> None:
            factor.value = 0.5
            getattr(library, name)(ctypes.c_long(turns), ctypes.byref(factor))

        return run

    made = turns * _WIDTH * _CHAINS
    source = np.ones(megabytes * 125_000)
    target = np.empty_like(source)
    copied = best(lambda: np.copyto(target, source))
    return Peaks(2 * made / best(looped("products")), made / best(looped("quotients")), 2 * source.nbytes / copied)


def work(compiled: CompiledSystem) -> Work:
    """Operations of a step, those in loops as often as they are made, about."""
    graph, found = compiled.program.graph, Counter[str]()
    constant = {node.index for node in compiled.program.hoisted_nodes}

    def count(wanted: list[int], times: int, inside: int) -> None:
        seen, stack = set[int](), list(wanted)
        while stack:
            index = stack.pop()
            if index in seen or index in constant:
                continue
            if inside and not graph.depends[index] & inside:
                continue
            seen.add(index)
            operation = graph.operations[index]
            found[operation] += times if operation not in ("each", "repeat") else 0
            loop, turns = graph.loops.get(index), graph.repeats.get(index)
            if loop:
                count(list(loop.outputs), times * len(loop.columns[0]), loop.bit)
            if turns:
                made = TYPICAL if turns.stops else turns.turns
                count(list(turns.outputs), times * made, turns.bit)
            stack.extend(graph.children(index))

    count([node.index for node in compiled.program.functions["step"].outputs], 1, 0)
    total = sum(n for name, n in found.items() if name not in FREE)
    return Work(total, found["div"])
