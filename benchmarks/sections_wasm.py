"""The section of the benchmark on WebAssembly: a step in Node.js beside C and plain floats, and sizes.

What: the wire of `examples/pwm_bias_spring.toml` and others on the same given steps. Floats, the lanes of the
export in C of this machine, and the same text as WebAssembly, which one call of its script runs: what the
script does with signals is in its time. Best of interleaved rounds, per step; sizes as sent by a server.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.sections import Options, section
from benchmarks.wasm_runs import NativeLanes, play_module, say_missing, write_module
from martensite.export.c_example import Step, list_run_inputs
from martensite.export.wasm import build_wasm
from martensite.scenario.scenario import load
from martensite.simulate.compiled import bind_system

EXAMPLES = ("pwm_bias_spring", "finger", "closed_loop_sensorless", "hand")
STEPS, ROUNDS = 2000, 20


def run_floats(system: Any, first: Sequence[float], steps: Sequence[Step]) -> float:
    """Time [s] of a run on plain floats, nothing observed."""
    functions, size = bind_system(system)
    step, state = functions["step"], functions["init"](*first)
    begin = time.perf_counter()
    for dt, inputs in steps:
        state = step(*state, *inputs, dt)[:size]
    return time.perf_counter() - begin


def measure_example(name: str, repeats: int) -> dict[str, Any]:
    """A row of the table."""
    scenario = load(ROOT / f"examples/{name}.toml")
    system = scenario.whole
    first, steps = list_run_inputs(system, scenario.waveform, scenario.duration, STEPS, 1)
    made = build_wasm(system, name="model", first=first)
    floats, native, wasm = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        write_module(made, Path(folder))
        lanes = NativeLanes(made.core, Path(folder), 1)
        for _ in range(repeats):
            floats.append(run_floats(system, first, steps))
            rows, said = play_module(made, Path(folder), steps, ROUNDS)
            wasm.append(said["seconds"])
            for _ in range(ROUNDS):
                lanes.start(first)
                native.append(lanes.run(steps, len(steps), [])[1])
        lanes.start(first)
        meant = lanes.run(steps, 1, range(len(made.core.outputs)))[0][:, :, 0]
    largest = np.maximum(np.abs(meant).max(axis=0), np.finfo(float).tiny)
    best = {kind: 1e6 * min(found) / len(steps) for kind, found in zip(KINDS, (floats, native, wasm), strict=True)}
    return {
        "example": name,
        **{f"{kind} [us]": value for kind, value in best.items()},
        "wasm / C": best["wasm"] / best["C"],
        "err of C": float((np.abs(rows[1:] - meant) / largest).max()),
        "raw [kB]": len(made.binary) / 1e3,
        "gzip [kB]": made.packed / 1e3,
    }


KINDS = ("floats", "C", "wasm")


@section
def wasm(options: Options) -> list[Table]:
    """One step in a browser's virtual machine."""
    missing = say_missing()
    if missing:
        print(f"section wasm left out: there is no {missing}")
        return []
    rows = [measure_example(name, options.repeats) for name in EXAMPLES]
    return [
        Table("WebAssembly: one step", rows, "Wall time, best of interleaved rounds; C with the libm of this machine.")
    ]
