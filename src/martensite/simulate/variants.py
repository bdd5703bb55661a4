"""Batches of variants of one system with individual parameters and waveforms.

Runs to a tolerance have individual step size control and error bounds (`martensite.simulate.ensembles`). They are
batched in C or on a GPU, or made one by one on floats. Runs on given steps and in discrete time use prepared grids:
in blocks in C (`martensite.simulate.native`), on a GPU, or on floats. Results are independent of the other runs of
a batch.

Failures are data: every run has a status, and refused runs are not simulated.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, require_known
from martensite.base.status import Status
from martensite.kernels.c99_lanes import BLOCK
from martensite.signals.base import AbstractWaveform
from martensite.simulate.api import first_step, inertial_step
from martensite.simulate.compiled import CompiledMarch, bind_march, compile_march
from martensite.simulate.drive_waveforms import arrange_waveforms, grid_of
from martensite.simulate.ensembles import Ensemble, EnsembleMeasures, Flags, Numbers, march_in_lanes, march_one_by_one
from martensite.simulate.envelope import envelope_of, varied_stops
from martensite.simulate.grid import LaneGrid, Steps, TimeGrid, cut_steps, lane_grid
from martensite.simulate.march import SOLVED, Border, march_floats
from martensite.simulate.marching import MarchPlan
from martensite.simulate.marching_native import Runs, march_runs
from martensite.simulate.measures.base import AbstractMeasure
from martensite.simulate.native import march_inside
from martensite.simulate.refusals import find_refused

Places: TypeAlias = NDArray[np.intp]
Values: TypeAlias = Mapping[str, Numbers]
"""Values per run by parameter path."""
OnSteps: TypeAlias = tuple[list[Numbers], Numbers, Numbers]
"""Columns (runs, samples), reports (3, runs), and times of leaving the envelope [s], (runs,)."""
RUNTIMES = ("c", "cuda", "floats")
SOLVED_TO = {"float64": SOLVED, "float32": 2e-3}
"""Accepted residual of a step, by precision."""
NAMES = {"cuda": "CUDA", "c": "C"}
"""Names of the runtimes for users."""
LANES = {"c": 64, "floats": 16}
"""Largest batch on given steps."""
HELD = 1024
"""State values of a batch that fit into the fastest cache with intermediate results."""
TOGETHER = 256
"""Runs with step size control per batch; samples are stored twice."""
CLOCKS = 64
"""Cached step grids by edges."""
REPORTS = {
    Status.OK: (0.0, 0.0, 0.0),
    Status.LONG_STEP: (0.0, 1.0, 0.0),
    Status.UNSOLVED: (1.0, 0.0, 0.0),
    Status.OUT_OF_ENVELOPE: (0.0, 0.0, 0.0),
}
"""Worst reports that stand for a status."""
BROKEN = (np.inf, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class VariantSetup:
    """Common settings of all variants."""

    system: AbstractSystem
    """System at its nominal parameters."""
    waveforms: Mapping[str, AbstractWaveform]
    """Waveforms by drive, at their nominal parameters."""
    duration: float
    """[s]"""
    samples: int
    step: float | None
    """Longest step [s] of runs on equal steps; None for runs to a tolerance."""
    outputs: tuple[str, ...]
    runtime: str = "c"
    precision: str = "float64"
    lanes: int | None = None
    """Batch size on given steps; by default suited to the runtime."""
    tolerance: float = 1e-4
    """Accepted error of judged outputs, as a fraction of their ranges, without a given step."""
    chunk: int | None = None
    """Runs per GPU batch; by default limited by memory."""
    devices: int | None = 1
    """Threads in C; all cores if None."""
    measures: tuple[AbstractMeasure, ...] = ()
    """Measures of every run; their columns are among the outputs."""

    def __post_init__(self) -> None:
        """Raise `InputError` for an unknown runtime or precision."""
        require_known("runtime", self.runtime, RUNTIMES)
        if self.precision not in SOLVED_TO:
            raise ParameterError(f"Argument `precision` must be float64 or float32, but is `{self.precision}`.")
        if self.precision != "float64" and self.runtime != "cuda":
            raise ParameterError(
                f"Argument `precision` may be float32 on CUDA only, but the runtime is `{self.runtime}`; "
                'give a `step` and `runtime="cuda"`.'
            )
        if self.controlled and self.precision != "float64":
            raise ParameterError("A batch in float32 runs on equal steps; give the longest one as `step`.")

    def run(self, values: Values, signals: Mapping[str, Values] | None = None) -> Ensemble:
        """Run variants.

        Args:
            values: parameters of the system by path, (runs,) each, in SI.
            signals: parameters of waveforms by drive and path, (runs,) each, in SI.

        Returns:
            The outputs of every run, in order.
        """
        own = {name: dict(table) for name, table in (signals or {}).items() if table}
        count = len(next(iter((*values.values(), *(v for t in own.values() for v in t.values())))))
        refusal = find_refused(self.system, values, count) | self._list_refused(own, count)
        size, rows = self._together(bool(own), count), np.arange(count)
        make = self._to_tolerance if self.controlled else self._block

        def make_block(first: int) -> Ensemble:
            return make(values, own, rows[first : first + size], refusal, size)

        firsts = range(0, count, size)
        threads = (os.cpu_count() or 1) if self.devices is None else self.devices
        if threads == 1 or self.runtime == "cuda":
            return Ensemble.concatenate([make_block(first) for first in firsts])
        with ThreadPoolExecutor(threads) as pool:
            return Ensemble.concatenate(list(pool.map(make_block, firsts)))

    # ---------------------------------------------------------------- runs to a tolerance

    def _to_tolerance(
        self, values: Values, signals: Mapping[str, Values], rows: Places, refusal: Flags, size: int
    ) -> Ensemble:
        """Return runs with step size control, without refused runs."""
        ensemble = Ensemble.empty(self.outputs, len(rows), self.samples, Status.REFUSED, len(self.measures))
        good = np.flatnonzero(~refusal[rows])
        if not len(good):
            return ensemble
        march = self._ensemble_on_floats if self.runtime == "floats" else self._ensemble_in_c
        good_runs = march({path: column[rows[good]] for path, column in values.items()}, signals, rows[good])
        ensemble.place_runs(good, good_runs)
        return ensemble

    def _ensemble_in_c(self, values: Values, signals: Mapping[str, Values], rows: Places) -> Ensemble:
        own = [self._order_waveforms(signals, row) for row in rows] if signals else None
        runs = Runs(
            self.plan,
            self.table(values),
            len(rows),
            self.places,
            BLOCK,
            own=own,
            limits=self.find_limits(values, len(rows)),
        )
        march = march_runs if self.runtime == "c" else _load_cuda().march_to_ends
        return march_in_lanes(runs, self.outputs, self.tolerance, march, self.measuring)

    def _ensemble_on_floats(self, values: Values, signals: Mapping[str, Values], rows: Places) -> Ensemble:
        systems = (
            (
                self.system.rebuilt({path: float(v[k]) for path, v in values.items()}),
                self._order_waveforms(signals, row),
            )
            for k, row in enumerate(rows)
        )
        return march_one_by_one(self.plan, systems, len(rows), self.outputs, self.tolerance, self.measuring)

    @cached_property
    def measuring(self) -> EnsembleMeasures:
        """Return the measures with the indices of their outputs."""
        columns = [[self.outputs.index(name) for name in one.columns(self.system)] for one in self.measures]
        return EnsembleMeasures(self.measures, columns)

    @cached_property
    def plan(self) -> MarchPlan:
        """Return the common plan of runs with step size control."""
        return MarchPlan(
            self.compiled,
            arrange_waveforms(self.system, self.waveforms),
            self.times,
            self.tolerance,
            first_step(self.system, self.duration, self.samples),
            envelope_of(self.system),
            inertial=inertial_step(self.system),
            recorded=not self.measuring.totalled or self.runtime == "floats",
            totalled=bool(self.measures) and self.measuring.totalled,
        )

    def _order_waveforms(self, signals: Mapping[str, Values], row: int) -> Sequence[AbstractWaveform]:
        """Return the waveforms of one run, in the order of the drives."""
        if not signals:
            return self.plan.waveforms
        return arrange_waveforms(self.system, self._waveforms(signals, row))

    def find_limits(self, values: Values, count: int) -> Any:
        """Return the limits that end a run, (2, envelope, runs), if they vary."""
        varied = varied_stops(values)
        if not varied:
            return None
        tables = [{path: float(values[path][k]) for path in varied} for k in range(count)]
        limits = [envelope_of(self.system.rebuilt(table)) for table in tables]
        return np.moveaxis(np.array(limits, float), 0, 2)

    # ---------------------------------------------------------------- runs on given steps

    def _together(self, own: bool, count: int) -> int:
        if self.runtime == "cuda":
            return int(_load_cuda().count_together(self, own, count))
        if self.controlled:
            return TOGETHER
        if self.lanes or self.runtime != "c":
            return self.lanes or LANES[self.runtime]
        return min(LANES["c"], max(1, HELD // self.compiled.size // BLOCK) * BLOCK)

    def _block(
        self, values: Values, signals: Mapping[str, Values], rows: Places, refusal: Flags, size: int
    ) -> Ensemble:
        """Return a batch of runs; missing and refused runs are nominal and then removed."""
        bad = refusal[rows]
        good: Places = rows[~bad]
        if not len(good):
            return Ensemble.empty(self.outputs, len(rows), self.samples, Status.REFUSED, len(self.measures))
        marched: Places = np.pad(np.where(bad, good[0], rows), (0, size - len(rows)), mode="edge")
        table = {path: column[marched] for path, column in values.items()}
        grid = self._grid(signals, marched)
        columns, reports, left = self.engine(table, grid, size)
        rowed = np.stack(columns)[:, : len(rows)]
        numbers = self.measuring.measure_samples(grid.times, rowed.swapaxes(1, 2))
        named = {n: c[:, grid.stored] for n, c in zip(self.outputs, rowed, strict=True)}
        solved = SOLVED_TO[self.precision]
        ensemble = Ensemble.on_steps(named, reports[:, : len(rows)], left[: len(rows)], self.times, solved)
        return replace(ensemble, numbers=numbers).struck_out(bad)

    @property
    def controlled(self) -> bool:
        """Return whether runs are made to a tolerance."""
        return self.step is None and not self.system.sample_time()

    @property
    def longest(self) -> float:
        """Return the longest step of runs on given steps [s], or the sample time in discrete time."""
        return self.step or self.system.sample_time()

    @property
    def times(self) -> list[float]:
        """Return the sample times [s]."""
        if self.controlled:
            return [self.duration * k / (self.samples - 1) for k in range(self.samples)]
        return np.asarray(self._common.times)[self._common.stored].tolist()

    @cached_property
    def compiled(self) -> CompiledMarch:
        """Return the traced system."""
        return compile_march(self.system)

    @cached_property
    def places(self) -> tuple[int, ...]:
        """Return the indices of the requested outputs."""
        return tuple(self.compiled.outputs.index(name) for name in self.outputs)

    def table(self, values: Values) -> list[Any]:
        """Return all parameters in order: numbers, or (runs,) where they vary."""
        nominal = zip(self.compiled.paths, self.compiled.values(self.system), strict=True)
        return [values.get(path, number) for path, number in nominal]

    @cached_property
    def engine(self) -> Callable[[Values, TimeGrid | LaneGrid, int], OnSteps]:
        """Return the function for runs on given steps, from (values, grid, runs)."""
        if self.runtime == "cuda":
            return partial(_load_cuda().march_on_cuda, self)
        return self._march_c if self.runtime == "c" else self._march_floats

    def _march_c(self, values: Values, grid: TimeGrid | LaneGrid, runs: int) -> OnSteps:
        limits = self.find_limits(values, runs)
        limits = np.array(envelope_of(self.system), float) if limits is None else limits
        rows, worst, left = march_inside(self.compiled, self.table(values), grid, runs, self.places, limits)
        return [rows[:, k].T for k in range(len(self.outputs))], worst, left

    def _march_floats(self, values: Values, grid: TimeGrid | LaneGrid, runs: int) -> OnSteps:
        """Return runs on floats, one by one; a failed run has a report above the limit."""
        columns = np.full((len(self.outputs), runs, len(grid.times)), np.nan)
        reports, left = np.zeros((3, runs)), np.full(runs, np.inf)
        for run in range(runs):
            system = self.system.rebuilt({path: float(v[run]) for path, v in values.items()})
            try:
                functions, size = bind_march(system)
                border = Border(self.compiled, functions, envelope_of(system))
                march = march_floats(functions, size, grid if isinstance(grid, TimeGrid) else grid.lane(run), border)
            except ArithmeticError:  # a value that depends on parameters alone is not finite
                reports[:, run] = BROKEN
                continue
            reports[:, run] = REPORTS.get(march.status, BROKEN)
            if march.status is Status.OUT_OF_ENVELOPE:
                left[run] = march.time
            rows = np.asarray(march.rows)[:, list(self.places)].T
            columns[:, run, : rows.shape[1]] = rows
        return list(columns), reports, left

    def _grid(self, signals: Mapping[str, Values], rows: Places) -> TimeGrid | LaneGrid:
        """Return common steps, or individual steps for varied waveforms."""
        if not signals:
            return self._common
        cache: dict[tuple[float, ...], TimeGrid] = {}
        grids: list[TimeGrid] = []
        for row in rows:
            key = tuple(float(v[row]) for t in signals.values() for v in t.values())
            if key not in cache:
                cache[key] = self._make_grid(self._waveforms(signals, row))
            grids.append(cache[key])
        return lane_grid(grids)

    @cached_property
    def _common(self) -> TimeGrid:
        shape = self.duration, self.samples, self.longest
        return grid_of(self.system, self.waveforms, *shape, every=self.keeps_steps)

    @property
    def keeps_steps(self) -> bool:
        """Return whether measures of runs on given steps use the ends of all steps, not samples."""
        return bool(self.measures) and self.runtime != "cuda"

    def _make_grid(self, waveforms: Mapping[str, AbstractWaveform]) -> TimeGrid:
        """Return the grid of some waveforms; equal edges share cached steps."""
        if self.system.sample_time():
            shape = self.duration, self.samples, self.longest
            return grid_of(self.system, waveforms, *shape, every=self.keeps_steps)
        edges = tuple(sorted({e for one in waveforms.values() for e in one.edges(self.duration)}))
        steps = self._clocks.get(edges)
        if steps is None:
            if len(self._clocks) >= CLOCKS:
                self._clocks.clear()
            steps = cut_steps(edges, self.times, self.longest)
            self._clocks[edges] = steps
        at_end = [drive.at_end for drive in self.system.drives()]
        return steps.grid(arrange_waveforms(self.system, waveforms), at_end)

    @cached_property
    def _clocks(self) -> dict[tuple[float, ...], Steps]:
        return {}

    def _waveforms(self, signals: Mapping[str, Values], row: int) -> dict[str, AbstractWaveform]:
        varied = {
            name: self.waveforms[name].with_values({p: float(v[row]) for p, v in table.items()})
            for name, table in signals.items()
        }
        return {**self.waveforms, **varied}

    def _list_refused(self, signals: Mapping[str, Values], count: int) -> Flags:
        refusal = np.zeros(count, np.bool_)
        for name, table in signals.items():
            refusal |= find_refused(self.waveforms[name], table, count)
        return refusal


def _load_cuda() -> Any:
    """Import the GPU implementation."""
    from martensite.simulate.cuda import march

    return march
