"""Interleaved timing of several candidates in one process.

What: every round runs all candidates one after another (A B C A B C ...), so that a change of the
machine's load meets all of them. Time is CPU time of the process, user + system, all threads, and
wall time beside it; short calls are looped until a block lasts `BLOCK` seconds. Printed are the
median over rounds, the spread (upper minus lower quartile over the median) and the ratio to a base,
as the median of the ratios within the rounds. The garbage collector stays on; it is run before
each block. The first call of a candidate is not timed: it warms up and gives the error. Work in
another process is not in the CPU time of this one: such a candidate has a `clock`.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

BLOCK = 0.03  # [s]


class Candidate(NamedTuple):
    """What is timed: `run` does the work of `per` trajectories; `error` judges its result.

    `clock` reads the CPU seconds out of the result of work that was done in another process.
    """

    name: str
    run: Callable[[], Any]
    error: Callable[[Any], float] | None = None
    per: int = 1
    setting: str = ""
    clock: Callable[[Any], float] | None = None


class Timing(NamedTuple):
    """Result for one candidate; times in seconds per trajectory."""

    name: str
    setting: str
    err: float
    cpu: float
    wall: float
    spread: float
    ratio: float


def measure(candidates: Sequence[Candidate], repeats: int = 5, base: str | None = None) -> list[Timing]:
    """Time all candidates in interleaved rounds; the ratio is to `base`, else to the first."""
    ready = [_prepare(c) for c in candidates]
    rounds = [[_block(c, loops) for c, loops, _ in ready] for _ in range(repeats)]
    names = [c.name for c in candidates]
    at = names.index(base) if base in names else 0
    return [_summary(ready[i], [r[i] for r in rounds], [r[at] for r in rounds]) for i in _all(ready)]


def _all(items: Sequence[Any]) -> range:
    return range(len(items))


def _prepare(candidate: Candidate) -> tuple[Candidate, int, float]:
    """First call, error, and the number of calls that fill a block."""
    result = candidate.run()
    error = candidate.error(result) if candidate.error else float("nan")
    begin = time.perf_counter()
    candidate.run()
    once = time.perf_counter() - begin
    return candidate, max(1, min(10_000, round(BLOCK / max(once, 1e-7)))), error


def _block(candidate: Candidate, loops: int) -> tuple[float, float]:
    """(CPU, wall) seconds per trajectory of one timed block."""
    run = candidate.run
    if candidate.clock:
        seconds = candidate.clock(run()) / candidate.per
        return seconds, seconds
    gc.collect()
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(loops):
        run()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    share = 1 / (loops * candidate.per)
    return cpu * share, wall * share


def _summary(
    ready: tuple[Candidate, int, float], times: list[tuple[float, float]], base: list[tuple[float, float]]
) -> Timing:
    candidate, _, error = ready
    cpu = [t[0] for t in times]
    return Timing(
        name=candidate.name,
        setting=candidate.setting,
        err=error,
        cpu=statistics.median(cpu),
        wall=statistics.median(t[1] for t in times),
        spread=spread(cpu),
        ratio=statistics.median(t[0] / b[0] for t, b in zip(times, base, strict=True)),
    )


def spread(values: Sequence[float]) -> float:
    """Interquartile range over the median; 0 for a single value."""
    if len(values) < 2:
        return 0.0
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return (high - low) / middle


def latencies(call: Callable[[int], Any], count: int, warm: int = 500) -> list[float]:
    """Sorted wall times [s] of single calls, call(i) with i = 0, 1, ...; the first are dropped."""
    clock, times = time.perf_counter_ns, []
    for i in range(count + warm):
        begin = clock()
        call(i)
        times.append(clock() - begin)
    return sorted(t * 1e-9 for t in times[warm:])
