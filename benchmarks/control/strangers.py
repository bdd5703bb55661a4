"""Controllers of others: a Python class, a function in C, or an agent that has learned.

    --controller mine.py:MyController       a class, or an object, of one of two sorts:
        a controller as in the how-to on parts of one's own (`AbstractController`): it runs in C with the plant;
        an agent with `predict(observations)`, as those of Stable-Baselines3: actions for all wires at once
    --controller mine.c                     a function
        void control_step(double *memory, double reference, const double *readings, double dt, double *signals);

Readings of a function come in the order of the sensors of the plant (`list_readings`), `memory` has `MEMORY` numbers
that are 0 at first, `signals` is one duty per drive. It is compiled, and called once per period and wire. A comment
`plants: wire, finger` in the file limits the plants, else the function runs on all plants.

Observations of an agent are `[reading, reference, reference in 0.5 s]`, with -1 at the lower and 1 at the upper end of
what is asked for on the plant, cut at ±2; actions from -1 to 1 are duties from 0 to 1, one per drive. That is what
`build_learning_bench` trains on. If it has a method `reset(wires)`, it is called before every run.
"""

from __future__ import annotations

import ctypes
import importlib.util
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.competition import EntryRuns
from benchmarks.control.entries import read_entry
from benchmarks.control.runs import NO_FAULT, PlantRuns
from benchmarks.control.tasks import FOLLOWED, ORDER, BenchmarkTask, list_plant_drives, load_plant, load_tasks
from benchmarks.control.wires import SEED, draw_wires
from martensite.base.errors import InputError, suggest_name
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import MEASURED
from martensite.kernels.compiler import load_library

Numbers = NDArray[np.float64]
MEMORY = 64
"""Numbers that a function in C may remember."""
AHEAD, BOUND = 0.5, 2.0
"""How far ahead an agent sees the reference [s], and the bound of what it sees."""
WRAPPER = """
void control_step(double *memory, double reference, const double *readings, double dt, double *signals);
void control_all(long wires, long many, long drives, double *memory, const double *references,
                 const double *readings, const double *dt, double *signals) {
  for (long k = 0; k < wires; k++)
    control_step(memory + %(memory)d * k, references[k], readings + many * k, dt[0], signals + drives * k);
}
"""


def list_readings(plant: str) -> list[str]:
    """Readings in the order in which a function gets them."""
    return list(load_plant(plant).sensors.members())


def find_range(plant: str) -> tuple[float, float]:
    """Lowest and highest reference that a task asks for on a plant."""
    own = [one for one in load_tasks().values() if one.plant == plant]
    return min(one.low for one in own), max(one.high for one in own)


class OutsideRuns(PlantRuns):
    """Runs whose drives somebody has who is called in every period."""

    answer: Any
    """Called with periods gone, references (lanes,), readings (readings, lanes); gives signals (drives, lanes)."""
    restart: Any

    def run(self, fault: str = NO_FAULT) -> dict[str, Numbers]:
        """Outcomes of every lane under a fault, by measure."""
        self.begin(fault)
        self.restart(self.lanes.lanes)
        drives = [self.lanes.drives.index(name) for name in list_plant_drives(self.tasks[0].plant)]
        read = [self.lanes.names.index(MEASURED + name) for name in self.bench.sensors.members()]
        wanted = np.repeat(self.reference, self.wires, axis=0).T
        rows, parts = self.lanes.observe(self.signals[0]), list[Numbers]()
        kept: list[dict[str, Numbers]] = []
        for k in range(self.steps):
            given = self.signals[k + 1].copy()
            given[drives] = np.clip(self.answer(k, wanted[k], rows[read]), 0.0, 1.0)
            rows = self.lanes.advance(given[None], self.bench.period)[0]
            parts.append(rows)
            if len(parts) == 100 or k == self.steps - 1:
                kept.append(self.keep(np.stack(parts)))
                parts.clear()
        return self.judge({name: np.concatenate([one[name] for one in kept]) for name in kept[0]})


class CompiledStranger:
    """A function in C."""

    plants = ORDER

    def __init__(self, path: Path) -> None:
        """Compile a file.

        Raises:
            CompileError: there is no compiler, or it does not like the file.
            InputError: the file has no function `control_step`.
        """
        source = path.read_text(encoding="utf-8")
        if "control_step" not in source:
            raise InputError(f"`{path}` has no function `control_step`.")
        self.name, self.title = path.stem, f"C: {path.name}"
        named = re.search(r"plants: *([a-z, ]+)", source)
        self.plants = tuple(one for one in ORDER if named is None or one in named[1])
        self._library = load_library(source + WRAPPER % {"memory": MEMORY})

    def prepare_runs(self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool, seed: int = SEED) -> PlantRuns:
        """Its runs on one plant."""
        bench = load_plant(tasks[0].plant)
        runs = OutsideRuns(bench, tasks, draw_wires(bench, wires, seed), faulty=faulty, seed=seed)
        lanes, drives = runs.lanes.lanes, len(list_plant_drives(tasks[0].plant))
        memory, signals, dt = np.zeros((lanes, MEMORY)), np.zeros((lanes, drives)), np.zeros(1)

        def restart(_: int) -> None:
            memory[:], signals[:] = 0.0, 0.0

        def answer(k: int, reference: Numbers, readings: Numbers) -> Numbers:
            dt[0] = bench.period if k else 0.0
            rows, wanted = np.ascontiguousarray(readings.T), np.ascontiguousarray(reference)
            arrays = (memory, wanted, rows, dt, signals)
            counts = (ctypes.c_long(lanes), ctypes.c_long(rows.shape[1]), ctypes.c_long(drives))
            self._library.control_all(*counts, *(ctypes.c_void_p(one.ctypes.data) for one in arrays))
            return np.nan_to_num(signals.T)

        runs.restart, runs.answer = restart, answer
        return runs


