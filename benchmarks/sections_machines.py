"""The section of the benchmark on mechanisms: what coordinates and several elements cost.

What: a wire of `examples/antagonistic_wires.toml` heated by one trapezoid, in fixed steps: on a
bias spring (a load line in closed form), on a finger with and without inertia (one coordinate),
and on a pulley against its like. Every run is judged by itself in a sixteenth of the step.
"""

from __future__ import annotations

from typing import Any, cast

from benchmarks.harness import Candidate, measure
from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.sections import Options, rows_of, section
from martensite.actuators.assembly import AbstractSystem, Machine, System
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.finger import Finger
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.scenario.scenario import load
from martensite.simulate.api import simulate

EXAMPLE = ROOT / "examples/antagonistic_wires.toml"
STEP, DURATION = 0.02, 20.0  # [s]
RUNTIMES = ("floats", "c")
FINE = 16
GEOMETRY = {"offset": 3.5e-3, "bracket": 10.6e-3, "stiffness": 50.0, "arm": 6e-3, "extension": 1e-3}


def systems() -> dict[str, AbstractSystem]:
    """The same wire on each mechanism."""
    pulley = cast("Machine", load(EXAMPLE).system)
    wire = next(iter(pulley.actuators().values()))

    def on(mechanism: AbstractMechanism) -> System:
        return System(mechanism=mechanism, **wire.__dict__)

    return {
        "bias-spring": on(BiasSpring(stiffness=50.0, preload=0.3)),
        "finger": on(Finger(**GEOMETRY)),
        "finger, dynamic": on(Finger(motion="dynamic", inertia=1.8e-5, damping=1e-4, **GEOMETRY)),
        "pulley": pulley,
    }


def strokes(system: AbstractSystem, runtime: str, step: float = STEP) -> Any:
    """A function that runs a system, its first wire heated, and returns its stroke."""
    heated = load(EXAMPLE).waveform["protagonist"]  # type: ignore[index]
    drives = {system.drives()[0].name: heated}

    def run() -> float:
        return simulate(system, drives, DURATION, step=step, samples=101, runtime=runtime).stroke

    return run


@section
def machines(options: Options) -> list[Table]:
    """Mechanisms beside a load line; the first call, which compiles, is not timed."""
    tables = []
    for runtime in RUNTIMES:
        runs: list[Candidate] = []
        for name, system in systems().items():
            exact = strokes(system, runtime, STEP / FINE)()

            def error(stroke: float, exact: float = exact) -> float:
                return abs(stroke - exact) / exact

            runs.append(Candidate(name, strokes(system, runtime), error))
        rows = rows_of(measure(runs, options.repeats, "bias-spring"), "ms", 1e3)
        note = f"{DURATION / STEP:.0f} steps. Ratio to the wire on a bias spring."
        tables.append(Table(f"Mechanisms, {runtime}", rows, note))
    return tables
