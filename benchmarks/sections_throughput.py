"""The section `throughput`: how many runs a second, and what keeps it from being more.

What: batches of the coupled wire (3000 steps) and of the finger with each law, in C by blocks of
lanes in one thread and in two, one by one, and the wire by LSODA at equal error. The printed C in
lanes is the limit that the rest is compared with. Then what a run costs, and how much memory a
process takes, against the number of runs; and the share of what the processor could do at most.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks import throughput_runs as runs
from benchmarks.engines import available
from benchmarks.harness import Candidate, Timing, measure
from benchmarks.problem_a import Wire, first_sets, rms_error
from benchmarks.process import run_process
from benchmarks.references import batch_reference
from benchmarks.report import Table
from benchmarks.roofline import peaks, work
from benchmarks.sections import Options, section
from benchmarks.throughput_once import PIECE
from benchmarks.throughput_runs import Case, Kept

SIMD = "C lanes"
RTOLS = ("rtol 1e-5", "rtol 1e-6")
LSODA = {"lsoda-c": "LSODA in C", "odeint": "LSODA, odeint", "lsoda": "LSODA, solve_ivp"}
LEAST = 1024  # runs from which the cost of one is judged
SAMPLE = 8  # bytes of a number


class Effort(NamedTuple):
    """What is run; the tests run less."""

    laws: Sequence[str] = runs.LAWS
    most: int = 64  # runs of a batch one by one
    scaling: Sequence[int] = (1_000, 10_000)
    peer: int = 4


USUAL = Effort()


def apart(case: Case, judged: int) -> Any:
    """Largest difference to the same runs one by one, as a share of the range."""
    exact = runs.one_by_one(case, judged)().first

    def error(found: Kept) -> float:
        count = min(len(exact), len(found.first))
        return float(np.abs(found.first[:count] - exact[:count]).max() / np.ptp(exact))

    return error


def against(sets: Wire, count: int) -> Any:
    """Worst rms error of the first runs of the wire against its reference."""
    exact = batch_reference("P", sets, runs.sine(), min(count, runs.KEPT))

    def error(found: Kept) -> float:
        pairs = zip(found.first, exact, strict=False)
        return max(rms_error(1e3 * x, meant) for x, meant in pairs)

    return error


def engines(case: Case, count: int, error: Any, effort: Effort) -> list[Candidate]:
    """All ways to make `count` runs."""
    few = min(count, effort.most)
    return [
        Candidate(SIMD, runs.in_lanes(case, count), error, count),
        Candidate("C lanes, two threads", runs.in_lanes(case, count, threads=2), error, count),
        Candidate("C one by one", runs.one_by_one(case, few), error, few),
    ]


def peers(sets: Wire, count: int, effort: Effort) -> list[Candidate]:
    """LSODA on the wire, one run after another, at several tolerances."""
    few = min(count, effort.peer)
    some = first_sets(sets, few)
    exact = batch_reference("R", some, runs.sine(), few)

    def error(x: Any) -> float:
        return max(rms_error(a, b) for a, b in zip(x, exact, strict=True))

    found: list[Candidate] = []
    for engine in available(list(LSODA)):
        assert engine.batch is not None
        for label in RTOLS:
            run = engine.batch(some, runs.sine(), engine.settings[label])
            found.append(Candidate(LSODA[engine.name], run, error, few, label))
    return found


def rows_of(timings: Sequence[Timing], candidates: Sequence[Candidate]) -> list[dict[str, Any]]:
    """Printed rows."""
    return [
        {
            "engine": t.name,
            "setting": t.setting,
            "runs": c.per,
            "err": t.err,
            "cpu [us/run]": 1e6 * t.cpu,
            "runs/s (wall)": 1.0 / t.wall,
            "spread": t.spread,
            "ratio": t.ratio,
        }
        for t, c in zip(timings, candidates, strict=True)
    ]


def wire_table(options: Options, count: int, effort: Effort) -> Table:
    """The coupled wire."""
    case, sets = runs.wire(max(options.sizes))
    candidates = engines(case, count, against(sets, count), effort)
    candidates += peers(sets, count, effort)
    timings = measure(candidates, options.repeats, SIMD)
    rows = rows_of(timings, candidates)
    note = f"Ratio: CPU time over that of `{SIMD}`."
    return Table(f"Throughput, {case.name}, {case.steps} steps, batch of {count}", rows, note)


def finger_table(options: Options, law: str, count: int, effort: Effort) -> Table:
    """The finger with a law."""
    case = runs.finger(law, max(options.sizes))
    error = apart(case, min(count, runs.KEPT))
    candidates = engines(case, count, error, effort)
    rows = rows_of(measure(candidates, options.repeats, SIMD), candidates)
    note = f"Ratio: CPU time over that of `{SIMD}`. err: to the same runs one by one."
    return Table(f"Throughput, {case.name}, {case.steps} steps, batch of {count}", rows, note)


def scaling_table(effort: Effort) -> Table:
    """Cost and memory against the number of runs, each in a process of its own."""
    rows: list[dict[str, Any]] = []
    for count in effort.scaling:
        usage = run_process([sys.executable, "-m", "benchmarks.throughput_once", str(count)])
        rows.append(
            {
                "runs": count,
                "cpu [us/run]": 1e6 * usage.answer["cpu"] / count,
                "peak [MB]": usage.peak,
                "growth [MB]": usage.answer["growth"],
                "ratio": usage.answer["cpu"] / count,
            }
        )
    for row in rows:
        row["ratio"] /= rows[0]["cpu [us/run]"] * 1e-6
    note = (
        "The wire for 2 s in 100 steps, parameters drawn and strokes kept for "
        f"{PIECE:,} runs at a time; ratio to the first row. Growth: of the peak memory while the "
        "runs were made."
    )
    return Table(f"Cost of a run against the number of runs, {SIMD}", rows, note)


def roofline_table(options: Options, effort: Effort) -> Table:
    """Shares of what one core could do at most."""
    limit, count = peaks(), runs.LANES
    rows: list[dict[str, Any]] = []
    for case in (runs.wire(count)[0], *(runs.finger(law, count) for law in effort.laws)):
        lanes = Candidate(SIMD, runs.in_lanes(case, count), per=count)
        (timing,) = measure([lanes], options.repeats)
        made, share = work(case.compiled), case.steps / timing.cpu
        moved = SAMPLE * (len(case.grid.times) + len(case.values)) / timing.cpu
        rows.append(
            {
                "system": case.name,
                "operations/step": made.operations,
                "divisions/step": made.divisions,
                "Gop/s": 1e-9 * made.operations * share,
                "of arithmetic [%]": 100.0 * made.operations * share / limit.operations,
                "of division [%]": 100.0 * made.divisions * share / limit.divisions,
                "of memory [%]": 100.0 * moved / limit.bytes,
            }
        )
    note = (
        f"One core, measured: {1e-9 * limit.operations:.3g} G operations/s (products and sums, "
        f"not fused), {1e-9 * limit.divisions:.2g} G divisions/s, {1e-9 * limit.bytes:.2g} GB/s. "
        "Every operation counts as one, a sine too; divisions as written, before some share an "
        "inverse. States stay in the cache: memory is read and written once per run."
    )
    return Table("Fraction of the peak performance of the processor", rows, note)


@section
def throughput(options: Options, effort: Effort = USUAL) -> list[Table]:
    """Batches of all sizes, cost and memory against the number of runs, and the limit."""
    tables = [wire_table(options, count, effort) for count in options.sizes]
    large = max(options.sizes)
    tables += [finger_table(options, law, min(large, LEAST), effort) for law in effort.laws]
    scaling = sorted({*effort.scaling, *(size for size in options.sizes if size > LEAST)})
    tables.append(scaling_table(effort._replace(scaling=scaling)))
    return [*tables, roofline_table(options, effort)]
