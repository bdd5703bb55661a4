"""How long a sweep will take, from one block of its runs; and how many runs go into a chunk.

Runs march together in blocks (`martensite.simulate.variants`): a block costs the same however few
runs are in it. A chunk takes about half a second, so that the picture moves and a cancel is heard.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from martensite.design.backends.processes import count_cores
from martensite.design.sweep.plan import CHUNK, SweepPlan
from martensite.simulate.variants import LANES

CHUNK_TIME = 0.4
"""Time that a chunk shall take [s]."""
MOST_CHUNKS = 500


@dataclass(frozen=True)
class TimedBlock:
    """A block of runs, and how long it took."""

    runs: int
    lanes: int
    seconds: float

    def total(self, size: int, workers: int) -> float:
        """Time of so many runs on so many processes [s]."""
        return -(-size // self.lanes) * self.seconds / max(workers or count_cores(), 1)


def time_block(plan: SweepPlan) -> TimedBlock:
    """Time one block of a plan; it is run twice, as the first one compiles."""
    lanes = LANES.get(plan.course.runtime, CHUNK)
    rows = range(min(lanes, plan.size))
    plan.compute(rows if plan.course.runtime != "floats" else range(1))
    begin = time.perf_counter()
    plan.compute(rows)
    return TimedBlock(len(rows), lanes, time.perf_counter() - begin)


def choose_chunk(plan: SweepPlan) -> int:
    """Runs in a chunk: whole blocks of about `ABOUT`, and no more chunks than are good."""
    one = time_block(plan)
    blocks = max(int(CHUNK_TIME / max(one.seconds, 1e-6)), 1)
    usual = min(blocks * one.lanes, CHUNK)
    least = -(-plan.size // MOST_CHUNKS)
    return max(usual, -(-least // one.lanes) * one.lanes)
