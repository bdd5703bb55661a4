"""The section `cuda`: batches on a GPU beside two cores in C.

What: the wire of README.md (30 s in 6000 steps) and the finger with a law without rates and with
one, around their nominal parameters, in both precisions. All in one process, in interleaved rounds
of wall time: that of the march on the device, and that of the whole call with what is copied. Errors
are to the same runs in C, in doubles. Then from how many runs on the GPU is the quicker one, and what
share of its arithmetic is used: operations are those of a step as printed, every one counted as one, an
elementary function too; the peak is measured, by fused products and sums that count as two.
"""

from __future__ import annotations

import ctypes
import os
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks import throughput_runs as runs
from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.roofline import work
from benchmarks.sections import Options, section
from benchmarks.throughput_runs import Case
from martensite.base.errors import MartensiteError
from martensite.scenario.scenario import load
from martensite.simulate.batch import simulate_batch
from martensite.simulate.cuda.device import Resources, compile_source, open_device, take_answer
from martensite.simulate.cuda.march import GivenStepsMarch, load_march, march_batch
from martensite.simulate.cuda.source import MarchSource
from martensite.simulate.native import march_lanes

CORES = 2
C_NAME = "C, two cores"
JUDGED = 256  # runs that are compared with C
PRECISIONS = ("float64", "float32")
INSIDE = np.array([[-np.inf], [np.inf]])  # the envelope is looked at, and never left


class Effort(NamedTuple):
    """What is run."""

    controlled: int = 1 << 15
    """Runs to a tolerance."""

    batch: int = 1 << 18
    law_batch: int = 1 << 16
    c_batch: int = 2048
    """Runs from which the speed of C is judged; an eighth of them with a dearer law."""
    ladder: Sequence[int] = (16, 64, 256, 1024, 4096, 16384, 65536, 262144, 1048576)
    laws: Sequence[str] = ("mas-hybrid", "mas")


USUAL = Effort()


def source_of(case: Case, precision: str) -> MarchSource:
    """What is compiled for a case."""
    varied = tuple(place for place, value in enumerate(case.values) if np.ndim(value))
    return MarchSource(case.compiled, (case.place,), varied, precision)


def on_cuda(case: Case, count: int, precision: str) -> tuple[GivenStepsMarch, Callable[[], Any]]:
    """The march, and a call that makes `count` runs of it: rows (samples, runs)."""
    source = source_of(case, precision)
    nominal = [value[0] if np.ndim(value) else value for value in case.values]
    table = np.array([case.values[place][:count] for place in source.varied])
    limits = np.broadcast_to(INSIDE, (2, len(case.compiled.envelope)))

    def run() -> Any:
        return march_batch(source, nominal, table, case.grid, limits)[0][:, 0]

    return load_march(source), run


def on_cores(case: Case, count: int) -> Callable[[], Any]:
    """On two threads of C."""
    return pinned(runs.in_lanes(case, count, threads=CORES))


def pinned(make: Callable[[], Any]) -> Callable[[], Any]:
    """On two cores, where the system lets a process choose."""

    def run() -> Any:
        before = os.sched_getaffinity(0)
        os.sched_setaffinity(0, set(sorted(before)[:CORES]))
        try:
            return make()
        finally:
            os.sched_setaffinity(0, before)

    return run if hasattr(os, "sched_setaffinity") else make


def rows_in_c(case: Case, count: int) -> Any:
    """The wanted output of the first runs in C, (samples, runs)."""
    blocks = case.chunks(count, runs.LANES)
    found = [march_lanes(case.compiled, values, case.grid, runs.LANES, [case.place])[0][:, 0] for values in blocks]
    return np.concatenate(found, axis=1)[:, :count]


def time_call(run: Callable[[], Any]) -> float:
    """Wall seconds."""
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


class Way(NamedTuple):
    """One way to make runs."""

    runs: int
    make: Callable[[], Any]
    march: GivenStepsMarch | None = None
    err: float = 0.0


