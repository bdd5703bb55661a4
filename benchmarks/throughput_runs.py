"""Many runs of one system for the section `throughput`: lanes of C, or one by one.

What: the coupled wire of problem A (60 s in steps of 20 ms) and the finger of
`examples/finger.toml` with each of its laws (25 s in steps of 20 ms), around their nominal
parameters. Of every run its stroke is kept, and of the first few all samples, so that memory does
not grow with the number of runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from benchmarks import ours
from benchmarks.inputs import Drive, sine
from benchmarks.problem_a import Wire, parameter_sets
from benchmarks.process import ROOT
from martensite.kernels.c99_lanes import BLOCK
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.drive_waveforms import grid_of
from martensite.simulate.grid import TimeGrid
from martensite.simulate.native import march_lanes

LANES = 64
STEP = 0.02  # [s]
KEPT = 4
LAWS = ("mas-hybrid", "mas", "mas-polycrystal")
VARIED = {"element.diameter": 0.02, "element.length": 0.005, "environment.cooling.h": 0.1, "mechanism.stiffness": 0.1}


class Case(NamedTuple):
    """A system and as many parameter sets as the largest batch has."""

    name: str
    compiled: CompiledMarch
    values: Sequence[Any]
    grid: TimeGrid
    output: str

    @property
    def place(self) -> int:
        """Column of the output that is kept."""
        return self.compiled.outputs.index(self.output)

    @property
    def steps(self) -> int:
        """Of a run."""
        return len(self.grid.lengths)

    def chunks(self, count: int, size: int) -> Iterator[list[Any]]:
        """Values of `size` runs at a time; the last chunk ends with its last run, repeated."""
        for first in range(0, count, size):
            places = np.minimum(np.arange(first, first + size), count - 1)
            yield [np.asarray(v[places] if np.ndim(v) else v, float) for v in self.values]


def wire(count: int, drive: Drive | None = None) -> tuple[Case, Wire]:
    """The coupled wire, and its parameter sets."""
    sets = parameter_sets(count)
    compiled, values = ours.varied(sets)
    grid = ours.grid(drive or sine(), STEP)
    return Case("coupled wire", compiled, values, grid, "position"), sets


def finger(law: str, count: int, duration: float | None = None) -> Case:
    """The finger with a law; parameters uniform within their shares of the nominal ones."""
    scenario = load(ROOT / "examples/finger.toml", {"element.law": law})
    return vary(f"finger, {law}", scenario, count, "stress", duration=duration)


def readme_wire(count: int, step: float = 5e-3) -> Case:
    """The wire of README.md for 30 s, varied in the same way."""
    return vary("wire of README.md", readme_scenario(), count, "stress", step, 31)


def readme_scenario() -> Scenario:
    """That of README.md."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return read_scenario(text.split("```toml\n")[1].split("```")[0])


def vary(
    name: str,
    scenario: Scenario,
    count: int,
    output: str,
    step: float = STEP,
    samples: int = 101,
    duration: float | None = None,
) -> Case:
    """A scenario as many times."""
    system, rng = scenario.system, np.random.default_rng(0)
    compiled = compile_march(system)
    values: list[Any] = list(compiled.values(system))
    for path, share in VARIED.items():
        place = compiled.paths.index(path)
        values[place] = values[place] * (1.0 + share * (2.0 * rng.random(count) - 1.0))
    grid = grid_of(system, scenario.waveform, duration or scenario.duration, samples, step)
    return Case(name, compiled, values, grid, output)


class Kept(NamedTuple):
    """What is left of many runs."""

    first: Any
    """All samples of the first few, (runs, samples)."""
    strokes: Any
    """Range of every run, (runs,)."""


def kept(blocks: Iterator[Any], count: int) -> Kept:
    """Of blocks of rows (samples, runs)."""
    first, strokes = None, []
    for rows in blocks:
        first = np.array(rows[:, :KEPT].T) if first is None else first
        strokes.append(np.ptp(rows, axis=0))
    return Kept(first, np.concatenate(strokes)[:count])


def in_lanes(case: Case, count: int, threads: int = 1, lanes: int = LANES) -> Callable[[], Kept]:
    """In C, blocks of lanes in one thread or dealt out to several."""
    lanes = min(lanes, -(-count // BLOCK) * BLOCK)

    def block(values: list[Any]) -> Any:
        return march_lanes(case.compiled, values, case.grid, lanes, [case.place])[0][:, 0]

    def run() -> Kept:
        if threads == 1:
            return kept(map(block, case.chunks(count, lanes)), count)
        with ThreadPoolExecutor(threads) as pool:
            return kept(pool.map(block, case.chunks(count, lanes)), count)

    return run


def one_by_one(case: Case, count: int) -> Callable[[], Kept]:
    """In C, without lanes."""
    return in_lanes(case, count, lanes=1)
