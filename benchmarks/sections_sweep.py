"""The sections `sweep` and `writing`: cost of a run and memory of a process against the number of runs of a sweep.

What: `martensite.design.sweep` with the backend `serial` on a short scenario (`sweep_once`), from
one run
to `Options.most` in powers of ten, every sweep in a process of its own. Every number is measured,
none continued from a smaller one: what the time budget leaves no room for is left out, and the
table says so. Ratios are to the sweep of `BASE` runs, memory to the process before its sweep.

`writing` does so for what a sweep costs beside its runs (`write_once`): `Options.most` runs against sweeps of
`write_once.BASE` that are written between its tenths, in one process.
"""

from __future__ import annotations

import statistics
import sys
import time
from typing import Any

from benchmarks.harness import spread
from benchmarks.process import run_process
from benchmarks.report import Table
from benchmarks.sections import Options, section
from benchmarks.write_once import BASE as SMALL

BASE = 1_000
ONCE = 100_000  # from this many runs on, a sweep is made once


def counts(most: int) -> list[int]:
    """1, 10, ... up to `most`."""
    found = [1]
    while found[-1] * 10 <= most:
        found.append(found[-1] * 10)
    return found


def measured(count: int, repeats: int) -> list[dict[str, float]]:
    """What sweeps of this many runs took, each in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.sweep_once", str(count)]
    turns = 1 if count >= ONCE else repeats
    return [run_process(command).answer for _ in range(turns)]


def fits(count: int, rows: list[dict[str, Any]], left: float) -> bool:
    """Whether a sweep, ten times the last one, will probably fit into `left` seconds.

    Up to `BASE` runs a sweep is mostly its own beginning, and short.
    """
    return count <= BASE or 10.0 * rows[-1]["wall [s]"] <= left


def row_of(count: int, found: list[dict[str, float]]) -> dict[str, Any]:
    """One printed row, the ratio not yet divided."""
    cpu = [one["cpu"] / count for one in found]
    middle = statistics.median(cpu)
    return {
        "runs": count,
        "failed": int(max(one["failed"] for one in found)),
        "stroke [mm]": 1e3 * found[0]["stroke"],
        "cpu [us/run]": 1e6 * middle,
        "wall [s]": statistics.median(one["wall"] for one in found),
        "spread": spread(cpu) if len(cpu) > 1 else None,
        "memory": statistics.median(one["after"] / one["before"] for one in found),
        "ratio": middle,
    }


@section
def sweep(options: Options) -> list[Table]:
    """A sweep of ever more runs, as long as the time budget lasts."""
    rows: list[dict[str, Any]] = []
    begin, left_out = time.monotonic(), ""
    for count in counts(options.most):
        if not fits(count, rows, options.budget - (time.monotonic() - begin)):
            left_out = f" Left out for want of time: {count:,} runs and more."
            break
        rows.append(row_of(count, measured(count, options.repeats)))
    base = next((row for row in rows if row["runs"] == BASE), rows[-1])["ratio"]
    for row in rows:
        row["ratio"] /= base
    note = (
        "One thread; ratio: CPU time of a run over that in the sweep of "
        f"{min(BASE, rows[-1]['runs']):,}. Memory: peak over that before the sweep.{left_out}"
    )
    return [Table("Sweep of a short scenario into a store, backend serial", rows, note)]


@section
def writing(options: Options) -> list[Table]:
    """What a run costs beside itself, in a sweep of many and in small ones between its tenths."""
    command = [sys.executable, "-m", "benchmarks.write_once", str(options.most)]
    found = run_process(command).answer
    small, tenths = statistics.mean(found["small"]), found["tenths"]
    parts = {"all": statistics.mean(tenths), "first tenth": tenths[0], "last tenth": tenths[-1]}
    rows = [{"part": name, "cpu [us/run]": 1e6 * one, "ratio": one / small} for name, one in parts.items()]
    note = (
        f"One thread; ratio: CPU time of a run over that in sweeps of {SMALL:,}, which take {1e6 * small:.0f} us. Peak "
        f"memory {found['written'] / found['before']:.2f} times that before, {found['after'] / found['before']:.2f} "
        f"with the summary, which takes {found['summary']:.1f} s; checking every file {found['check']:.1f} s."
    )
    return [Table(f"Writing a sweep of {options.most:,} runs that cost nothing, sample sobol", rows, note)]
