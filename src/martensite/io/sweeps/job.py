"""The job of a sweep: made anew in every process from what is in the store."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from martensite.io.scenario import Scenario, read
from martensite.io.sweeps.store import Store
from martensite.io.sweeps.subject import course_of, settled, targets_of
from martensite.simulate.measures.base import measure
from martensite.sweep.axes import axis
from martensite.sweep.backends.base import Report
from martensite.sweep.designs.base import design
from martensite.sweep.plan import CHUNK, Piece, Plan, Trace

MEASURES = ("stroke", "max(temperature)", "max(stress)", "energy")
"""What is kept of every run, unless chosen."""


@dataclass(frozen=True)
class Wanted:
    """What is asked of a sweep, in words."""

    over: tuple[str, ...]
    """Axes, such as `diameter=0.1..0.5 mm:9`."""
    sample: str = "grid"
    """grid, or another design with a number of runs, such as `sobol:1024`."""
    measures: tuple[str, ...] = MEASURES
    traces: tuple[tuple[str, int], ...] = ()
    """Outputs that are kept over time, and at how many samples."""
    seed: int = 0
    chunk: int = CHUNK
    step: float | None = None
    """Longest step [s]; None until it is chosen."""
    runtime: str | None = None
    precision: str = "float64"

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    @classmethod
    def from_dict(cls, known: Mapping[str, Any]) -> Wanted:
        """From JSON."""
        lists = {"over": tuple(known["over"]), "measures": tuple(known["measures"])}
        traces = tuple((str(name), int(count)) for name, count in known["traces"])
        return cls(**{**known, **lists, "traces": traces})


def plan_of(scenario: Scenario, wanted: Wanted) -> Plan:
    """The plan of a sweep of a scenario.

    Raises:
        InputError: an axis, a measure, an output or a design is wrong.
    """
    targets = targets_of(scenario)
    course = course_of(scenario, wanted.step, wanted.runtime, wanted.precision)
    outputs = course.system.outputs()
    for name, _ in wanted.traces:
        if name not in outputs:
            from martensite.errors import UnknownNameError

            raise UnknownNameError("output", name, outputs)
    return Plan(
        course, tuple(axis(words, targets) for words in wanted.over),
        design(wanted.sample, wanted.seed), {words: measure(words) for words in wanted.measures},
        tuple(Trace(*one) for one in wanted.traces), wanted.chunk,
    )  # fmt: skip


def prepared(scenario: Scenario, wanted: Wanted) -> tuple[Plan, Wanted]:
    """The plan with its step and its runtime chosen, and what was asked for with both in it."""
    plan = plan_of(scenario, wanted)
    step = wanted.step or settled(scenario, plan)
    chosen = replace(wanted, step=step, runtime=plan.course.runtime)
    return replace(plan, course=replace(plan.course, step=step)), chosen


def spec_of(scenario: Scenario, wanted: Wanted, modules: Sequence[str] = ()) -> dict[str, Any]:
    """All that is needed to make any chunk anywhere."""
    folder = scenario.path.parent.resolve() if scenario.path else Path.cwd()
    return {
        "scenario": scenario.text, "title": scenario.title, "folder": str(folder),
        "modules": list(modules), **wanted.to_dict(),
    }  # fmt: skip


@dataclass(frozen=True)
class SweepJob:
    """Makes chunks of the sweep in a store."""

    path: Path
    spec: str = field(repr=False)
    """What was asked for, as JSON."""

    @property
    def plan(self) -> Plan:
        """The plan, made once in every process."""
        return _plan(self.spec)

    def __call__(self, chunk: int) -> Report:
        """Make a chunk and store it."""
        begin = time.process_time()
        piece = self.compute(self.rows(chunk))
        report = self.store(chunk, piece)
        return replace(report, seconds=time.process_time() - begin)

    def rows(self, chunk: int) -> range:
        """The runs of a chunk."""
        return self.plan.rows(chunk)

    def compute(self, rows: range) -> Piece:
        """Make some runs."""
        return self.plan.compute(rows)

    def lost(self, rows: range) -> Piece:
        """What stands for runs that cannot be made."""
        return self.plan.lost(rows)

    def store(self, chunk: int, piece: Piece, remarks: tuple[str, ...] = ()) -> Report:
        """Store a chunk."""
        names = [one.target.name for one in self.plan.axes]
        Store(self.path).write(chunk, self.rows(chunk), piece, names)
        return Report(chunk, dict(Counter(piece.status.tolist())), remarks=remarks)


@lru_cache(maxsize=4)
def _plan(spec: str) -> Plan:
    known = json.loads(spec)
    imported(known.pop("modules"))
    folder, text = Path(known.pop("folder")), known.pop("scenario")
    known.pop("title")
    scenario = read(text, folder / "scenario.toml")
    return plan_of(scenario, Wanted.from_dict(known))


def imported(modules: Sequence[str]) -> None:
    """Import what registers parts of the user's own, by dotted name or by file."""
    import sys
    from importlib import import_module

    for name in modules:
        path = Path(name)
        sys.path.insert(0, str(path.parent if path.suffix == ".py" else Path()))
        import_module(path.stem if path.suffix == ".py" else name)
        sys.path.pop(0)
