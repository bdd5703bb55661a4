"""Experiments: a system, its drives and its measurements.

Measured rows may have any spacing, and NaN in compared columns. A run begins at the start of its waveforms, `lead`
before time 0 of the record, and is compared at the rows of the record.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import DataError, require_known
from martensite.search.batch_runner import BatchRunner
from martensite.search.quantity_text import format_number
from martensite.signals.records import Record
from martensite.signals.table import Table
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms, by_name
from martensite.simulate.grid import LaneGrid, TimeGrid, grid_at, lane_grid

ALL = ((-math.inf, math.inf),)
"""Interval that holds out a whole record."""
LEAST_ROWS = 8
"""Least number of rows of a fit."""
MOST_ROWS = 4000
"""Largest number of compared rows; a longer record is thinned evenly."""


@dataclass(frozen=True)
class Experiment:
    """Record with the system that models it."""

    name: str
    system: AbstractSystem
    waveform: Waveforms
    record: Record
    columns: Mapping[str, str]
    """Output of the system -> compared column of the record."""
    step: float = math.inf
    """Longest step [s]; steps also end on samples and on edges of the waveform."""
    held_out_intervals: tuple[tuple[float, float], ...] = ()
    """Held-out time intervals [s]; (-inf, inf) for the whole record."""
    weights: Mapping[str, float] = field(default_factory=dict[str, float])
    """Output -> weight of its squared residuals; 1 by default."""
    lead: float = 0.0
    """Run time before time 0 of the record [s], which brings the element into the initial state of the record."""
    follows: Mapping[str, str] = field(default_factory=dict[str, str])
    """Drive -> column of the record followed by its waveform."""
    groups: Mapping[str, str] = field(default_factory=dict[str, str])
    """Groups of the record, by kind: `specimen` -> A."""

    def __post_init__(self) -> None:
        check_experiment(self)

    @cached_property
    def rows(self) -> Any:
        """Return the indices of the compared rows."""
        count = len(self.record)
        stride = -(-count // MOST_ROWS)
        return np.arange(0, count, stride)

    @cached_property
    def times(self) -> Any:
        """Return the times of the compared rows [s]."""
        return np.asarray(self.record.times)[self.rows]

    @cached_property
    def measured(self) -> Any:
        """Return the measured values in SI, rows by outputs; NaN for missing values."""
        columns = [np.asarray(self.record[name])[self.rows] for name in self.columns.values()]
        return np.stack(columns, axis=1)

    @cached_property
    def held_out_rows(self) -> Any:
        """Return the held-out rows, as True."""
        flags = np.zeros(len(self.times), bool)
        for first, last in self.held_out_intervals:
            flags |= (self.times >= first) & (self.times <= last)
        return flags

    @property
    def outputs(self) -> tuple[str, ...]:
        """Return the compared outputs."""
        return tuple(self.columns)

    @property
    def is_held_out(self) -> bool:
        """Return whether the whole record is held out."""
        return bool(self.held_out_rows.all())

    @property
    def over_time(self) -> bool:
        """Return whether the rows are times."""
        return True

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the name of the record and its groups, the labels of separate parameters."""
        return self.name, *self.groups.values()

    @property
    def row_factors(self) -> Any:
        """Return the weights of errors of single rows: 1, or (rows, outputs)."""
        return 1.0

    def describe_outputs(self) -> Mapping[str, Output]:
        """Return all comparable outputs."""
        return self.system.outputs()

    def describe_row(self, time: float) -> str:
        """Return the name of the row at a time [s]."""
        return f"{format_number(time)} s"

    def sample_outputs(self, system: AbstractSystem, outputs: Sequence[str], rows: Any, step: float | None) -> Any:
        """Return the outputs (samples, outputs) of a run with other parameters, at some compared rows."""
        runner = self.runner(step, outputs)
        return runner.run_many(np.array([runner.compiled.values(system)]))[0][rows]

    def find_followed_waveform(self, drive: str) -> Table:
        """Return the waveform of a drive that follows a column."""
        return cast("Table", by_name(self.system, self.waveform)[drive])

    def with_inputs(self, inputs: Mapping[str, Any]) -> Experiment:
        """Return the experiment with other rows in its followed columns, by drive."""
        changed = {
            name: Table(times=self.find_followed_waveform(name).times, values=tuple(map(float, row)))
            for name, row in inputs.items()
        }
        return replace(self, waveform={**by_name(self.system, self.waveform), **changed})

    def driven_grid(self, variants: Sequence[Mapping[str, Any]], step: float | None = None) -> LaneGrid:
        """Return grids of variants of followed columns, one per batch element; equal steps for prescribed states."""
        drives = list(self.system.drives())
        late, names = [drive.at_end for drive in drives], [drive.name for drive in drives]
        if not all(late[names.index(name)] for name in variants[0]):
            return lane_grid([self.with_inputs(inputs).grid(step) for inputs in variants])
        grid = self._grids.get(step) or self._grids.setdefault(step, self.grid(step))
        first, rest, counts, moments, lengths = grid.arrays
        sampled = np.repeat(np.concatenate([first, rest])[:, :, None], len(variants), axis=2)
        moments = np.repeat(moments.reshape(len(lengths), -1)[:, :, None], len(variants), axis=2)
        wide = 1 if all(late) else (moments.shape[1] - sum(late)) // (len(late) - sum(late))
        for name in variants[0]:
            place, times = names.index(name), np.asarray(self.find_followed_waveform(name).times)
            column = sum(1 if end else wide for end in late[:place])
            for lane, inputs in enumerate(variants):
                sampled[:, place, lane] = np.interp(grid.times, times, inputs[name])
                moments[:, column, lane] = np.interp(np.cumsum(lengths), times, inputs[name])
        return LaneGrid(grid.times, sampled, counts, moments, np.repeat(lengths[:, None], len(variants), axis=1))

    @cached_property
    def _grids(self) -> dict[float | None, TimeGrid]:
        """Return the grids by longest step."""
        return {}

    def grid(self, step: float | None = None) -> TimeGrid:
        """Return the time grid, with samples at 0 and at the compared rows."""
        times = (self.times + self.lead).tolist()
        if times[0] > 0.0:
            times = [0.0, *times]
        at_end = [drive.at_end for drive in self.system.drives()]
        waves = arrange_waveforms(self.system, self.waveform)
        longest = min(self.step, times[-1]) if step is None else step
        return grid_at(waves, times, longest, at_end)

    def runner(self, step: float | None = None, outputs: Sequence[str] | None = None) -> BatchRunner:
        """Return the runs of the experiment, with samples at the compared rows.

        Args:
            step: longest step [s], or None for the step of the experiment.
            outputs: sampled outputs, or None for the compared outputs.
        """
        grid = self.grid(step)
        first = len(grid.times) - len(self.times)
        return BatchRunner(self.system, grid, outputs or self.outputs, first=first)