class AgentStranger:
    """An agent with `predict`."""

    plants = ORDER

    def __init__(self, agent: Any, name: str) -> None:
        self.agent, self.name, self.title = agent, name, f"agent: {name}"
        self.plants = tuple(getattr(agent, "plants", ORDER))

    def prepare_runs(self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool, seed: int = SEED) -> PlantRuns:
        """Its runs on one plant."""
        plant = tasks[0].plant
        bench, (low, high) = load_plant(plant), find_range(plant)
        runs = OutsideRuns(bench, tasks, draw_wires(bench, wires, seed), faulty=faulty, seed=seed)
        followed, ahead = list_readings(plant).index(FOLLOWED), round(AHEAD / bench.period)
        later = np.repeat(runs.reference[:, np.minimum(np.arange(runs.steps) + ahead, runs.steps)], wires, axis=0).T

        def answer(k: int, reference: Numbers, readings: Numbers) -> Numbers:
            seen = 2.0 * (np.stack([readings[followed], reference, later[k]], axis=-1) - low) / (high - low) - 1.0
            found = self.agent.predict(np.clip(seen, -BOUND, BOUND).astype(np.float32))
            action = np.asarray(found[0] if isinstance(found, tuple) else found, float)
            return 0.5 * (np.clip(action.reshape(runs.lanes.lanes, -1).T, -1.0, 1.0) + 1.0)

        runs.restart, runs.answer = getattr(self.agent, "reset", lambda _: None), answer
        return runs


class KernelStranger:
    """A controller as a part of one's own: a kernel, in C with the plant."""

    def __init__(self, controller: Any, name: str) -> None:
        self.controller, self.name, self.title = controller, name, f"Python: {name}"
        self.plants = tuple(getattr(controller, "plants", ("wire", "finger")))

    def prepare_runs(self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool, seed: int = SEED) -> PlantRuns:
        """Its runs on one plant."""
        plant = tasks[0].plant
        kind = self.controller if isinstance(self.controller, type) else None
        build = kind or (lambda **_: self.controller)
        bench = load_plant(plant)
        made = {name: build(measured=FOLLOWED, **_follow_nothing()) for name in list_plant_drives(plant)}
        bench = bench.with_parts(controllers=type(bench.controllers)(**made))
        return PlantRuns(bench, tasks, draw_wires(bench, wires, seed), faulty=faulty, seed=seed)


def _follow_nothing() -> Mapping[str, Any]:
    from martensite.signals.constant import Constant

    return {"reference": Constant(level=0.0)}


def read_stranger(text: str) -> Any:
    """Whoever `--controller` names.

    Raises:
        InputError: there is no such file or name in it, or it is none of what can take part.
    """
    place, _, name = text.partition(":") if not Path(text).exists() else (text, "", "")
    path = Path(place)
    if not path.is_file():
        raise InputError(f"There is no file `{path}` with a controller; write FILE.py:NAME, FILE.c or FILE.toml.")
    if path.suffix == ".c":
        return CompiledStranger(path)
    if path.suffix == ".toml":
        return EntryRuns(read_entry(path))
    return _read_object(path, name)


def _read_object(path: Path, name: str) -> Any:
    spec = importlib.util.spec_from_file_location(f"martensite_stranger_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"`{path}` is no Python file; write FILE.py:NAME, FILE.c or FILE.toml.")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    known = [one for one in vars(module) if not one.startswith("_")]
    if name not in known:
        raise InputError(f"`{path}` has no `{name}`. {suggest_name(name, known)}")
    found = getattr(module, name)
    kernel = issubclass(found, AbstractController) if isinstance(found, type) else isinstance(found, AbstractController)
    if kernel:
        return KernelStranger(found, name)
    agent = found() if isinstance(found, type) else found
    if not callable(getattr(agent, "predict", None)):
        raise InputError(f"`{name}` of `{path}` is neither a controller nor an agent with `predict(observations)`.")
    return AgentStranger(agent, name)


def build_learning_bench(plant: str = "wire") -> tuple[Bench, Any]:
    """A bench and a task to train an agent on that will see here what it saw there; for `SmaEnv(*…)`."""
    from martensite.export.learning_task import LearningTask

    low, high = find_range(plant)
    some = next(one for one in load_tasks().values() if one.plant == plant)
    task = LearningTask(
        output=some.output,
        low=low,
        high=high,
        duration=some.duration,
        observed={FOLLOWED: (low, high)},
        preview=(AHEAD,),
        signals=dict.fromkeys(list_plant_drives(plant), (0.0, 1.0)),
        spreads={"element.diameter": 0.02, "environment.temperature": 5.0} if plant != "pair" else {},
    )
    return load_plant(plant), task
