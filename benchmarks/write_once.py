"""`python -m benchmarks.write_once RUNS [SAMPLE]`: what a sweep costs beside its runs, in this process.

What: the sweep of `sweep_once` with runs that cost next to nothing: their measures are sums of the numbers that are
varied. All else is the real thing: sample, chunks of the usual size, writer, checksums, flags, backend `serial`. After
every tenth of it a whole sweep of `BASE` runs is written too, so that both meet the same machine. Prints JSON: CPU time
of a run [s] in every tenth and in those small sweeps; CPU time [s] of making the store, of its summary, and of checking
it as a command does that goes on; peak memory [MB] before, after writing, and after the summary.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.sweep_once import OVER, SCENARIO
from benchmarks.throughput_once import peak
from martensite.base.status import Status
from martensite.design.sweep.api import PlannedSweep, Progress, SweepExecution, begin_sweep
from martensite.design.sweep.job import MEASURES, SweepJob, SweepRequest
from martensite.design.sweep.plan import DETAILS, SweepPiece
from martensite.scenario.scenario import read_scenario
from martensite.show.summaries.sweep import summarise_sweep

BASE = 100_000
TENTHS = 10


class WritingJob(SweepJob):
    """A job whose runs are sums."""

    def compute(self, rows: range) -> SweepPiece:
        """Numbers as a sample has them, which do not compress."""
        values = self.plan.values(rows)
        total = values @ np.linspace(1.0, 2.0, values.shape[1])
        scalars = {name: total + k for k, name in enumerate((*self.plan.measures, *DETAILS))}
        return SweepPiece(values, scalars, {}, np.full(len(rows), Status.OK, np.int8))


@contextmanager
def clock(times: list[float]) -> Iterator[None]:
    """Append the CPU time of a block [s]."""
    begin = time.process_time()
    yield
    times.append(time.process_time() - begin)


def plan(count: int, sample: str, path: Path) -> PlannedSweep:
    """A sweep of so many runs, whose store is made."""
    wanted = SweepRequest(OVER, f"{sample}:{count}", MEASURES, runtime="c")
    scenario = read_scenario(SCENARIO, path.parent / "scenario.toml")
    planned = begin_sweep(scenario, wanted, path, SweepExecution("serial"))
    return replace(planned, job=WritingJob(planned.job.path, planned.job.spec))


def write(planned: PlannedSweep, chunks: range) -> Progress:
    """Write some chunks, one after another."""
    return replace(planned, part=chunks).run()


def main(count: int, sample: str) -> None:
    """Write, and say what it took."""
    tenths, small, once = list[float](), list[float](), list[float]()
    with tempfile.TemporaryDirectory() as folder:
        write(first := plan(BASE, sample, Path(folder) / "first.zarr"), range(first.plan.chunks))  # loads all it needs
        before = peak()
        with clock(once):
            large = plan(count, sample, Path(folder) / "large.zarr")
        ends = [round(k * large.plan.chunks / TENTHS) for k in range(TENTHS + 1)]
        for k, (begin, end) in enumerate(pairwise(ends)):
            with clock(tenths):
                progress = write(large, range(begin, end))
            other = plan(BASE, sample, Path(folder) / f"{k}.zarr")
            with clock(small):
                write(other, range(other.plan.chunks))
            sys.stderr.write(f"{k + 1} of {TENTHS} tenths: {TENTHS * tenths[k] / count / small[k] * BASE:.3f}\n")
        written = peak()
        with clock(once):
            summarise_sweep(large.plan, large.store, progress)
        with clock(once):
            damaged = large.store.find_damaged()
        if damaged or len(large.store.list_finished_chunks()) < large.plan.chunks:
            raise AssertionError(f"{len(damaged)} chunks are damaged")
    found = {"tenths": [TENTHS * one / count for one in tenths], "small": [one / BASE for one in small]}
    found |= dict(zip(("make", "summary", "check"), once, strict=True))
    print(json.dumps({**found, "before": before, "written": written, "after": peak()}))


if __name__ == "__main__":
    main(int(sys.argv[1]), *(sys.argv[2:] or ["sobol"]))