def check_experiment(experiment: Experiment) -> None:
    """Raise an error for a record that cannot be compared with its system.

    Raises:
        DataError: unknown outputs, other units, too few rows, a constant or an impossible column.
    """
    record, outputs = experiment.record, experiment.system.outputs()
    if not experiment.columns:
        raise DataError(
            f"Record `{record.name}` and the system have no column in common; the record holds "
            f"{_list_columns(record.columns)}, the system gives {_list_columns(outputs)}."
        )
    if record.times[0] + experiment.lead < 0.0:
        raise DataError(
            f"Record `{record.name}` begins at {record.times[0]:.6g} s, before the run does at "
            f"{-experiment.lead:.6g} s."
        )
    for output, column in experiment.columns.items():
        require_known("output", output, outputs)
        numbers = record[column]
        if record.units[column] != outputs[output].unit:
            raise DataError(
                f"Column `{column}` of record `{record.name}` is in {record.units[column]}, but "
                f"output `{output}` in {outputs[output].unit}."
            )
        _check_numbers(record.name, column, numbers)


def _check_numbers(record: str, column: str, numbers: Any) -> None:
    finite = numbers[np.isfinite(numbers)]
    if len(finite) < LEAST_ROWS:
        raise DataError(
            f"Column `{column}` of record `{record}` holds {len(finite)} measured numbers; a fit "
            f"needs at least {LEAST_ROWS}."
        )
    if finite.max() == finite.min():
        raise DataError(
            f"Column `{column}` of record `{record}` is constant ({finite[0]:.6g}); nothing can "
            "be learned from it. Leave it out, or look whether columns were swapped."
        )


def _list_columns(names: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name}`" for name in names if name != "time") or "none but `time`"
