"""The job of a sweep: made anew in every process from what is in the store."""

from __future__ import annotations

import hashlib
import json
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from martensite.base.errors import InputError, MartensiteError, UnknownNameError
from martensite.base.registry import import_modules
from martensite.design.backends.base import Report, StoppedError
from martensite.design.sampling.base import design
from martensite.design.sweep.axes import axis
from martensite.design.sweep.differing import differing
from martensite.design.sweep.plan import CHUNK, Piece, Plan, Trace
from martensite.design.sweep.salvage import kept
from martensite.design.sweep.store import Store
from martensite.design.sweep.subject import course_of, targets_of, waveforms_of
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.simulate.measures.base import parse_measure

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
    """Longest of equal steps [s]; None for runs to the tolerance of the scenario."""
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

    @classmethod
    def of_spec(cls, spec: Mapping[str, Any]) -> Wanted:
        """What the spec of a store says of it, among other things."""
        return cls.from_dict({name: spec[name] for name in cls.__dataclass_fields__})


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
            raise UnknownNameError("output", name, outputs)
    return Plan(
        course,
        tuple(axis(words, targets) for words in wanted.over),
        design(wanted.sample, wanted.seed),
        {words: parse_measure(words) for words in wanted.measures},
        tuple(Trace(*one) for one in wanted.traces),
        wanted.chunk,
    )


def prepared(scenario: Scenario, wanted: Wanted) -> tuple[Plan, Wanted]:
    """The plan with its runtime chosen, and what was asked for with its step and its runtime in it.

    Raises:
        InputError: something that was asked for is wrong; measures are tried on an empty run.
    """
    plan = plan_of(scenario, wanted)
    plan.lost(range(1))
    return plan, replace(wanted, step=plan.course.step, runtime=plan.course.runtime)


def spec_of(scenario: Scenario, wanted: Wanted, modules: Sequence[str] = ()) -> dict[str, Any]:
    """All that is needed to make any chunk anywhere.

    `numbers` stands for those of the system and its signals: so that a file that the scenario
    names, and that has changed or is another elsewhere, does not go unnoticed.
    """
    folder = scenario.path.parent.resolve() if scenario.path else Path.cwd()
    return {
        "scenario": scenario.text, "title": scenario.title, "folder": str(folder),
        "modules": [_anywhere(name) for name in modules], "version": version("martensite"),
        "numbers": _numbers(scenario), **wanted.to_dict(),
    }  # fmt: skip


def _anywhere(module: str) -> str:
    """A module that is a file by its whole path."""
    return str(Path(module).resolve()) if module.endswith(".py") else module


def _numbers(scenario: Scenario) -> str:
    """A digest of all numbers of a scenario, and of its signals at the samples."""
    waves = waveforms_of(scenario)
    last = min(scenario.samples, 10_001) - 1
    times = [scenario.duration * k / last for k in range(last + 1)]
    told = [(leaf.path, leaf.value) for leaf in scenario.whole.leaves()]
    played = [(name, wave.signals(times)) for name, wave in waves.items()]
    return hashlib.sha256(repr((told, played)).encode()).hexdigest()


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
        piece, remarks = kept(self, chunk, self.compute)
        report = self.store(chunk, piece, remarks)
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
    try:
        return _remade(json.loads(spec))
    except MartensiteError as error:  # some have arguments with which they cannot travel
        raise StoppedError(f"A process cannot make this sweep: {error}") from None


def _remade(spec: Mapping[str, Any]) -> Plan:
    """The plan of a specification.

    Raises:
        InputError: this process has other files, or another version of the package.
    """
    import_modules(spec["modules"])
    scenario = read_scenario(spec["scenario"], Path(spec["folder"]) / "scenario.toml")
    wanted = Wanted.of_spec(spec)
    apart = differing(spec, spec_of(scenario, wanted))
    if apart:
        raise InputError(f"It is another one here: {'; '.join(apart)}.")
    return plan_of(scenario, wanted)
