"""Variants on JAX, in chunks that are shared among the devices that it has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.simulate.arrays import build_schedule, jitted_march
from martensite.simulate.devices import chunk_for, devices_of, march_chunks
from martensite.simulate.envelope import envelope_of
from martensite.simulate.grid import TimeGrid
from martensite.simulate.lane_grid import LaneGrid

if TYPE_CHECKING:
    from martensite.simulate.variants import Numbers, Values, VariantSetup


def march_on_jax(
    course: VariantSetup, values: Values, grid: TimeGrid | LaneGrid, runs: int
) -> tuple[list[Numbers], Numbers, Numbers]:
    """Columns (runs, samples), reports (3, runs), and when runs left the envelope (runs,).

    Chunks go over the devices in the order of the runs, and the last is filled up; variants of a
    waveform stay together on the first device.
    """
    devices = devices_of(course.devices)
    size = course.chunk or -(-runs // len(devices))
    if isinstance(grid, LaneGrid):
        devices, size = devices[:1], runs
    schedule, padded = build_schedule(grid, course.precision, envelope_of(course.system))
    table = [np.asarray(v, course.precision) for v in course.table(values)]
    chunks = ([_cut_chunk(v, first, size) if v.ndim else v for v in table] for first in range(0, runs, size))
    run = jitted_march(course.compiled, course.places, padded)
    pieces = list(march_chunks(run, chunks, schedule, devices))

    columns = [
        np.concatenate([_by_run(piece.outputs[i], size) for piece in pieces])[:runs] for i in range(len(course.outputs))
    ]
    reports = [
        np.concatenate([np.broadcast_to(np.asarray(r), size) for r in each])[:runs]
        for each in zip(*((*piece.reports, piece.left) for piece in pieces), strict=True)
    ]
    *worst, left = (np.asarray(report, np.float64) for report in reports)
    return columns, np.stack(worst), left


def count_block(devices: int | None) -> int:
    """Runs that march together on so many devices of JAX, on all that it has if None."""
    taken = devices_of(devices)
    return chunk_for(taken) * len(taken)


def _cut_chunk(column: Any, first: int, size: int) -> Any:
    """A piece of a column, filled up by its last number."""
    piece = column[first : first + size]
    return np.pad(piece, (0, size - len(piece)), mode="edge")


def _by_run(column: Any, runs: int) -> Numbers:
    """A column (samples, runs) by run; one that is the same for all is repeated."""
    found: Numbers = np.asarray(column, np.float64)
    return np.broadcast_to(found if found.ndim == 2 else found[:, None], (len(found), runs)).T
