"""Runs of one system for many parameter sets: batches of outputs, and exact derivatives of one run.

All parameters of a system on fixed steps are inputs of one program. In C, batches run in parallel, and derivatives are
integrated with the values (`martensite.simulate.native_slopes`). Without a compiler, runs use plain floats, and
derivatives are central differences.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.kernels.compiler import find_compiler
from martensite.simulate.compiled import CompiledMarch, bind_march, compile_march
from martensite.simulate.grid import LaneGrid, TimeGrid
from martensite.simulate.march import SOLVED, march_floats

Numbers: TypeAlias = NDArray[np.float64]
LANES = 16
"""Number of runs per batch."""
DIFFERENCE = 1e-6
"""Step of a difference, as a fraction of a direction."""


class BatchRunner:
    """Runner of a system on given steps, for any parameters."""

    def __init__(
        self,
        system: AbstractSystem,
        grid: TimeGrid,
        outputs: Sequence[str],
        *,
        first: int = 0,
        native: bool | None = None,
    ) -> None:
        """Prepare runs of a system, or of a bench with its loops, with outputs from sample `first` on.

        `native` selects C; the default is C if there is a compiler.
        """
        self.system, self.grid, self.first = system, grid, first
        self.native = find_compiler() is not None if native is None else native
        self.compiled: CompiledMarch = compile_march(system)
        self.paths = self.compiled.paths
        self.base = np.array(self.compiled.values(system))
        """Parameters of the system, (parameters,)."""
        self.outputs = tuple(outputs)
        self._places = [self.compiled.outputs.index(name) for name in self.outputs]

    def with_grid(self, grid: TimeGrid) -> BatchRunner:
        """Return a runner with other steps or other signals."""
        runner = copy(self)
        runner.grid = grid
        return runner

    def place(self, path: str) -> int:
        """Return the index of a parameter in a row of a table."""
        return self.paths.index(path)

    def table(self, values: Mapping[str, Any], count: int) -> Numbers:
        """Return the parameters of runs (count, parameters), with changes by path."""
        table = np.repeat(self.base[None, :], count, axis=0)
        for path, column in values.items():
            table[:, self.place(path)] = column
        return table

    def run_many(self, table: Numbers) -> Numbers:
        """Return the outputs (runs, samples, outputs) of a table (runs, parameters); NaN for failed runs."""
        if not self.native:
            runs = [self._march_floats(row) for row in table]
            failed = np.full((self._samples, len(self.outputs)), np.nan)
            return np.stack([failed if rows is None else rows for rows in runs])
        pieces = [self._march_lanes(table[k : k + LANES]) for k in range(0, len(table), LANES)]
        return np.concatenate(pieces)

    def run_one(self, values: Numbers) -> Numbers | None:
        """Return the outputs (samples, outputs) of one run; None if it fails."""
        if not self.native:
            return self._march_floats(values)
        from martensite.simulate.native import march_lanes

        given = values.tolist(), self.grid, 1, self._places
        rows, worst = march_lanes(self.compiled, *given)
        outputs = rows[self.first :, :, 0]
        return outputs if worst[0, 0] <= SOLVED and np.isfinite(outputs).all() else None

    def run_driven(self, values: Numbers, grid: LaneGrid) -> Numbers:
        """Compute outputs (batch, samples, outputs) of one parameter set, with signals by element; NaN if it fails."""
        if self.native:
            return self._judge_lanes(list(np.repeat(values[:, None], LANES, axis=1)), grid)
        runs = [self._march_floats(values, grid.lane(lane)) for lane in range(grid.lengths.shape[1])]
        failed = np.full((self._samples, len(self.outputs)), np.nan)
        return np.stack([failed if rows is None else rows for rows in runs])

    def run_lanes(self, table: Numbers, grid: LaneGrid) -> Numbers:
        """Compute outputs (batch, samples, outputs) of a table (batch, parameters) in C."""
        return self._judge_lanes(list(table.T), grid)

    def run_slopes(self, values: Numbers, seeds: Numbers) -> tuple[Numbers, Numbers] | None:
        """Return a run with derivatives (samples, outputs, directions) for seeds (parameters, directions), or None."""
        if not self.native:
            return self._difference(values, seeds)
        from martensite.simulate.native_slopes import march_slopes

        run = march_slopes(self.compiled, values.tolist(), seeds, self.grid, self._places)
        rows, slopes = run.rows[self.first :], run.slopes[self.first :]
        finite = np.isfinite(rows).all() and np.isfinite(slopes).all()
        return (rows, slopes) if run.residual <= SOLVED and finite else None

    @property
    def _samples(self) -> int:
        return len(self.grid.times) - self.first

    def _march_lanes(self, table: Numbers) -> Numbers:
        padded = np.pad(table, ((0, LANES - len(table)), (0, 0)), mode="edge")
        return self._judge_lanes(list(padded.T), self.grid)[: len(table)]

    def _judge_lanes(self, values: list[Numbers], grid: TimeGrid | LaneGrid) -> Numbers:
        from martensite.simulate.native import march_lanes

        rows, worst = march_lanes(self.compiled, values, grid, LANES, self._places)
        outputs = np.moveaxis(rows[self.first :], 2, 0)
        outputs[~(worst[0] <= SOLVED) | ~np.isfinite(outputs).all(axis=(1, 2))] = np.nan
        return outputs

    def _march_floats(self, values: Numbers, grid: TimeGrid | None = None) -> Numbers | None:
        grid = grid or self.grid
        system = self.system.rebuilt(dict(zip(self.paths, values.tolist(), strict=True)))
        track = march_floats(*bind_march(system), grid)
        if track.status.failed or len(track.rows) != len(grid.times):
            return None
        return np.asarray(track.rows)[self.first :, self._places]

    def _difference(self, values: Numbers, seeds: Numbers) -> tuple[Numbers, Numbers] | None:
        rows = self._march_floats(values)
        if rows is None:
            return None
        slopes = np.zeros((*rows.shape, seeds.shape[1]))
        for k, seed in enumerate(seeds.T):
            up, down = (self._march_floats(values + s * DIFFERENCE * seed) for s in (1.0, -1.0))
            if up is None or down is None:
                return None
            slopes[:, :, k] = (up - down) / (2.0 * DIFFERENCE)
        return rows, slopes
