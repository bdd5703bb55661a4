"""A row of the benchmark of control, repeated by SciPy and a page of equations: see `closed_loop_reference`.

Its gains are gentle: where a loop hunts in a hysteresis, as with those of the entry `pid`, a wire that is marched in
finer steps swings at other times, and only what many wires do on the whole can be repeated.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from benchmarks.control.competition import EntryRuns, run_benchmark
from benchmarks.control.entries import read_entry
from benchmarks.control.tasks import draw_noise, find_task, load_plant
from benchmarks.control.wires import draw_wires
from closed_loop_reference import Wire, run_loop

WIRES, GAINS = 2, (400.0, 100.0, 20.0)
ENTRY = """
title = "PID with gentle gains"
plants = ["wire"]

[controller]
kind = "pid"
measured = "followed"
Kp = 400.0
Ki = 100.0
Kd = 20.0
"""


def test_scipy_repeats_a_row(tmp_path: Path) -> None:
    (tmp_path / "gentle.toml").write_text(ENTRY)
    task, bench = find_task("sine"), load_plant("wire")
    table = run_benchmark([EntryRuns(read_entry(tmp_path / "gentle.toml"))], [task], [], WIRES)
    times = bench.period * np.arange(round(task.duration / bench.period) + 1)
    reference = np.array([task.reference.value(float(t)) for t in times])
    names, noise = draw_noise(bench, task.name, WIRES, len(times))
    nominal = {leaf.path: float(leaf.value) for leaf in bench.plant.leaves()}
    drawn = {path.removeprefix("plant."): rows for path, rows in draw_wires(bench, WIRES).items()}
    judged = times >= task.judged_from - 1e-9
    errors: list[float] = []
    for k in range(WIRES):
        wire = Wire(nominal | {path: float(rows[k]) for path, rows in drawn.items()})
        own = noise[:, names.index("noise.followed"), k]
        found = run_loop(wire, GAINS, reference, own, bench.period, (1e-5, 2e-3 / 4096))
        errors.append(float(np.sqrt(np.mean(((reference - found)[judged] / task.span) ** 2))))
    np.testing.assert_allclose(table.measures["gentle", "sine", "none"]["error"], errors, rtol=1e-3)
    assert table.rows[0].error_90 == max(table.measures["gentle", "sine", "none"]["error"])
