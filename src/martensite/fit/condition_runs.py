"""Runs of a table of conditions: rows are short runs from the initial state, outputs are measures of them.

All rows of a specimen use one program and differ in parameters, waveform and duration only. They run in parallel, one
per batch element. Derivatives are computed row by row, with the chain rule from the samples to each measure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import DataError
from martensite.fit.experiment import Experiment
from martensite.search.batch_runner import LANES, BatchRunner
from martensite.search.quantity_text import format_quantity, join_phrases
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms
from martensite.simulate.grid import LaneGrid, TimeGrid, grid_at, lane_grid
from martensite.simulate.measures.base import AbstractMeasure, list_needed, parse_measure
from martensite.simulate.measures.run_table import tabulate_samples

LEAST_STEPS = 200
"""Least number of steps of a run."""
CYCLES = "wear.cycles"
"""End of the path of the cycles before a row."""


class TableRow(NamedTuple):
    """Inputs of one row."""

    inputs: Mapping[str, float]
    """Path for `--set` -> value [SI]."""
    changes: Mapping[str, float]
    """Path in the system -> value [SI] that differs from the first row."""
    waveform: Waveforms
    duration: float
    """[s]"""
    row: int
    """Row number in the file; for repeats, the first row number."""


@dataclass(frozen=True)
class ConditionExperiment(Experiment):
    """Rows of a specimen, with conditions instead of times and measures instead of outputs.

    Its `times` are row numbers from 1; `columns` maps measures to their names.
    """

    conditions: tuple[TableRow, ...] = ()
    factors: Mapping[str, tuple[float, ...]] = field(default_factory=dict[str, tuple[float, ...]])
    """Measure -> factors on the errors of single rows, for repeats and standard deviations."""
    input_units: Mapping[str, str] = field(default_factory=dict[str, str])
    """Path set by a column -> its SI unit."""
    level: str = ""
    """Path of the drive among the inputs; empty without a drive."""

    def __post_init__(self) -> None:
        """Raise `DataError` if there are no measurements."""
        if not np.isfinite(self.measured).any():
            raise DataError(f"Specimen `{self.name}` has no measured number.")

    @cached_property
    def rows(self) -> Any:
        """Return the indices of all rows."""
        return np.arange(len(self.record))

    @cached_property
    def measures(self) -> dict[str, AbstractMeasure]:
        """Return the compared measures."""
        return {words: parse_measure(words) for words in self.columns}

    @property
    def cycles(self) -> list[float]:
        """Return the cycles of wear before each row; empty without such a column."""
        path = next((x for x in self.conditions[0].inputs if x.endswith(CYCLES)), "")
        return [row.inputs[path] for row in self.conditions] if path else []

    @property
    def over_time(self) -> bool:
        """Return False: the rows are conditions."""
        return False

    @property
    def row_factors(self) -> Any:
        """Return the weights of errors of single rows, (rows, outputs)."""
        return np.stack([np.asarray(self.factors[name]) for name in self.columns], axis=1)

    def describe_outputs(self) -> Mapping[str, Output]:
        """Return the measures."""
        units = self.record.units
        return {words: Output(units[column], column, f" {column}") for words, column in self.columns.items()}

    def describe_row(self, time: float) -> str:
        """Return the row in the file, and its varied inputs."""
        one = self.conditions[round(time) - 1]
        varied = [path for path in one.inputs if len({c.inputs[path] for c in self.conditions}) > 1]
        words = [format_quantity(one.inputs[path], self.input_units[path]) for path in varied]
        return f"row {one.row}" + (f" ({join_phrases(words)})" if words else "")

    def grids(self, step: float | None = None) -> list[TimeGrid]:
        """Return the time grid of every row, with the outputs at the end of every step.

        Shorter grids repeat their last row without a step, so that all have equally many rows.
        """
        at_end, grids = [drive.at_end for drive in self.system.drives()], list[TimeGrid]()
        for one in self.conditions:
            waves = arrange_waveforms(self.system, one.waveform)
            longest = min(self.step if step is None else step, one.duration / LEAST_STEPS)
            grids.append(grid_at(waves, [0.0, one.duration], longest, at_end).keep_steps(waves))
        most = max(len(grid.times) for grid in grids)
        return [_extend_grid(grid, most) for grid in grids]

    def grid(self, step: float | None = None) -> Any:
        """Return the grids of all rows, as a batch."""
        return lane_grid(self.grids(step))

    def runner(self, step: float | None = None, outputs: Sequence[str] | None = None) -> Any:
        """Return the runner of all rows."""
        return ConditionRunner(self, self.grids(step))

    def sample_outputs(self, system: AbstractSystem, outputs: Sequence[str], rows: Any, step: float | None) -> Any:
        """Return the outputs at all samples of some rows, one run after the other."""
        runner = ConditionRunner(self, self.grids(step), outputs)
        values = np.array(runner.compiled.values(system))
        places = np.flatnonzero(rows)
        return np.concatenate(runner.march(places, np.repeat(values[None], len(places), axis=0)))


def _extend_grid(grid: TimeGrid, rows: int) -> TimeGrid:
    """Return a grid with its last row repeated, without steps, up to a number of rows."""
    more = rows - len(grid.times)
    times, (sampled, _) = grid.times + grid.times[-1:] * more, grid.list_inputs()
    sampled = sampled + sampled[-1:] * more
    return replace(grid, times=times, sampled=sampled, counts=grid.counts + [0] * more)


class ConditionRunner:
    """Counterpart of `BatchRunner` for conditions: a sample is the measures of a row."""

    def __init__(
        self, experiment: ConditionExperiment, grids: Sequence[TimeGrid], outputs: Sequence[str] | None = None
    ) -> None:
        """Prepare runs with the measures of the experiment, or with given outputs."""
        self.experiment, self.grids = experiment, list(grids)
        self.measures = list(experiment.measures.values())
        system = experiment.system
        self.needed = list_needed(self.measures, system) if outputs is None else tuple(outputs)
        self.single = BatchRunner(system, self.grids[0], self.needed)
        self.native, self.compiled = self.single.native, self.single.compiled
        self.paths, self.base, self.outputs = self.single.paths, self.single.base, experiment.outputs
        self.changes = [
            {self.paths.index(path): value for path, value in one.changes.items()} for one in experiment.conditions
        ]
        self._lanes: dict[tuple[int, ...], LaneGrid] = {}

    @cached_property
    def grid(self) -> LaneGrid:
        """Return the grids of all rows, as a batch."""
        return lane_grid(self.grids)

    def run_one(self, values: Any) -> Any:
        """Return the measures (rows, measures); None if a run fails."""
        measures = self.run_many(np.asarray(values)[None])[0]
        return measures if np.isfinite(measures).all() else None

    def run_many(self, table: Any) -> Any:
        """Return the measures (points, rows, measures) of a table (points, parameters); NaN for failed runs."""
        rows, points = len(self.grids), len(table)
        places = np.repeat(np.arange(rows), points)
        marched = self.march(places, np.tile(np.asarray(table), (rows, 1)))
        measures = np.empty((points, rows, len(self.measures)))
        for row in range(rows):
            measures[:, row] = self._judge(row, marched[row * points : (row + 1) * points])
        return measures

    def run_slopes(self, values: Any, seeds: Any) -> tuple[Any, Any] | None:
        """Return the measures with their derivatives (rows, measures, directions); None if a run fails."""
        rows, slopes = list[Any](), list[Any]()
        for row, grid in enumerate(self.grids):
            own, moving = self._set_values(row, values), np.array(seeds)
            moving[list(self.changes[row])] = 0.0
            run = self.single.with_grid(grid).run_slopes(own, moving)
            if run is None:
                return None
            times = np.asarray(grid.times)
            rows.append(self._judge(row, run[0][None])[0])
            slopes.append([self._weigh(one, times, *run) for one in self.measures])
        finite = np.isfinite(rows).all() and np.isfinite(slopes).all()
        return (np.array(rows), np.array(slopes)) if finite else None

    def march(self, places: Any, table: Any) -> Any:
        """Return the outputs (runs, samples, outputs) of rows with separate parameters; NaN for failed runs."""
        values = np.stack([self._set_values(row, one) for row, one in zip(places, table, strict=True)])
        if not self.native:
            runs = [
                self.single.with_grid(self.grids[p]).run_many(v[None])[0] for p, v in zip(places, values, strict=True)
            ]
            return np.stack(runs)
        pieces = list[Any]()
        for k in range(0, len(places), LANES):
            some = [*places[k : k + LANES]]
            lanes = tuple(int(p) for p in some + some[-1:] * (LANES - len(some)))
            padded = np.pad(values[k : k + LANES], ((0, LANES - len(some)), (0, 0)), mode="edge")
            grid = self._lanes.get(lanes) or self._lanes.setdefault(lanes, lane_grid([self.grids[p] for p in lanes]))
            pieces.append(self.single.run_lanes(padded, grid)[: len(some)])
        return np.concatenate(pieces)

    def _set_values(self, row: int, values: Any) -> Any:
        row_values = np.array(values, float)
        for place, value in self.changes[row].items():
            row_values[place] = value
        return row_values

    def _judge(self, row: int, runs: Any) -> Any:
        """Return the measures (runs, measures) of runs (runs, samples, outputs) of a row."""
        times = np.asarray(self.grids[row].times)
        with np.errstate(invalid="ignore"):
            measures = [one.value(tabulate_samples(times, self._select(one, runs))) for one in self.measures]
        return np.where(np.isfinite(runs).all(axis=(1, 2))[:, None], np.stack(measures, axis=1), np.nan)

    def _select(self, one: AbstractMeasure, runs: Any) -> Any:
        """Return the columns used by a measure, (columns, samples, runs)."""
        places = [self.needed.index(name) for name in one.columns(self.experiment.system)]
        return np.transpose(runs[:, :, places], (2, 1, 0))

    def _weigh(self, one: AbstractMeasure, times: Any, run: Any, slopes: Any) -> Any:
        """Return the derivatives (directions,) of a measure from the derivatives of the outputs."""
        places = [self.needed.index(name) for name in one.columns(self.experiment.system)]
        weights = one.derivatives(tabulate_samples(times, self._select(one, run[None])))[:, :, 0]
        return np.einsum("cs,scd->d", weights, slopes[:, places])
