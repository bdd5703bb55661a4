"""Variants on JAX, shared among all devices that it has.

A block has as many runs as its devices take at a time: a chunk each, in the order of the runs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.simulate.arrays import ArrayGrid, build_schedule, jitted_march
from martensite.simulate.devices import chunk_for, devices_of, march_chunks
from martensite.simulate.envelope import envelope_of
from martensite.simulate.grid import TimeGrid
from martensite.simulate.lane_grid import LaneGrid
from martensite.simulate.marching import RunLimits

if TYPE_CHECKING:
    from martensite.simulate.variants import Numbers, Values, VariantSetup


class JaxMarch:
    """The march of a course on JAX."""

    def __init__(self, course: VariantSetup) -> None:
        self.course = course

    def __call__(
        self, values: Values, grid: TimeGrid | LaneGrid, runs: int
    ) -> tuple[list[Numbers], Numbers, Numbers]:
        """Columns (runs, samples), reports (3, runs), and when runs left the envelope (runs,).

        Chunks of a block go over the devices; variants of a waveform stay on the first.
        """
        devices = devices_of()[: 1 if isinstance(grid, LaneGrid) else None]
        limits = envelope_of(self.course.system)
        plan, padded = _build_schedule(grid, self.course.precision, limits)
        size = -(-runs // len(devices))
        table = [np.asarray(v, self.course.precision) for v in self.course.table(values)]
        chunks = (
            [np.resize(v[k : k + size], size) if v.ndim else v for v in table]
            for k in range(0, runs, size)
        )
        run = jitted_march(self.course.compiled, self.course.places, padded)
        pieces = list(march_chunks(run, chunks, plan, devices))
        columns = [
            np.concatenate([_by_run(piece.outputs[i], size) for piece in pieces])[:runs]
            for i in range(len(self.course.outputs))
        ]
        reports = [
            np.concatenate([np.broadcast_to(np.asarray(r), size) for r in each])[:runs]
            for each in zip(*(p.reports for p in pieces), strict=True)
        ]
        left = np.concatenate([np.broadcast_to(np.asarray(p.left), size) for p in pieces])[:runs]
        return columns, np.stack(reports).astype(np.float64), left.astype(np.float64)


def count_block() -> int:
    """Runs that march together on the devices that JAX has."""
    devices = devices_of()
    return chunk_for(devices) * len(devices)


def _by_run(column: Any, runs: int) -> Numbers:
    """A column (samples, runs) by run; one that is the same for all is repeated."""
    found: Numbers = np.asarray(column, np.float64)
    return np.broadcast_to(found if found.ndim == 2 else found[:, None], (len(found), runs)).T


def _build_schedule(
    grid: TimeGrid | LaneGrid, precision: str, limits: RunLimits
) -> tuple[ArrayGrid, bool]:
    """Arrays of a grid: signals and lengths by lane where lanes have their own."""
    if isinstance(grid, TimeGrid):
        return build_schedule(grid, precision, limits)
    shape = len(grid.counts), int(grid.counts.max())
    used = np.arange(shape[1]) < grid.counts[:, None]

    def padded(values: Any) -> Any:
        made = np.zeros((*shape, values.shape[-1]), precision)
        made[used] = values
        return made

    drives = tuple(padded(grid.drives[:, d]) for d in range(grid.drives.shape[1]))
    sampled = [grid.sampled[:, d].astype(precision) for d in range(grid.drives.shape[1])]
    first, rest = tuple(s[0] for s in sampled), tuple(s[1:] for s in sampled)
    one, bounds = np.ones((), precision), np.array(limits, precision)
    return ArrayGrid(first, rest, drives, padded(grid.lengths), one, bounds), True
