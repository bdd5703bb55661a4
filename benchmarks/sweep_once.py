"""`python -m benchmarks.sweep_once RUNS`: a sweep of a short scenario, in this process.

What: a wire on a bias spring, heated for a second by a voltage, 100 steps; diameter, film
coefficient and stiffness drawn at random; of every run the four usual numbers are kept, in chunks
of the usual size in a store on the disk, by the backend `serial` in C. A sweep of `FEW` runs before
the clock starts compiles what is compiled. Prints JSON: CPU and wall time [s] of the sweep, from
its scenario to its last number on the disk, the peak memory [MB] before and after, runs that
failed, and the mean stroke of those that did not.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.throughput_once import peak
from martensite.design.sweep.api import SweepExecution, begin_sweep
from martensite.design.sweep.job import MEASURES, SweepRequest
from martensite.scenario.scenario import read_scenario

SCENARIO = """
title = "A short pulse"

[element]
kind = "wire"
material = "flexinol-90"
law = { kind = "liang-rogers", modulus = "mixture" }
diameter = "0.2 mm"
length = "100 mm"

[environment]
temperature = "22 degC"
cooling = { kind = "constant", h = "80 W/m^2/K" }

[mechanism]
kind = "bias-spring"
stiffness = "300 N/m"
preload = "3 N"

[drive]
kind = "voltage"
waveform = { kind = "step", high = "3 V", at = "0.1 s", until = "1 s" }

[run]
duration = "2 s"
step = "20 ms"
samples = 101
"""
OVER = ("diameter=0.18..0.22 mm", "cooling.h=60..100 W/m^2/K", "stiffness=200..400 N/m")
FEW = 64


def sweep(count: int, folder: str) -> tuple[int, float]:
    """Runs of a sweep that failed, and the mean stroke [m] of the others."""
    wanted = SweepRequest(OVER, f"monte-carlo:{count}", MEASURES, runtime="c")
    place = Path(folder) / f"{count}.zarr"
    begun = begin_sweep(
        read_scenario(SCENARIO, Path(folder) / "scenario.toml"), wanted, place, SweepExecution("serial")
    )
    begun.run()
    failed, strokes, made = 0, 0.0, 0
    for rows, there in begun.store.stretches():
        found = begun.store.group["stroke"][rows][there]
        good = np.isfinite(found)
        failed += int((~good).sum())
        made, strokes = made + int(good.sum()), strokes + float(found[good].sum())
    return failed, strokes / max(made, 1)


def main(count: int) -> None:
    """Sweep and say what it took."""
    with tempfile.TemporaryDirectory() as folder:
        sweep(FEW, folder)
        before, wall, cpu = peak(), time.perf_counter(), time.process_time()
        failed, stroke = sweep(count, folder)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        told = {"before": before, "after": peak(), "failed": failed, "stroke": stroke}
        print(json.dumps({"cpu": cpu, "wall": wall, **told}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
