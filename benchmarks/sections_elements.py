"""The sections of the benchmark on elements: what cells along a wire cost, and fibres over the section of a coil.

Cells: one pulse of `examples/clamped_wire.toml` in fixed steps, with clamps that take nothing, so
that the lumped wire is the exact answer and the error is that of the solver alone.

Fibres: the spring of `examples/platform_spring.toml` under 100 g, heated and cooled all the time, so that it transforms
in most steps; beside the spring whose surface stands for its section. The error is that of few fibres.
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


SPRING = ROOT / "examples/platform_spring.toml"
SWING = {"kind": "sine", "low": "0 A", "high": "1.5 A", "frequency": "0.02 Hz"}
LOADED = {"mechanism.mass": "100 g", "drive.waveform": SWING}


@section
def fibres(options: Options, counts: tuple[str, ...] = ("5", "20", "80")) -> list[Table]:
    """A coil of fibres beside one of a surface, in C; the first call, which compiles, is not timed."""
    surface = load(SPRING, LOADED)
    made = {
        count: load(SPRING, LOADED | {"element.section_model": "fibres", "element.fibres": count}) for count in counts
    }
    exact = strokes(made[counts[-1]], made[counts[-1]].system, "c")()

    def error(stroke: float) -> float:
        return abs(stroke - exact) / exact

    runs = [Candidate("surface", strokes(surface, surface.system, "c"), error)]
    runs += [Candidate("fibres", strokes(one, one.system, "c"), error, setting=count) for count, one in made.items()]
    note = f"{surface.duration / STEP:.0f} steps; setting: fibres. Error: to the most fibres. Ratio to the surface."
    return [
        Table(
            "Fibres over the section of a coil, c", rows_of(measure(runs, options.repeats, "surface"), "ms", 1e3), note
        )
    ]
