"""Batches and gradients on JAX: many variants at once, exact derivatives of any output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.errors import InputError, ParameterError, SolveError, UnknownNameError
from martensite.simulate.arrays import Schedule, jitted_jacobian, jitted_march, schedule
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.devices import chunk_for, devices_of, march_chunks
from martensite.simulate.driven import Waveforms, grid_of
from martensite.simulate.grid import Grid
from martensite.simulate.march import Track, classify, track_of
from martensite.status import Status
from martensite.system import AbstractSystem

PRECISIONS = ("float64", "float32")


@dataclass(frozen=True)
class Batch:
    """Outputs of many variants; failures are rows with a status, never a lost batch."""

    times: Any
    """Sample times [s], (samples,)."""
    columns: dict[str, Any]
    """One array (variants, samples) per output asked for, in SI units."""
    status: list[Status]
    """Worst status of each variant."""


@dataclass(frozen=True)
class Sensitivity:
    """One output over time and its derivatives with respect to parameters."""

    times: Any
    column: Any
    """The output, (samples,), in SI units."""
    slopes: dict[str, Any]
    """d(output)/d(parameter) by full parameter path, (samples,)."""

    def of_range(self) -> dict[str, float]:
        """Derivative of the output's range (for the position: of the stroke)."""
        high, low = int(np.argmax(self.column)), int(np.argmin(self.column))
        return {path: float(slope[high] - slope[low]) for path, slope in self.slopes.items()}


def simulate_batch(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    over: Mapping[str, Sequence[float]],
    *,
    step: float,
    samples: int = 1001,
    outputs: Sequence[str] = ("position",),
    chunk: int | None = None,
    precision: str = "float64",
    devices: int | None = 1,
) -> Batch:
    """Run variants of a system that differ in the parameters named in `over`.

    Args:
        system: the system at its nominal parameters.
        waveform: drive signal, the same for all variants.
        duration: length of the runs [s].
        over: parameter path (or unique ending) -> one value per variant, in SI.
        step: longest step [s]; choose it by a run of `simulate` with a tolerance.
        samples: number of equidistant samples returned, both ends included.
        outputs: names of the columns to return.
        chunk: variants marched together; by default 256 on a processor, which keeps the state in
            its cache, and many more on a GPU.
        precision: float64, or float32 for sweeps (never for finite differences).
        devices: how many devices of JAX share the chunks; all of them if None.

    Raises:
        InputError: unknown parameter or output, value out of range, unequal lengths.
    """
    if precision not in PRECISIONS:
        raise InputError(f"Argument `precision` must be float64 or float32, but is `{precision}`.")
    compiled = compile_march(system)
    varied = _varied(system, over)
    count = len(next(iter(varied.values())))
    plan, padded = _plan(system, waveform, duration, samples, step, precision)
    run = jitted_march(compiled, _indices(compiled, outputs), padded)
    values = dict(zip(compiled.paths, compiled.values(system), strict=True))
    taken = devices_of(devices)
    size = chunk or chunk_for(taken)
    chunks = (
        _values(values, varied, slice(first, first + size), size, precision)
        for first in range(0, count, size)
    )
    pieces = list(march_chunks(run, chunks, plan, taken))
    columns = {
        name: np.concatenate([p.outputs[i].T for p in pieces])[:count]
        for i, name in enumerate(outputs)
    }
    reports = zip(
        *(np.concatenate([p.reports[k] for p in pieces])[:count] for k in range(2)), strict=True
    )
    status = [classify(float(r), float(c)) for r, c in reports]
    return Batch(np.linspace(0.0, duration, samples), columns, _checked(status, columns))


def sensitivity(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    wrt: Sequence[str],
    *,
    step: float,
    output: str = "position",
    samples: int = 1001,
) -> Sensitivity:
    """Exact derivatives of an output over time with respect to parameters.

    Forward-mode differentiation through the march, latent heat and mechanism included.

    Raises:
        InputError: unknown parameter or output.
        SolveError: the run at the nominal parameters failed.
    """
    compiled = compile_march(system)
    paths = tuple(system.resolve(name) for name in wrt)
    plan, padded = _plan(system, waveform, duration, samples, step, "float64")
    run = jitted_jacobian(
        compiled, _indices(compiled, [output]),
        tuple(compiled.paths.index(path) for path in paths), padded,
    )  # fmt: skip
    values = np.asarray(compiled.values(system))
    column, slopes, residual = (np.asarray(a) for a in run(values, plan))
    status = classify(float(residual), 0.0)
    if status.failed or not np.isfinite(slopes).all():
        raise SolveError(f"The run to be differentiated failed. {status.sentence}")
    named = {path: slopes[:, i] for i, path in enumerate(paths)}
    return Sensitivity(np.linspace(0.0, duration, samples), column, named)


def march_jax(compiled: CompiledMarch, values: Sequence[float], grid: Grid) -> Track:
    """One run on JAX, with every output."""
    plan, padded = schedule(grid)
    rows = jitted_march(compiled, tuple(range(len(compiled.outputs))), padded)(values, plan)
    table = np.stack([np.asarray(column) for column in rows.outputs], axis=1)
    return track_of(table, *map(float, rows.reports))


def _plan(
    system: AbstractSystem, waveform: Waveforms, duration: float, samples: int, step: float,
    precision: str,
) -> tuple[Schedule, bool]:  # fmt: skip
    if not step > 0.0:
        raise ParameterError(f"Argument `step` must be above 0 s, but is {step}.")
    return schedule(grid_of(system, waveform, duration, samples, step), precision)


def _indices(compiled: CompiledMarch, outputs: Sequence[str]) -> tuple[int, ...]:
    for name in outputs:
        if name not in compiled.outputs:
            raise UnknownNameError("output", name, compiled.outputs)
    return tuple(compiled.outputs.index(name) for name in outputs)


def _varied(system: AbstractSystem, over: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    """The varied parameters by full path, as arrays of equal length within their bounds."""
    leaves = {leaf.path: leaf for leaf in system.leaves()}
    varied = {system.resolve(name): np.asarray(values, float) for name, values in over.items()}
    sizes = {path: values.size for path, values in varied.items()}
    if len(set(sizes.values())) != 1 or 0 in sizes.values():
        raise InputError(f"Varied parameters must have equally many values, but have {sizes}.")
    for path, values in varied.items():
        for extreme in (float(values.min()), float(values.max())):
            leaves[path].declared.convert(leaves[path].owner, path, extreme)
    return varied


def _values(
    values: Mapping[str, float], varied: Mapping[str, Any], window: slice, chunk: int,
    precision: str,
) -> list[Any]:  # fmt: skip
    """All parameter values of one chunk, padded to its size by the last variant."""

    def piece(path: str) -> Any:
        part = varied[path][window]
        return np.pad(part, (0, chunk - part.size), mode="edge").astype(precision)

    return [piece(p) if p in varied else np.asarray(v, precision) for p, v in values.items()]


def _checked(status: list[Status], columns: Mapping[str, Any]) -> list[Status]:
    finite = np.logical_and.reduce([np.isfinite(c).all(axis=1) for c in columns.values()])
    return [s if ok else Status.NOT_FINITE for s, ok in zip(status, finite, strict=True)]
