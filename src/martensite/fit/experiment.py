"""Experiments: a system, what drove it, and what was measured.

Measured rows may be spaced as they like, and miss samples (NaN) in what is compared. A run
begins at the start of its waveforms, `lead` before time 0 of the record, and is compared where
the record has rows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import DataError, require_known
from martensite.search.batch_runner import BatchRunner
from martensite.signals.records import Record
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms
from martensite.simulate.grid import TimeGrid, grid_at

LEAST_ROWS = 8
"""Rows without which nothing can be fitted."""
MOST_ROWS = 4000
"""Rows that are compared; a longer record is thinned evenly."""


@dataclass(frozen=True)
class Experiment:
    """One record and the system that is to explain it."""

    name: str
    system: AbstractSystem
    waveform: Waveforms
    record: Record
    columns: Mapping[str, str]
    """Output of the system -> column of the record that it is compared with."""
    step: float = math.inf
    """Longest step [s]; steps end on samples and on edges of the waveform besides."""
    held: tuple[tuple[float, float], ...] = ()
    """Stretches of time [s] that are kept back from the fit; (-inf, inf) keeps all."""
    weights: Mapping[str, float] = field(default_factory=dict[str, float])
    """Output -> weight of its squared residuals; 1 if not given."""
    lead: float = 0.0
    """Time that the run takes before time 0 of the record [s]: what brings the element into the
    state in which the record begins."""

    def __post_init__(self) -> None:
        check_experiment(self)

    @cached_property
    def rows(self) -> Any:
        """Indices of the rows of the record that are compared."""
        count = len(self.record)
        stride = -(-count // MOST_ROWS)
        return np.arange(0, count, stride)

    @cached_property
    def times(self) -> Any:
        """When they were measured [s]."""
        return np.asarray(self.record.times)[self.rows]

    @cached_property
    def measured(self) -> Any:
        """What was measured in SI, rows by outputs; NaN where nothing was."""
        columns = [np.asarray(self.record[name])[self.rows] for name in self.columns.values()]
        return np.stack(columns, axis=1)

    @cached_property
    def kept_back(self) -> Any:
        """True for the rows that the fit does not see."""
        flags = np.zeros(len(self.times), bool)
        for first, last in self.held:
            flags |= (self.times >= first) & (self.times <= last)
        return flags

    @property
    def outputs(self) -> tuple[str, ...]:
        """What is compared."""
        return tuple(self.columns)

    @property
    def held_out(self) -> bool:
        """Whether the whole record is kept back."""
        return bool(self.kept_back.all())

    def grid(self, step: float | None = None) -> TimeGrid:
        """The time grid, with samples at 0 and at the rows that are compared."""
        times = (self.times + self.lead).tolist()
        if times[0] > 0.0:
            times = [0.0, *times]
        at_end = [drive.at_end for drive in self.system.drives()]
        waves = arrange_waveforms(self.system, self.waveform)
        longest = min(self.step, times[-1]) if step is None else step
        return grid_at(waves, times, longest, at_end)

    def runner(self, step: float | None = None, outputs: Sequence[str] | None = None) -> BatchRunner:
        """Its runs, with samples at the rows that are compared.

        Args:
            step: longest step [s]; its own if None.
            outputs: what is looked at; what is compared if None.
        """
        grid = self.grid(step)
        first = len(grid.times) - len(self.times)
        return BatchRunner(self.system, grid, outputs or self.outputs, first=first)


def check_experiment(experiment: Experiment) -> None:
    """Refuse a record that cannot be compared with its system.

    Raises:
        DataError: unknown outputs, other units, too few rows, a constant or an impossible column.
    """
    record, known = experiment.record, experiment.system.outputs()
    if not experiment.columns:
        raise DataError(
            f"Record `{record.name}` and the system have no column in common; the record holds "
            f"{_list_columns(record.columns)}, the system gives {_list_columns(known)}."
        )
    if record.times[0] + experiment.lead < 0.0:
        raise DataError(
            f"Record `{record.name}` begins at {record.times[0]:.6g} s, before the run does at "
            f"{-experiment.lead:.6g} s."
        )
    for output, column in experiment.columns.items():
        require_known("output", output, known)
        numbers = record[column]
        if record.units[column] != known[output].unit:
            raise DataError(
                f"Column `{column}` of record `{record.name}` is in {record.units[column]}, but "
                f"output `{output}` in {known[output].unit}."
            )
        _check_numbers(record.name, column, numbers)


def _check_numbers(record: str, column: str, numbers: Sequence[float]) -> None:
    finite = [number for number in numbers if math.isfinite(number)]
    if len(finite) < LEAST_ROWS:
        raise DataError(
            f"Column `{column}` of record `{record}` holds {len(finite)} measured numbers; a fit "
            f"needs at least {LEAST_ROWS}."
        )
    if max(finite) == min(finite):
        raise DataError(
            f"Column `{column}` of record `{record}` is constant ({finite[0]:.6g}); nothing can "
            "be learned from it. Leave it out, or look whether columns were swapped."
        )


def _list_columns(names: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name}`" for name in names if name != "time") or "none but `time`"
