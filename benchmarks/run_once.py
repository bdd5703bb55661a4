"""One engine in a fresh process: `python -m benchmarks.run_once ENGINE KIND SIZE REPEATS`.

KIND is `single`, `batch` or `gradient`; SIZE is the number of sets of a batch. Runs the usual
setting on the sine drive and, where REPEATS > 0, prints JSON: seconds for the imports, for
preparation and first call, and for a repeat (median). Imports only what the engine needs.
"""

from __future__ import annotations

import sys
import time

BEGIN = time.perf_counter()


def main(name: str, kind: str, size: int, repeats: int) -> None:
    """Load, prepare, run, repeat."""
    from benchmarks.engines import load
    from benchmarks.inputs import sine
    from benchmarks.problem_a import Wire, parameter_sets

    engine = load(name)
    loaded = time.perf_counter()
    wire = parameter_sets(size) if kind == "batch" else Wire()
    run = getattr(engine, kind)(wire, sine(), engine.settings[engine.usual])
    run()
    first = time.perf_counter()
    if not repeats:
        return
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    repeat = sorted(times)[repeats // 2]
    sys.stdout.write(f'{{"load": {loaded - BEGIN}, "first": {first - loaded}, "repeat": {repeat}}}')


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
