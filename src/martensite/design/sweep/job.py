"""Job of a sweep, which every process restores from the store."""

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

from martensite.base.errors import InputError, MartensiteError, StoppedError, require_known
from martensite.base.registry import import_modules
from martensite.design.sweep.axes import parse_axis
from martensite.design.sweep.backends.base import Report, keep_runs
from martensite.design.sweep.plan import CHUNK, SweepPiece, SweepPlan, SweepTrace
from martensite.design.sweep.sampling.samples import parse_sampling
from martensite.design.sweep.store import Store, list_differences
from martensite.design.sweep.subject import build_course, list_waveforms
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.scenario.targets import list_targets
from martensite.simulate.measures.base import parse_measure

MEASURES = ("stroke", "max(temperature)", "max(stress)", "energy")
"""Default measures of a run."""


@dataclass(frozen=True)
class SweepRequest:
    """Request for a sweep, in words."""

    over: tuple[str, ...]
    """Axes, such as `diameter=0.1..0.5 mm:9`."""
    sample: str = "grid"
    """grid, or another design with a number of runs, such as `sobol:1024`."""
    measures: tuple[str, ...] = MEASURES
    traces: tuple[tuple[str, int], ...] = ()
    """Stored outputs over time, with their numbers of samples."""
    seed: int = 0
    chunk: int = CHUNK
    step: float | None = None
    """Longest of equal steps [s]; None for runs to the tolerance of the scenario."""
    runtime: str | None = None
    precision: str = "float64"

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    @classmethod
    def of_spec(cls, spec: Mapping[str, Any]) -> SweepRequest:
        """Return the request from the specification of a store."""
        own: dict[str, Any] = {name: spec[name] for name in cls.__dataclass_fields__}
        own |= {"over": tuple(own["over"]), "measures": tuple(own["measures"])}
        own["traces"] = tuple((str(name), int(count)) for name, count in own["traces"])
        return cls(**own)


def build_plan(scenario: Scenario, wanted: SweepRequest) -> SweepPlan:
    """Return the plan of a sweep of a scenario.

    Raises:
        InputError: an axis, a measure, an output or a design is invalid.
    """
    targets = list_targets(scenario)
    course = build_course(scenario, wanted.step, wanted.runtime, wanted.precision)
    outputs = course.system.outputs()
    for name, _ in wanted.traces:
        require_known("output", name, outputs)
    return SweepPlan(
        course,
        tuple(parse_axis(words, targets) for words in wanted.over),
        parse_sampling(wanted.sample, wanted.seed),
        {words: parse_measure(words) for words in wanted.measures},
        tuple(SweepTrace(*one) for one in wanted.traces),
        wanted.chunk,
    )


def prepare_plan(scenario: Scenario, wanted: SweepRequest) -> tuple[SweepPlan, SweepRequest]:
    """Return the plan, and the request completed with step and runtime.

    Raises:
        InputError: the request is invalid; measures are tried on an empty run.
    """
    plan = build_plan(scenario, wanted)
    plan.try_measures()
    return plan, replace(wanted, step=plan.course.step, runtime=plan.course.runtime)


def build_spec(scenario: Scenario, wanted: SweepRequest, modules: Sequence[str] = ()) -> dict[str, Any]:
    """Return the specification of a sweep, from which any process can compute its chunks.

    `numbers` is a digest of the system and its signals, which reveals changed files.
    """
    folder = scenario.path.parent.resolve() if scenario.path else Path.cwd()
    return {
        "scenario": scenario.text,
        "title": scenario.title,
        "folder": str(folder),
        "modules": [str(Path(one).resolve()) if one.endswith(".py") else one for one in modules],
        "version": version("martensite"),
        "numbers": _digest_numbers(scenario),
        **wanted.to_dict(),
    }


def _digest_numbers(scenario: Scenario) -> str:
    """Return a digest of all numbers of a scenario and of its signals at the samples."""
    waves = list_waveforms(scenario)
    last = min(scenario.samples, 10_001) - 1
    times = [scenario.duration * k / last for k in range(last + 1)]
    numbers = [(leaf.path, leaf.value) for leaf in scenario.whole.leaves()]
    played = [(name, wave.signals(times)) for name, wave in waves.items()]
    return hashlib.sha256(repr((numbers, played)).encode()).hexdigest()


@dataclass(frozen=True)
class SweepJob:
    """Computes and stores the chunks of a sweep."""

    path: Path
    spec: str = field(repr=False)
    """Specification as JSON."""

    @property
    def plan(self) -> SweepPlan:
        """Return the plan, restored once in every process."""
        return _restore_plan(self.spec)

    def __call__(self, chunk: int) -> Report:
        """Compute a chunk and store it."""
        begin = time.process_time()
        piece, remarks = keep_runs(self, chunk, self.compute)
        report = self.store(chunk, piece, remarks)
        return replace(report, seconds=time.process_time() - begin)

    def rows(self, chunk: int) -> range:
        """Return the runs of a chunk."""
        return self.plan.rows(chunk)

    def compute(self, rows: range) -> SweepPiece:
        """Compute some runs."""
        return self.plan.compute(rows)

    def make_lost_piece(self, rows: range) -> SweepPiece:
        """Return the placeholder for lost runs."""
        return self.plan.make_lost_piece(rows)

    def store(self, chunk: int, piece: SweepPiece, remarks: tuple[str, ...] = ()) -> Report:
        """Store a chunk."""
        names = [one.target.name for one in self.plan.axes]
        Store(self.path).write(chunk, self.rows(chunk), piece, names)
        return Report(chunk, dict(Counter(piece.status.tolist())), remarks=remarks)


@lru_cache(maxsize=4)
def _restore_plan(spec: str) -> SweepPlan:
    try:
        return _rebuild_plan(json.loads(spec))
    except MartensiteError as error:  # some cannot be pickled
        raise StoppedError(f"A process cannot make this sweep: {error}") from None


def _rebuild_plan(spec: Mapping[str, Any]) -> SweepPlan:
    """Return the plan of a specification.

    Raises:
        InputError: this process has other files, or another version of the package.
    """
    import_modules(spec["modules"])
    scenario = read_scenario(spec["scenario"], Path(spec["folder"]) / "scenario.toml")
    wanted = SweepRequest.of_spec(spec)
    apart = list_differences(spec, build_spec(scenario, wanted))
    if apart:
        raise InputError(f"It is another one here: {'; '.join(apart)}.")
    return build_plan(scenario, wanted)