def list_ways(case: Case, batch: int, effort: Effort) -> dict[str, Way]:
    """All that are compared, each made once; C is the first."""
    exact, in_c = rows_in_c(case, JUDGED), effort.c_batch if case.steps > 5000 else effort.c_batch // 8
    ways = {C_NAME: Way(in_c, on_cores(case, in_c))}
    ways[C_NAME].make()
    for precision in PRECISIONS:
        march, run = on_cuda(case, batch, precision)
        error = float(np.abs(run()[:, :JUDGED] - exact).max() / np.ptp(exact))
        ways[f"CUDA {precision}"] = Way(batch, run, march, error)
    return ways


def compare(case: Case, ways: dict[str, Way], repeats: int) -> list[dict[str, Any]]:
    """One printed row for every way, from interleaved rounds."""
    whole: dict[str, list[float]] = {name: [] for name in ways}
    march: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(repeats):
        for name, way in ways.items():
            whole[name].append(time_call(way.make))
            march[name].append(way.march.program.seconds if way.march else whole[name][-1])
    base = statistics.median(whole[C_NAME]) / ways[C_NAME].runs
    rows = []
    for name, way in ways.items():
        taken, device = statistics.median(whole[name]), statistics.median(march[name])
        resources = way.march.program.measure("march")._asdict() if way.march else {}
        rows.append(
            {
                "engine": name,
                "runs": way.runs,
                "err": way.err,
                "whole [s]": taken,
                "march [s]": device,
                "runs/s": way.runs / taken,
                "Msteps/s, march": 1e-6 * way.runs * case.steps / device,
                "ratio": base * way.runs / taken,
                "ratio, march": base * way.runs / device,
                **{name: resources.get(name) for name in Resources._fields},
            }
        )
    return rows


def climb(case: Case, effort: Effort) -> Table:
    """How the speed grows with the batch."""
    in_c = on_cores(case, effort.c_batch)
    in_c()
    base = time_call(in_c) / effort.c_batch
    rows = []
    for count in effort.ladder:
        row: dict[str, Any] = {"runs": count, f"{C_NAME} [s]": base * max(count, runs.LANES)}
        for precision in PRECISIONS:
            march, run = on_cuda(case, count, precision)
            run()
            row[f"{precision} [s]"] = time_call(run)
            row[f"{precision}, march [s]"] = march.program.seconds
            row[f"{precision}, Msteps/s"] = 1e-6 * count * case.steps / march.program.seconds
        rows.append(row)
    found = [min((r["runs"] for r in rows if r[f"{p} [s]"] < r[f"{C_NAME} [s]"]), default=None) for p in PRECISIONS]
    said = ", ".join(f"{p}: from {n} runs on" for p, n in zip(PRECISIONS, found, strict=True))
    note = f"Quicker than C on two cores, {said}. C: continued from {effort.c_batch} runs."
    return Table(f"Batch size, {case.name}", rows, note)


