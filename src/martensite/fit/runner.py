"""Runs of an experiment at given parameters: outputs, their derivatives, batches of variants.

In C where there is a compiler, with exact derivatives in all directions beside one run
(`simulate.native_slopes`); otherwise on plain floats, with differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.fit.experiment import Experiment
from martensite.kernels.c99 import find_compiler
from martensite.simulate.compiled import CompiledMarch, bind_march, compile_march
from martensite.simulate.grid import TimeGrid
from martensite.simulate.march import SOLVED, march_floats

LANES = 16
"""Variants that are marched together in a batch."""
SHIFT = 1e-6
"""Step of a difference, as a share of a direction."""


@dataclass(frozen=True)
class Seen:
    """Outputs of one run at the rows that are compared."""

    values: Any
    """(rows, outputs)"""
    slopes: Any
    """(rows, outputs, directions); no directions if none were asked for."""
    solved: bool


class Runner:
    """One experiment, ready to be run with any numbers."""

    def __init__(self, experiment: Experiment, step: float | None = None) -> None:
        self.experiment = experiment
        self.compiled: CompiledMarch = compile_march(experiment.system)
        self.paths = self.compiled.paths
        self.grid: TimeGrid = experiment.grid(step)
        self.first = len(self.grid.times) - len(experiment.times)
        names = self.compiled.outputs
        self.places = tuple(names.index(output) for output in experiment.outputs)
        self.native = find_compiler() is not None

    def run(self, values: Sequence[float], seeds: Any = None) -> Seen:
        """One run; `seeds` (parameters, directions) say in which directions to differentiate."""
        if not self.native:
            return self._floats(values, seeds)
        return self._run(values, seeds)

    def batch(self, variants: Any) -> Any:
        """Outputs (variants, rows, outputs) of many sets of values (variants, parameters).

        Runs that fail hold NaN.
        """
        if not self.native:
            seen = [self._floats(list(values), None) for values in variants]
            return np.stack([s.values if s.solved else np.nan * s.values for s in seen])
        pieces = [
            self._lanes(variants[first : first + LANES]) for first in range(0, len(variants), LANES)
        ]
        return np.concatenate(pieces)

    def _run(self, values: Sequence[float], seeds: Any) -> Seen:
        from martensite.simulate.native import march_lanes
        from martensite.simulate.native_slopes import march_slopes

        if seeds is None:
            rows, worst = march_lanes(self.compiled, values, self.grid, 1, self.places)
            rows, residual = rows[self.first :, :, 0], float(worst[0, 0])
            slopes = np.zeros((*rows.shape, 0))
        else:
            found = march_slopes(self.compiled, values, seeds, self.grid, self.places)
            rows, slopes = found.rows[self.first :], found.slopes[self.first :]
            residual = found.residual
        finite = bool(np.isfinite(rows).all() and np.isfinite(slopes).all())
        return Seen(rows, slopes, residual <= SOLVED and finite)

    def _lanes(self, variants: Any) -> Any:
        from martensite.simulate.native import march_lanes

        count = len(variants)
        padded = np.pad(variants, ((0, LANES - count), (0, 0)), mode="edge")
        rows, worst = march_lanes(self.compiled, list(padded.T), self.grid, LANES, self.places)
        rows = np.moveaxis(rows[self.first :], 2, 0)
        bad = ~(worst[0] <= SOLVED) | ~np.isfinite(rows).all(axis=(1, 2))
        rows[bad] = np.nan
        return rows[:count]

    def _floats(self, values: Sequence[float], seeds: Any) -> Seen:
        found = self._march(values)
        if seeds is None or not found.solved:
            return found
        slopes = np.zeros((*found.values.shape, seeds.shape[1]))
        for k, seed in enumerate(np.asarray(seeds).T):
            ends = [self._march(np.asarray(values) + s * SHIFT * seed) for s in (1.0, -1.0)]
            if not all(end.solved for end in ends):
                return Seen(found.values, slopes, False)
            slopes[:, :, k] = (ends[0].values - ends[1].values) / (2.0 * SHIFT)
        return Seen(found.values, slopes, True)

    def _march(self, values: Any) -> Seen:
        """One run on plain floats."""
        system = self.experiment.system.rebuilt(
            dict(zip(self.paths, map(float, values), strict=True))
        )
        track = march_floats(*bind_march(system), self.grid)
        rows = np.asarray(track.rows)[self.first :, list(self.places)]
        solved = not track.status.failed and len(track.rows) == len(self.grid.times)
        return Seen(rows, np.zeros((*rows.shape, 0)), solved)
