"""Packaged learning tasks, each with a scenario of `scenarios/`.

A task and its scenario never change under a versioned name, so that results on `martensite/Wire-v0` stay comparable.
Temperature limits of finger and platform, whose materials have none, are assumed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from itertools import product
from pathlib import Path
from typing import Any, cast

from martensite.base.errors import InputError, require_known
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.export.learning_task import LearningTask
from martensite.scenario.scenario import load

FOLDER = Path(__file__).parent / "scenarios"
JOINTS = tuple("_".join(words) for words in product(("thumb", "index", "middle"), ("proximal", "distal")))
TENDONS = tuple("_".join(words) for words in product(JOINTS, ("flexor", "extensor")))
VERTICES = ("first", "second", "third")
TASKS: dict[str, LearningTask] = {
    "finger": LearningTask(
        output="angle",
        low=0.0,
        high=math.radians(70.0),
        duration=10.0,
        preview=(0.5,),
        signals={"drive": (0.0, 3.0)},
        spreads={"element.diameter": 0.02, "environment.temperature": 3.0},
        energy_weight=0.01,
        temperature_limit=390.0,
    ),
    "hand": LearningTask(
        output=JOINTS,
        low=0.0,
        high=math.radians(70.0),
        duration=20.0,
        preview=(0.5,),
        signals=dict.fromkeys(TENDONS, (0.0, 3.0)),
        spreads={f"{name}.element.strand.diameter": 0.02 for name in TENDONS},
        energy_weight=0.01,
    ),
    "platform": LearningTask(
        output=("alpha", "beta"),
        low=-math.radians(10.0),
        high=math.radians(10.0),
        duration=40.0,
        preview=(1.0,),
        signals=dict.fromkeys(VERTICES, (0.0, 5.0)),
        spreads={f"{name}.element.diameter": 0.02 for name in VERTICES},
        energy_weight=0.01,
        temperature_limit=355.0,
    ),
    "wire": LearningTask(
        output="position",
        low=0.0,
        high=4e-3,
        duration=12.0,
        preview=(0.5,),
        signals={"drive": (0.0, 0.9)},
        spreads={"element.diameter": 0.03, "environment.temperature": 5.0, "source.supply": 0.05},
        energy_weight=0.01,
    ),
}
"""Tasks by name of their scenario."""


def load_bench(name: str) -> Bench:
    """Return the bench of a packaged task, without controller and guard: overheating is part of the task."""
    require_known("packaged task", name, TASKS)
    bench = cast(Bench, load(FOLDER / f"{name}.toml").bench)
    return bench.with_parts(controllers=Controllers(), supervisor=None)


def find_bench(bench: Bench | str, task: LearningTask | Mapping[str, Any] | None) -> tuple[Bench, LearningTask]:
    """Return bench and task, each given or packaged.

    Args:
        bench: a bench, or the name of a packaged task.
        task: a task; for a packaged task None, or changed fields.
    """
    if isinstance(task, LearningTask):
        return load_bench(bench) if isinstance(bench, str) else bench, task
    if not isinstance(bench, str):
        raise InputError("Your own bench needs a `task`, a `LearningTask`.")
    for name in task or {}:
        require_known("field of a task", name, [one.name for one in fields(LearningTask)])
    return load_bench(bench), replace(TASKS[bench], **(task or {}))
