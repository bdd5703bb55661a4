"""The section of the benchmark on elements: what cells along a wire cost, beside one temperature.

What: one pulse of `examples/clamped_wire.toml` in fixed steps, with clamps that take nothing, so
that the lumped wire is the exact answer and the error is that of the solver alone.
"""

from __future__ import annotations

from typing import Any, cast

from benchmarks.harness import Candidate, measure
from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.sections import Options, rows_of, section
from martensite.actuators.assembly import System
from martensite.actuators.elements.axial_wire import AxialWire
from martensite.scenario.scenario import Scenario, load
from martensite.simulate.api import simulate

EXAMPLE = ROOT / "examples/clamped_wire.toml"
STEP = 0.02  # [s]
CELLS = ("5", "10", "20")
RUNTIMES = ("floats", "c")


def scenario(cells: str) -> Scenario:
    """The example with a number of cells per half span, and insulated clamps."""
    return load(EXAMPLE, {"element.cells": cells, "element.contact": "0 W/K"})


def lumped(made: Scenario) -> System:
    """The same wire with one temperature."""
    return made.system.with_parts(element=cast(AxialWire, made.system.element).wire)


def strokes(made: Scenario, system: System, runtime: str) -> Any:
    """A function that runs a system and returns its stroke [m]."""

    def run() -> float:
        wave, duration = made.waveform, made.duration
        return simulate(system, wave, duration, step=STEP, samples=51, runtime=runtime).stroke

    return run


@section
def cells(options: Options, counts: tuple[str, ...] = CELLS) -> list[Table]:
    """An axial wire beside a lumped one; the first call, which compiles, is not timed."""
    tables = []
    for runtime in RUNTIMES:
        made = {count: scenario(count) for count in counts}
        base = made[counts[0]]
        exact = strokes(base, lumped(base), runtime)()

        def error(stroke: float, exact: float = exact) -> float:
            return abs(stroke - exact) / exact

        runs = [Candidate("wire", strokes(base, lumped(base), runtime), error)]
        runs += [
            Candidate("axial-wire", strokes(one, one.system, runtime), error, setting=count)
            for count, one in made.items()
        ]
        rows = rows_of(measure(runs, options.repeats, "wire"), "ms", 1e3)
        note = f"{base.duration / STEP:.0f} steps; setting: cells. Ratio to the lumped wire."
        tables.append(Table(f"Cells along a wire, {runtime}", rows, note))
    return tables
