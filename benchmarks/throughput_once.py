"""`python -m benchmarks.throughput_once RUNS`: a short problem many times, in bounded memory.

Prints CPU time of the runs [s] and by how much they raised the peak memory [MB]. One block of
lanes runs before the clock starts, so that compiling does not count.
"""

from __future__ import annotations

import json
import resource
import sys
import time

from benchmarks.inputs import sine
from benchmarks.throughput_runs import LANES, in_lanes, wire

DURATION = 2.0  # [s]
PIECE = 10_000  # runs whose parameters are there at the same time


def peak() -> float:
    """Peak memory so far [MB]."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def main() -> None:
    """Make the runs."""
    count = int(sys.argv[1])
    in_lanes(wire(LANES, sine(DURATION))[0], LANES)()
    before, begin = peak(), time.process_time()
    for first in range(0, count, PIECE):
        some = min(PIECE, count - first)
        in_lanes(wire(some, sine(DURATION))[0], some)()
    used = time.process_time() - begin
    print(json.dumps({"cpu": used, "growth": peak() - before}))


if __name__ == "__main__":
    main()
