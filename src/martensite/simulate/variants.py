"""Variants of one system, many at a time: parameters and waveforms that differ from run to run.

In C, blocks of lanes march together (`martensite.simulate.native`); on JAX, a batch on whatever
device JAX has; without either, one after another on floats. A run does not depend on which others
march beside it. Failures are data: every run has a status, and those that a check of the system
refuses are not marched.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.errors import ParameterError, suggestion
from martensite.signals.base import AbstractWaveform
from martensite.simulate.clock import Edges, edges_of, played, steps_of
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.driven import grid_of
from martensite.simulate.grid import Grid, Steps
from martensite.simulate.lane_grid import LaneGrid, lane_grid
from martensite.simulate.march import classify
from martensite.simulate.refusals import refused
from martensite.status import Status
from martensite.system import AbstractSystem

Numbers: TypeAlias = NDArray[np.float64]
Places: TypeAlias = NDArray[np.intp]
Flags: TypeAlias = NDArray[np.bool_]
Values: TypeAlias = Mapping[str, Numbers]
"""Path of a parameter -> one number per run."""
RUNTIMES = ("c", "jax", "floats")
LANES = {"c": 64, "floats": 16}
"""Runs that march together; on JAX as many as suit its devices."""
CLOCKS = 64
"""Sets of edges whose steps are kept."""


@dataclass(frozen=True, eq=False)
class Ran:
    """What some variants did."""

    columns: dict[str, Numbers]
    """One array (runs, samples) per output, in SI units; NaN for runs that were refused."""
    status: NDArray[np.int8]
    """Worst status of every run, (runs,)."""

    @staticmethod
    def joined(pieces: Sequence[Ran]) -> Ran:
        """Some after others."""
        names = pieces[0].columns
        columns = {name: np.concatenate([p.columns[name] for p in pieces]) for name in names}
        return Ran(columns, np.concatenate([p.status for p in pieces]))


@dataclass(frozen=True, eq=False)
class Course:
    """What all variants have in common."""

    system: AbstractSystem
    """At its nominal parameters."""
    waveforms: Mapping[str, AbstractWaveform]
    """By name of what they drive, at their nominal parameters."""
    duration: float
    """[s]"""
    samples: int
    step: float
    """Longest step [s]."""
    outputs: tuple[str, ...]
    runtime: str = "c"
    precision: str = "float64"
    lanes: int | None = None
    """Runs that march together; by default what suits the runtime."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a runtime or a precision that there is not."""
        if self.runtime not in RUNTIMES:
            raise ParameterError(
                f"No runtime named `{self.runtime}`. {suggestion(self.runtime, RUNTIMES)}"
            )
        single = self.precision == "float32"
        if self.precision != "float64" and not (single and self.runtime == "jax"):
            raise ParameterError(
                f"The precision must be float64, or float32 on JAX, but is `{self.precision}` on "
                f"`{self.runtime}`."
            )

    def run(self, values: Values, signals: Mapping[str, Values] | None = None) -> Ran:
        """Run variants.

        Args:
            values: parameters of the system by path, (runs,) each, in SI.
            signals: parameters of waveforms by drive and path, (runs,) each, in SI.

        Returns:
            The outputs of every run, in order.
        """
        own = {name: dict(table) for name, table in (signals or {}).items() if table}
        count = len(next(iter((*values.values(), *(v for t in own.values() for v in t.values())))))
        refusal = refused(self.system, values, count) | self._refused(own, count)
        size, rows = self._together(), np.arange(count)
        pieces = [
            self._block(values, own, rows[k : k + size], refusal, size)
            for k in range(0, count, size)
        ]
        return Ran.joined(pieces)

    def _together(self) -> int:
        """How many runs march together."""
        if self.lanes is None and self.runtime == "jax":
            from martensite.simulate.variants_jax import block

            return block()
        return self.lanes or LANES[self.runtime]

    def _block(
        self, values: Values, signals: Mapping[str, Values], rows: Places, refusal: Flags, size: int
    ) -> Ran:
        """Runs that march together; missing and refused ones are nominal, and struck out."""
        bad = refusal[rows]
        good: Places = rows[~bad]
        if not len(good):
            return self._nothing(len(rows))
        marched: Places = np.pad(np.where(bad, good[0], rows), (0, size - len(rows)), mode="edge")
        table = {path: column[marched] for path, column in values.items()}
        grid = self._grid(signals, marched)
        columns, reports = self.engine(table, grid, size)
        status = np.array([classify(float(r), float(c)) for r, c, *_ in reports.T], np.int8)
        finite = np.logical_and.reduce([np.isfinite(c).all(axis=1) for c in columns])
        status = np.where(finite, status, Status.NOT_FINITE).astype(np.int8)[: len(rows)]
        status[bad] = Status.REFUSED
        kept = [np.where(bad[:, None], np.nan, c[: len(rows)]) for c in columns]
        return Ran(dict(zip(self.outputs, kept, strict=True)), status)

    def _nothing(self, runs: int) -> Ran:
        empty = {name: np.full((runs, self.samples), np.nan) for name in self.outputs}
        return Ran(empty, np.full(runs, Status.REFUSED, np.int8))

    @property
    def times(self) -> list[float]:
        """Sample times [s]."""
        return self._common.times

    @cached_property
    def compiled(self) -> CompiledMarch:
        """The traced system."""
        return compile_march(self.system)

    @cached_property
    def places(self) -> tuple[int, ...]:
        """Where the wanted outputs are."""
        return tuple(self.compiled.outputs.index(name) for name in self.outputs)

    def table(self, values: Values) -> list[Any]:
        """All parameters in order: numbers, or (runs,) where they vary."""
        nominal = zip(self.compiled.paths, self.compiled.values(self.system), strict=True)
        return [values.get(path, number) for path, number in nominal]

    @cached_property
    def engine(self) -> Callable[[Values, Grid | LaneGrid, int], tuple[list[Numbers], Numbers]]:
        """What marches: (values, grid, runs) -> columns (runs, samples), reports (2, runs)."""
        if self.runtime == "c":
            return self._march_c
        if self.runtime == "jax":
            from martensite.simulate.variants_jax import JaxMarch

            return JaxMarch(self)
        return self._march_floats

    def _march_c(
        self, values: Values, grid: Grid | LaneGrid, runs: int
    ) -> tuple[list[Numbers], Numbers]:
        from martensite.simulate.native import march_lanes

        table = self.table(values)
        rows, worst = march_lanes(self.compiled, table, grid, runs, self.places)
        return [rows[:, k].T for k in range(len(self.outputs))], worst

    def _march_floats(
        self, values: Values, grid: Grid | LaneGrid, runs: int
    ) -> tuple[list[Numbers], Numbers]:
        from martensite.simulate.variants_floats import march_one_by_one

        return march_one_by_one(self, values, grid, runs)

    def _grid(self, signals: Mapping[str, Values], rows: Places) -> Grid | LaneGrid:
        """The steps of all, or of every lane where waveforms vary."""
        if not signals:
            return self._common
        known: dict[tuple[float, ...], Grid] = {}
        grids: list[Grid] = []
        for row in rows:
            key = tuple(float(v[row]) for t in signals.values() for v in t.values())
            if key not in known:
                known[key] = self._played(self._waveforms(signals, row))
            grids.append(known[key])
        return lane_grid(grids)

    @cached_property
    def _common(self) -> Grid:
        return grid_of(self.system, self.waveforms, self.duration, self.samples, self.step)

    def _played(self, waveforms: Mapping[str, AbstractWaveform]) -> Grid:
        """The grid of some waveforms; waveforms with the same edges share its steps."""
        if self.system.sample_time():
            shape = self.duration, self.samples, self.step
            return grid_of(self.system, waveforms, *shape)
        edges = edges_of(waveforms, self.duration)
        steps = self._clocks.get(edges)
        if steps is None:
            if len(self._clocks) >= CLOCKS:
                self._clocks.clear()
            steps = steps_of(edges, self.duration, self.samples, self.step)
            self._clocks[edges] = steps
        drives = [waveforms.get(drive.name) for drive in self.system.drives()]
        return played(self.system, steps, drives)

    @cached_property
    def _clocks(self) -> dict[Edges, Steps]:
        return {}

    def _waveforms(self, signals: Mapping[str, Values], row: int) -> dict[str, AbstractWaveform]:
        """The waveforms of one run."""
        varied = {
            name: self.waveforms[name].with_values({p: float(v[row]) for p, v in table.items()})
            for name, table in signals.items()
        }
        return {**self.waveforms, **varied}

    def _refused(self, signals: Mapping[str, Values], count: int) -> Flags:
        """Runs whose waveforms are refused."""
        found = np.zeros(count, np.bool_)
        for name, table in signals.items():
            found |= refused(self.waveforms[name], table, count)
        return found
