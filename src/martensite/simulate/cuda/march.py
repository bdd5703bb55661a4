"""Batches on given steps on a GPU, for the runtime `cuda` of `martensite.simulate.variants`.

Batches fill the free device memory. Only samples of requested outputs are copied back.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from martensite.base.errors import InputError, ParameterError
from martensite.simulate.cuda import device
from martensite.simulate.cuda.source import REPORTS, MarchSource
from martensite.simulate.cuda.to_ends import march_to_ends
from martensite.simulate.envelope import envelope_of, varied_stops
from martensite.simulate.grid import LaneGrid, TimeGrid
from martensite.simulate.native import spread_limits

if TYPE_CHECKING:
    from martensite.simulate.variants import Numbers, OnSteps, Values, VariantSetup

__all__ = ["count_together", "march_batch", "march_on_cuda", "march_to_ends"]
Rows: TypeAlias = "tuple[Numbers, Numbers, Numbers]"
OWN_SIGNALS = 1 << 28
"""Memory [bytes] for signals in a batch of runs with different signals."""
OWN_ROWS = 1 << 29
"""Memory [bytes] for samples in a batch of runs to a tolerance, which are stored twice."""


def count_together(course: VariantSetup, own: bool, count: int) -> int:
    """Return the batch size: all runs, or the number that fits in memory with individual signals.

    Raises:
        InputError: no device was found, or more than one device is requested.
    """
    if course.devices not in (1, None):
        raise ParameterError(f"The runtime `cuda` takes one device, but `devices` is {course.devices}.")
    device.open_device()
    if course.controlled:
        columns = len({*course.outputs, *course.system.convergence_scales()})
        return max(1, min(count, OWN_ROWS // (8 * columns * course.samples)))
    if not own:
        return count
    steps = course.duration / course.longest + course.samples
    each = steps * (course.compiled.inputs + 1) * np.dtype(float).itemsize
    return max(1, min(count, int(OWN_SIGNALS / each)))


def march_on_cuda(course: VariantSetup, values: Values, grid: TimeGrid | LaneGrid, runs: int) -> OnSteps:
    """Return columns (runs, samples), reports (2, runs), and times of leaving the envelope [s], (runs,).

    Raises:
        InputError: no device was found, or a run does not fit into its memory.
    """
    compiled, own_limits = course.compiled, bool(varied_stops(values))
    varied = tuple(place for place, path in enumerate(compiled.paths) if path in values)
    own_steps = isinstance(grid, LaneGrid)
    source = MarchSource(compiled, course.places, varied, course.precision, own_steps, own_limits)
    limits = np.array(envelope_of(course.system), float)
    if own_limits:
        limits = spread_limits(course.find_limits(values, runs), runs)
    table = np.array([values[compiled.paths[place]] for place in varied]).reshape(len(varied), runs)
    rows, reports, left = march_batch(source, compiled.values(course.system), table, grid, limits, course.chunk)
    return [rows[:, k].T for k in range(rows.shape[1])], reports, left


def march_batch(
    source: MarchSource, nominal: Any, table: Any, grid: TimeGrid | LaneGrid, limits: Any, chunk: int | None = None
) -> Rows:
    """Return rows (samples, outputs, runs), reports (2, runs), and times of leaving the envelope [s], (runs,).

    Args:
        source: source to compile.
        nominal: all parameters of the program; varied ones are ignored.
        table: the varied parameters, (varied, runs).
        grid: common or individual steps.
        limits: limits of the envelope, low and high, (2, envelope), with an axis of runs if they vary.
        chunk: batch size; by default limited by memory.
    """
    march, runs = load_march(source), table.shape[1]
    with device.DeviceMemory() as memory:
        chunk = chunk or march.count_fitting(memory.count_free(), len(grid.times), len(grid.arrays[-1]), runs)
    wholes = np.empty((len(grid.times), len(source.outputs), runs)), np.empty((REPORTS, runs)), np.empty(runs)
    for first in range(0, runs, chunk):
        some = slice(first, min(first + chunk, runs))
        signals = [a[..., some] if source.own_steps and a.ndim > 1 else a for a in grid.arrays]
        bounds = limits[..., some] if source.own_limits else limits
        batch = march.run(nominal, [table[:, some], *signals, bounds], [a.shape[:-1] for a in wholes], len(grid.counts))
        for whole, piece in zip(wholes, batch, strict=True):
            whole[..., some] = piece
    return wholes


class GivenStepsMarch:
    """Time integration on given steps on the device."""

    def __init__(self, source: MarchSource) -> None:
        self.source, self.program = source, device.DeviceProgram(source.text)

    def count_fitting(self, free: int, samples: int, steps: int, runs: int) -> int:
        """Return the number of runs that fit in the given number of bytes.

        Raises:
            InputError: a single run does not fit.
        """
        source, sizes = self.source, self.source.sizes
        signals = steps * (sizes["INPUTS"] + 1) + samples * sizes["DRIVES"]
        each = samples * sizes["OUTPUTS"] + sizes["VARIED"] + REPORTS + 2 * sizes["ENVELOPE"] * source.own_limits
        size = source.kind.itemsize
        free -= size * signals * (not source.own_steps)
        fitting = int(free / (8 + size * (each + signals * source.own_steps)))
        if fitting < 1:
            raise InputError(
                f"A run of {samples:,} samples does not fit into the GPU memory; take fewer `samples` or `outputs`."
            )
        return min(runs, fitting)

    def run(self, nominal: Any, given: Sequence[Any], shapes: Sequence[tuple[int, ...]], intervals: int) -> list[Any]:
        """Return rows, reports and exit times of a batch with individual values."""
        kind, runs = self.source.kind, given[0].shape[1]
        kinds = kind, kind, np.dtype(float)
        results = [np.empty((*shape, runs), k) for shape, k in zip(shapes, kinds, strict=True)]
        with device.DeviceMemory() as memory:
            prepared = memory.take(kind.itemsize * self.source.sizes["COMMON"])
            places = [ctypes.c_longlong(one) for one in (memory.give(np.array(nominal, kind)), prepared)]
            self.program.launch("prepare", 1, places)
            memory.move(prepared, self.program.locate("common"), kind.itemsize * self.source.sizes["COMMON"])
            arrays = (np.ascontiguousarray(a, np.int32 if a.dtype.kind == "i" else kind) for a in given)
            there = [memory.take(array.nbytes) for array in results]
            places = [ctypes.c_longlong(one) for one in (*map(memory.give, arrays), *there)]
            self.program.launch("march", runs, [ctypes.c_longlong(runs), ctypes.c_int(intervals), *places])
            for place, array in zip(there, results, strict=True):
                memory.fetch(place, array)
        return results


@lru_cache(maxsize=32)
def load_march(source: MarchSource) -> GivenStepsMarch:
    """Return the compiled program, cached."""
    return GivenStepsMarch(source)
