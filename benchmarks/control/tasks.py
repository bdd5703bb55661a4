"""Tasks of the benchmark: a plant with its sensors, what it shall follow, and from when on it is judged.

Plants are scenarios without a controller, in `plants/`; tasks stand in `tasks/`. A task is the same for every entry, on
every machine: the noise of a sensor on a wire is of a seed that follows from the task and the number of the wire.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.wires import SEED
from martensite.base import units
from martensite.base.errors import UnknownNameError
from martensite.control.faults.base import AbstractFault
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import JITTER, NOISE
from martensite.control.loop.parts import Controllers
from martensite.scenario.scenario import read_scenario
from martensite.signals.base import AbstractWaveform
from martensite.signals.sine import Sine

Numbers = NDArray[np.float64]
FOLDER = Path(__file__).parent
FOLLOWED = "followed"
"""What the sensor of every plant is called whose reading shall follow the reference."""
DISTURBANCE = "disturbance"
ZERO = {"wire": "0 mm", "pair": "0 deg", "finger": "0 deg"}
"""Nothing to follow, in the unit of what is followed on a plant."""
SETTLED = 0.05
"""Share of the span within which an output has settled."""
TASKS, TRAINING = "tasks", "training"  # and `hours`: see `guard_runs`
"""Folders of tasks, and of those on which entries are tuned: no task of the benchmark is among them."""


@dataclass(frozen=True, eq=False)
class BenchmarkTask:
    """What an entry shall do; all numbers in SI."""

    name: str
    title: str
    plant: str
    """Name of the plant."""
    output: str
    """True output that shall follow the reference."""
    low: float
    high: float
    """Ends of the span asked for."""
    duration: float
    judged_from: float
    """When the wire is warm: errors count from here on [s]."""
    reference: AbstractWaveform
    jumps: bool
    """Whether it begins with a jump."""
    disturbance: Mapping[str, Any] | None
    """A fault that belongs to the task, as in a scenario."""

    @property
    def span(self) -> float:
        """What errors are shares of."""
        return self.high - self.low

    @property
    def repetition(self) -> float:
        """Time after which it repeats; what does not repeat is a repetition that is longer than the run [s]."""
        return 1.0 / self.reference.frequency if isinstance(self.reference, Sine) else 1.1 * self.duration

    @property
    def overshoots(self) -> bool:
        """Whether the reference jumps, so that an output can go beyond it."""
        return self.jumps or any(self._jumps(time) for time in self.reference.edges(self.duration))

    def build_disturbance(self) -> AbstractFault:
        """The fault that belongs to the task."""
        sections = _place_controllers(self.plant, {"kind": "constant", "level": ZERO[self.plant]})
        sections["faults.disturbance"] = dict(self.disturbance or {})
        bench = cast(Bench, read_scenario(read_plant(self.plant), None, sections).bench)
        return bench.faults.members()["disturbance"]

    def list_events(self) -> list[float]:
        """When something jumps, so that an output must settle anew [s]."""
        edges = [time for time in self.reference.edges(self.duration) if self._jumps(time)]
        given = self.disturbance or {}
        known = [units.parse_quantity(given[key], "s") for key in ("start", "end") if key in given]
        return sorted({0.0, *edges, *known})

    def _jumps(self, time: float) -> bool:
        return abs(self.reference.value(time) - self.reference.value(time - 1e-6)) > 0.01 * self.span


def read_plant(name: str) -> str:
    """The text of the scenario of a plant."""
    return (FOLDER / "plants" / f"{name}.toml").read_text(encoding="utf-8")


@cache
def load_plant(name: str) -> Bench:
    """A plant with its sensors: a bench on which nobody has the drives."""
    wave = {"kind": "constant", "level": ZERO[name]}
    bench = cast(Bench, read_scenario(read_plant(name), None, _place_controllers(name, wave)).bench)
    return bench.with_parts(controllers=Controllers())


def list_plant_drives(name: str) -> tuple[str, ...]:
    """Drives of a plant; the second of two pulls against the first."""
    return ("protagonist", "antagonist") if name == "pair" else ("drive",)


def _place_controllers(plant: str, wave: Mapping[str, Any]) -> dict[str, Any]:
    """Sections of a scenario that put a proportional controller at every drive."""
    drives = list_plant_drives(plant)
    found: dict[str, Any] = {f"controllers.{name}": {"kind": "pid", "measured": FOLLOWED, "Kp": 1.0} for name in drives}
    return found | {f"references.{name}": dict(wave) for name in drives}


@cache
def load_tasks(folder: str = TASKS) -> dict[str, BenchmarkTask]:
    """All tasks by name, in their order."""
    found = [_read_task(path) for path in sorted((FOLDER / folder).glob("*.toml"))]
    return {one.name: one for one in sorted(found, key=lambda one: (ORDER.index(one.plant), one.name))}


ORDER = ("wire", "pair", "finger")
"""Plants in their order."""


def find_task(name: str) -> BenchmarkTask:
    """A task by name; `UnknownNameError` if there is none."""
    tasks = load_tasks()
    if name not in tasks:
        raise UnknownNameError("task", name, tasks)
    return tasks[name]


def _read_task(path: Path) -> BenchmarkTask:
    given = tomllib.loads(path.read_text(encoding="utf-8"))
    plant = given["plant"]
    sections = _place_controllers(plant, given["reference"])
    scenario = read_scenario(read_plant(plant), None, sections)
    bench = cast(Bench, scenario.bench)
    output = bench.sensors.members()[FOLLOWED].sees()[0]
    unit = bench.plant.outputs()[output].unit
    first = next(iter(bench.controllers.members().values()))
    return BenchmarkTask(
        name=path.stem,
        title=given["title"],
        plant=plant,
        output=output,
        low=units.parse_quantity(given["low"], unit),
        high=units.parse_quantity(given["high"], unit),
        duration=units.parse_quantity(given["duration"], "s") if "duration" in given else scenario.duration,
        judged_from=units.parse_quantity(given["judged_from"], "s"),
        reference=first.reference,
        jumps=given["reference"]["kind"] == "constant",
        disturbance=given.get(DISTURBANCE),
    )


def draw_noise(bench: Bench, task: str, wires: int, steps: int, seed: int = SEED) -> tuple[list[str], Numbers]:
    """Drives of a bench that are noise, and standard normal numbers for them, shape (steps, drives, wires).

    Those of a wire are the same however many there are, and whoever controls it.
    """
    names = [drive.name for drive in bench.drives() if drive.name.startswith((NOISE, JITTER))]
    label = int.from_bytes(task.encode()[:6].ljust(6), "big")
    held = [] if seed == SEED else [seed]
    rows = [np.random.default_rng([label, k, *held]).standard_normal((steps, len(names))) for k in range(wires)]
    return names, np.stack(rows, axis=-1)
