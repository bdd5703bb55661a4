"""The section `laws`: every registered law along a path of 1000 steps, beside simcoon.

And the section `history`: what the memory of a law costs.

What: single runs as a user makes them, and batches on SIMD lanes of C, each against the
CPU time of simcoon's path of as many steps, measured in the same rounds. simcoon runs its own
alloy and model: paths are compared, not results. A big batch is cut to what takes about a second.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks.engines import OURS
from benchmarks.harness import Candidate, Timing, measure
from benchmarks.inputs import sine
from benchmarks.law_paths import LANES, Case, by_simd, case, judged, lanes_of, single
from benchmarks.ours import Volts, system
from benchmarks.peers import simcoon_path
from benchmarks.problem_a import Wire
from benchmarks.report import Table
from benchmarks.sections import Options, section
from martensite.scenario.running import run

LOOPS = ("superelastic", "thermal")
SINGLE = {"floats": "floats", "C": "c"}
BATCH = {"SIMD batch": by_simd}
MOST = 0.6  # [s] of one call of a batch, as far as one chunk allows
BAR = 100.0
PEER = "simcoon"


def ours(options: Options) -> bool:
    """Whether the library itself takes part."""
    return any(engine.name in OURS for engine in options.engines)


def apart(found: Any, exact: Any) -> float:
    """Largest difference of two strains as a share of the range."""
    exact = np.asarray(exact)
    return float(np.abs(np.asarray(found) - exact).max() / np.ptp(exact))


def peer(loop: str, steps: int) -> list[Candidate]:
    """simcoon's path, timed in a process of its own; none where it is not installed."""
    if not simcoon_path.available():
        return []
    path = {"superelastic": simcoon_path.superelastic_path, "thermal": simcoon_path.thermal_path}
    return [Candidate(PEER, lambda: path[loop](steps, repeats=1), clock=lambda found: found.seconds)]


def singles(given: Case) -> list[Candidate]:
    """One run on each runtime, judged against the bare trace on floats."""
    compiled, values = lanes_of(given, 1)
    exact = judged(given, compiled, values[:, 0])
    return [
        Candidate(name, single(given, runtime), lambda strain: apart(strain, exact)) for name, runtime in SINGLE.items()
    ]


def batches(given: Case, size: int) -> list[Candidate]:
    """A batch on each engine, its first and last lane judged."""
    compiled, values = lanes_of(given, size)
    lanes = min(LANES, size)
    exact = {i: judged(given, compiled, values[:, i]) for i in (0, lanes - 1)}

    def error(chunks: Any) -> float:
        return max(apart(chunks[0][:, i], strain) for i, strain in exact.items())

    return [Candidate(name, *cut(make, given, compiled, values, error)) for name, make in BATCH.items()]


def cut(make: Any, given: Case, compiled: Any, values: Any, error: Any) -> tuple[Any, ...]:
    """A batch of as many chunks as take about `MOST` seconds: run, error, number of sets."""
    chunk = min(LANES, values.shape[1])
    one: Callable[[], Any] = make(given, compiled, values[:, :chunk])
    one()
    begin = time.process_time()
    one()
    count = round(MOST / max(time.process_time() - begin, 1e-6))
    size = chunk * max(1, min(values.shape[1] // chunk, count))
    return make(given, compiled, values[:, :size]), error, size


def rows_of(timings: Sequence[Timing], runs: Sequence[Candidate], labels: Sequence[str]) -> list[dict[str, Any]]:
    """Printed rows; the ratio says how many times simcoon's path takes longer."""
    compared = timings[0].name == PEER
    return [
        {
            "law": law,
            "engine": t.name,
            "sets run": run.per,
            "err": None if t.name == PEER else t.err,
            "cpu [us]": 1e6 * t.cpu,
            "spread": t.spread,
            "ratio to simcoon": 1.0 / t.ratio if compared else None,
        }
        for t, run, law in zip(timings, runs, labels, strict=True)
    ]


def path_rows(options: Options, loop: str, steps: int, names: Sequence[str]) -> list[Any]:
    """All laws and engines along one loop, in the same rounds as simcoon."""
    runs = peer(loop, steps)
    labels = ["SMADI"] * len(runs)
    for name in names if ours(options) else ():
        given = case(name, loop, steps)
        made = [*singles(given), *batches(given, max(options.sizes))]
        runs += made
        labels += [name] * len(made)
    return rows_of(measure(runs, options.repeats), runs, labels) if runs else []


def verdict(name: str, rows: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """The better batch of a law on each loop, and whether both reach the bar."""
    found: dict[str, Any] = {"law": name}
    ratios = []
    for loop, lines in rows.items():
        batch = [r for r in lines if r["law"] == name and r["engine"] in BATCH]
        line = min(batch, key=lambda r: r["cpu [us]"])
        found |= {loop: line["engine"], f"[us] {loop}": line["cpu [us]"]}
        ratios.append(line["ratio to simcoon"])
    found["least ratio"] = None if None in ratios else min(ratios)
    reached = None if None in ratios else min(ratios) >= BAR
    found[f">= {BAR:g}"] = {None: "not measured", True: "yes", False: "NO"}[reached]
    return found


@section
def laws(options: Options, steps: int = 1000, names: Sequence[str] = ()) -> list[Table]:
    """Every registered law along two loops of `steps` steps."""
    from martensite.physics.laws.base import LAWS

    chosen = names or LAWS.names()
    rows = {loop: path_rows(options, loop, steps, chosen) for loop in LOOPS}
    note = (
        "Per path. err: largest strain difference to the trace on floats, of range. Ratio: "
        f"simcoon's time over this one; bar for batches: {BAR:g}."
    )
    if not simcoon_path.available():
        note += " simcoon was not found: name its interpreter in MARTENSITE_SIMCOON_PYTHON."
    tables = [Table(f"Laws, {loop} loop of {steps} steps", lines, note) for loop, lines in rows.items()]
    if ours(options):
        tables.append(Table("Laws: the better batch", [verdict(n, rows) for n in chosen]))
    return tables


@section
def history(options: Options, runs: int = 512, duration: float = 45.0) -> list[Table]:
    """Every history rule on the wire of problem A under its two-tone drive, in C, in rounds with each other.

    One run, and a batch of diameters on steps of 20 ms and to the usual tolerance.
    """
    nominal, drive = system(Wire()), Volts(drive=sine(duration))
    element = nominal.element
    wires = 0.381e-3 * np.random.default_rng(0).uniform(0.98, 1.02, runs)
    ways: dict[str, dict[str, Any]] = {
        "one run": {},
        "batch, 20 ms": {"over": {"element.diameter": wires}, "step": 20e-3},
        "batch, tolerance": {"over": {"element.diameter": wires}},
    }
    rows = []
    for way, how in ways.items():
        made = [
            Candidate(
                rule,
                partial(
                    run,
                    nominal.with_parts(element=element.with_parts(law=element.law.with_parts(history=rule))),
                    drive,
                    duration,
                    samples=101,
                    runtime="c",
                    **how,
                ),
                per=runs if "over" in how else 1,
            )
            for rule in ("resume", "restart", "return-point")
        ]
        rows += [
            {"runs": way, "rule": t.name, "cpu [us]": 1e6 * t.cpu, "spread": t.spread, "ratio": t.ratio}
            for t in measure(made, options.repeats)
        ]
    return [Table("Memory of a law", rows, "CPU time per run of Liang-Rogers; ratio to resume, of the rounds.")]