def to_tolerance(effort: Effort, repeats: int) -> Table:
    """Runs with an error control of their own: the wire and the finger."""
    rows = []
    for name, scenario in (
        ("wire of README.md", runs.readme_scenario()),
        ("finger, mas-hybrid", load(ROOT / "examples/finger.toml", {"element.law": "mas-hybrid"})),
    ):
        speeds = {}
        counts = {"c": effort.controlled // 64, "cuda": effort.controlled}
        for runtime, count in counts.items():
            over = vary_lengths(scenario.system, count)

            def run(runtime: str = runtime, over: Any = over, scenario: Any = scenario) -> Any:
                chosen = {"runtime": runtime, "samples": 31, "devices": CORES if runtime == "c" else 1}
                drive = scenario.waveform, scenario.duration
                return simulate_batch(scenario.system, *drive, over, outputs=("stress",), **chosen)

            call_it = pinned(run) if runtime == "c" else run
            found = call_it()
            taken = statistics.median(time_call(call_it) for _ in range(repeats))
            speeds[runtime] = count / taken
            worst = float(np.max(found.variants.accuracy))
            row = {"system": name, "runtime": runtime, "runs": count, "whole [s]": taken, "runs/s": count / taken}
            rows.append({**row, "accuracy": worst, "ratio": speeds[runtime] / speeds["c"]})
    return Table("To a tolerance of 1e-4", rows, "C on two cores. Accuracy: the worst that a run says of itself.")


def vary_lengths(system: Any, count: int) -> dict[str, Any]:
    """Parameters uniform within their shares of the nominal ones."""
    nominal, rng = {leaf.path: leaf.value for leaf in system.leaves()}, np.random.default_rng(0)
    return {p: nominal[p] * (1.0 + share * (2.0 * rng.random(count) - 1.0)) for p, share in runs.VARIED.items()}


def share(case: Case, rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of the arithmetic that the device can do at most."""
    made = work(case.compiled)
    found = []
    for precision in PRECISIONS:
        row = next(row for row in rows if row["engine"] == f"CUDA {precision}")
        rate, peak = 1e6 * row["Msteps/s, march"] * made.operations, measure_peak(precision)
        found.append(
            {
                "system": case.name,
                "precision": precision,
                "operations/step": made.operations,
                "divisions/step": made.divisions,
                "Gop/s": 1e-9 * rate,
                "peak [Gop/s]": 1e-9 * peak,
                "of arithmetic [%]": 100.0 * rate / peak,
            }
        )
    return found


PEAK = """
extern "C" __global__ void products(NUMBER *out, int turns) {
    NUMBER x[8], y = out[0];
    for (int k = 0; k < 8; k++) x[k] = y + (NUMBER)k;
    for (int i = 0; i < turns; i++)
        for (int k = 0; k < 8; k++) x[k] = x[k] * y + y;
    NUMBER sum = 0;
    for (int k = 0; k < 8; k++) sum += x[k];
    out[(long long)blockIdx.x * blockDim.x + threadIdx.x] = sum;
}
"""


def measure_peak(precision: str, blocks: int = 4096, threads: int = 256, turns: int = 4000) -> float:
    """Products and sums a second, fused: each counts as two."""
    device, number = open_device(), {"float64": "double", "float32": "float"}[precision]
    driver = device.driver
    code = compile_source(PEAK.replace("NUMBER", number), f"sm_{device.capability}")
    take_answer(driver.cuCtxSetCurrent(device.context))
    module = take_answer(driver.cuModuleLoadData(code))
    function = take_answer(driver.cuModuleGetFunction(module, b"products"))
    room = take_answer(driver.cuMemAlloc(8 * blocks * threads))
    clock = [take_answer(driver.cuEventCreate(0)) for _ in range(2)]
    packed = (int(room), turns), (ctypes.c_longlong, ctypes.c_int)
    seconds = []
    for _ in range(3):
        take_answer(driver.cuEventRecord(clock[0], 0))
        take_answer(driver.cuLaunchKernel(function, blocks, 1, 1, threads, 1, 1, 0, 0, packed, 0))
        take_answer(driver.cuEventRecord(clock[1], 0))
        take_answer(driver.cuCtxSynchronize())
        seconds.append(1e-3 * take_answer(driver.cuEventElapsedTime(*clock)))
    take_answer(driver.cuMemFree(room))
    return 2 * 8 * turns * blocks * threads / min(seconds)


@section
def cuda(options: Options, effort: Effort = USUAL) -> Iterator[Table]:
    """Batches on a GPU."""
    try:
        device = open_device()
    except MartensiteError as error:
        yield Table("Batches on a GPU", [], f"Left out: {error}")
        return
    wire = runs.readme_wire(max(*effort.ladder, effort.batch))
    cases = [(wire, effort.batch), *((runs.finger(law, effort.law_batch), effort.law_batch) for law in effort.laws)]
    shares: list[dict[str, Any]] = []
    for case, batch in cases:
        rows = compare(case, list_ways(case, batch, effort), options.repeats)
        note = "Ratio: runs a second over those of C. err: to C in doubles, as a share of the range."
        yield Table(f"{device.name}: {case.name}, {case.steps} steps", rows, note)
        shares += share(case, rows)
    yield climb(wire, effort)
    yield to_tolerance(effort, options.repeats)
    note = "Every operation of a printed step counts as one, a sine too; peak measured, fused ones count as two."
    yield Table("Share of what the device can do at most", shares, note)
