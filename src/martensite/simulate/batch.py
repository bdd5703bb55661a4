"""Batches of variants, and exact derivatives of any output."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import CompileError, InputError, ParameterError, SolveError, require_known
from martensite.base.files import tell_once
from martensite.base.parameters import resolve_path
from martensite.base.status import Status
from martensite.kernels.compiler import find_compiler
from martensite.simulate.api import check_run
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.drive_waveforms import Waveforms, by_name, grid_of
from martensite.simulate.ensembles import Ensemble
from martensite.simulate.march import classify_step
from martensite.simulate.measures.extremes import Largest, Smallest
from martensite.simulate.native_slopes import march_slopes
from martensite.simulate.result import Result, Variants
from martensite.simulate.start_report import describe_batch_start
from martensite.simulate.variants import NAMES, RUNTIMES, VariantSetup


@dataclass(frozen=True)
class OutputSensitivity:
    """Output over time and its derivatives with respect to parameters."""

    times: Any
    column: Any
    """Output in SI, (samples,)."""
    slopes: dict[str, Any]
    """d(output)/d(parameter) by full parameter path, (samples,)."""

    def of_range(self) -> dict[str, Any]:
        """Return the derivative of the range of the output (stroke for a position)."""
        top, bottom = np.argmax(self.column), np.argmin(self.column)
        return {path: slope[top] - slope[bottom] for path, slope in self.slopes.items()}


def simulate_batch(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    over: Mapping[str, Sequence[float]],
    *,
    tolerance: float = 1e-4,
    step: float | None = None,
    samples: int = 1001,
    outputs: Sequence[str] = ("position",),
    runtime: str = "auto",
    chunk: int | None = None,
    precision: str = "float64",
    devices: int | None = 1,
) -> Result:
    """Simulate variants of a system that differ in the parameters named in `over`.

    Every run has its own step size control and error bound, as in `simulate`. A run that fails or leaves the
    envelope keeps its earlier samples. With `step` given, runs use equal steps without error estimation.

    Args:
        system: the system at its nominal parameters.
        waveform: drive signal, the same for all variants.
        duration: length of the runs [s].
        over: parameter path (or unique ending) -> one value per variant, in SI.
        tolerance: accepted error of temperatures, martensite fractions, stresses and coordinates,
            as a fraction of the range of each, or of the least range that counts.
        step: longest of equal steps [s]; if given, nothing is estimated.
        samples: number of equidistant samples returned, both ends included.
        outputs: names of the columns to return.
        runtime: `c`, `floats`, `cuda` (a GPU of NVIDIA; the extra `cuda`), or `auto`: C if
            there is a compiler, else floats.
        chunk: variants marched together on CUDA; by default as many as its memory holds.
        precision: float64, or float32 for sweeps on CUDA (never for finite differences).
        devices: how many threads of C share the runs; all cores if None.

    Raises:
        InputError: unknown parameter or output, value out of range, unequal lengths, or an argument
            that does not fit the runtime.
    """
    check_run(duration, tolerance, step, samples)
    if devices is not None and devices < 1:
        raise ParameterError(f"Argument `devices` must be at least 1, but is {devices}.")
    varied = _convert_varied(system, over)
    chosen = _choose_runtime(runtime)
    _find_indices(compile_march(system), outputs)
    system_outputs = [name for name in outputs if name in system.outputs()]
    course = VariantSetup(
        system,
        by_name(system, waveform),
        duration,
        samples,
        step,
        tuple(outputs),
        chosen,
        precision,
        tolerance=tolerance,
        devices=devices,
        chunk=chunk,
        measures=tuple(one(of=name) for name in system_outputs for one in (Smallest, Largest)),
    )
    try:
        ran = course.run(varied)
    except CompileError as error:
        if runtime != "auto":
            raise
        tell_once(f"Warning: the batch goes on on floats. {error}")
        chosen = "floats"
        ran = replace(course, runtime=chosen).run(varied)
    return _build_result(system, waveform, course.times, ran, varied, tolerance if course.controlled else None, chosen)


def _build_result(
    system: AbstractSystem,
    waveform: Waveforms,
    times: Sequence[float],
    ran: Ensemble,
    varied: Mapping[str, Any],
    tolerance: float | None,
    runtime: str,
) -> Result:
    """Build the result of a batch, with warnings for incomplete runs and for runs that missed a tolerance."""
    status = [Status(one) for one in ran.status.tolist()]
    measured = (name for name in ran.columns if name in system.outputs())
    ends = {name: (ran.numbers[2 * k], ran.numbers[2 * k + 1]) for k, name in enumerate(measured)}
    variants = Variants(varied, status, ran.ended, None if tolerance is None else ran.accuracy, ends)
    lost = sum(one.failed or one is Status.OUT_OF_ENVELOPE for one in status)
    notes = [f"Warning: {lost} of {len(status)} variants ended early."] if lost else []
    missed = 0 if tolerance is None else int((ran.accuracy > tolerance).sum())
    if missed:
        notes.append(
            f"Warning: {missed} of {len(status)} variants missed the tolerance of {tolerance:.1e}; `variants.accuracy` "
            "has their bounds, and a run of one variant reports the reason."
        )
    return Result(
        system,
        waveform,
        np.array(times, float),
        ran.columns,
        max(status),
        None,
        0,
        math.nan,
        notes=notes,
        runtime=NAMES.get(runtime, runtime),
        variants=variants,
        begin=describe_batch_start,
    )


def _choose_runtime(runtime: str) -> str:
    """Return the runtime of a batch: `auto` is C if there is a compiler, else floats."""
    require_known("runtime", runtime, ("auto", *RUNTIMES))
    if runtime != "auto":
        return runtime
    return "floats" if find_compiler() is None else "c"


def compute_sensitivity(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    wrt: Sequence[str],
    *,
    step: float,
    output: str = "position",
    samples: int = 1001,
) -> OutputSensitivity:
    """Compute exact derivatives of an output over time with respect to parameters.

    Forward-mode differentiation includes latent heat and mechanism.

    Args:
        system: the system at its nominal parameters.
        waveform: drive signal.
        duration: length of the run [s].
        wrt: parameter paths (or unique endings).
        step: longest of equal steps [s].
        output: name of the differentiated column.
        samples: number of equidistant samples, both ends included.

    Raises:
        InputError: unknown parameter or output.
        CompileError: no C compiler was found.
        SolveError: the run failed.
    """
    if not step > 0.0:
        raise ParameterError(f"Argument `step` must be above 0 s, but is {step}.")
    compiled = compile_march(system)
    (place,) = _find_indices(compiled, [output])
    rows = [compiled.paths.index(path) for path in (system.resolve(name) for name in wrt)]
    grid = grid_of(system, waveform, duration, samples, step)
    if find_compiler() is None:
        raise CompileError(
            "Derivatives need a C compiler and none was found; install gcc or clang, or `pip install 'martensite[cc]'`."
        )
    seeds = np.zeros((len(compiled.paths), len(rows)))
    seeds[rows, range(len(rows))] = 1.0
    run = march_slopes(compiled, compiled.values(system), seeds, grid, [place])
    slopes = run.slopes[:, 0, :]
    status = classify_step(run.residual if np.isfinite(slopes).all() else math.nan, 0.0)
    if status.failed:
        raise SolveError(f"The run failed, so it has no derivatives. {status.sentence}")
    named = {compiled.paths[row]: slopes[:, i] for i, row in enumerate(rows)}
    return OutputSensitivity(np.linspace(0.0, duration, samples), run.rows[:, 0], named)


def _find_indices(compiled: CompiledMarch, outputs: Sequence[str]) -> tuple[int, ...]:
    for name in outputs:
        require_known("output", name, compiled.outputs)
    return tuple(compiled.outputs.index(name) for name in outputs)


def _convert_varied(system: AbstractSystem, over: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    """Return the varied parameters by full path, as arrays of equal length within their bounds."""
    leaves = {leaf.path: leaf for leaf in system.leaves()}
    paths = list(leaves)
    varied = {resolve_path(name, paths): np.asarray(values, float) for name, values in over.items()}
    sizes = {path: values.size for path, values in varied.items()}
    if len(set(sizes.values())) != 1 or 0 in sizes.values():
        counts = ", ".join(f"`{path}` {size}" for path, size in sizes.items()) or "there is none"
        raise InputError(f"Varied parameters must have equal numbers of values, at least one: {counts}.")
    for path, values in varied.items():
        for extreme in (float(values.min()), float(values.max())):
            leaves[path].declared.convert(leaves[path].owner, path, extreme)
    return varied
