"""The march in JAX: one scan over samples, one inside it over steps, any batch shape.

Parameters, drive and step lengths are data: changing them never recompiles. Intervals with
fewer steps than the longest are padded with steps of no length, which keep the state.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from martensite.kernels.jax_setup import WIDE_VECTORS, jax_namespace, make_storing_namespace
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.grid import TimeGrid
from martensite.simulate.lane_grid import LaneGrid
from martensite.simulate.marching import RunLimits


class ArrayGrid(NamedTuple):
    """A grid as arrays."""

    first: Any
    """Signals at t = 0, one per drive."""
    sampled: Any
    """Signals at the end of every interval, an array (intervals,) per drive."""
    drives: Any
    """What the drives bring in every step, an array (intervals, steps) per input."""
    lengths: Any
    """Length of every step [s], 0 for padding, (intervals, steps)."""
    one: Any
    """The number 1, unknown to the compiler: dividing by it makes a value worth keeping."""
    limits: Any = None
    """What no run leaves, low and high, (2, envelope); None where nobody looks."""


def build_schedule(
    grid: TimeGrid | LaneGrid, dtype: str = "float64", limits: RunLimits | None = None
) -> tuple[ArrayGrid, bool]:
    """The grid as padded arrays, and whether padding was needed.

    Signals and lengths of a `LaneGrid` have an axis of lanes behind the others.
    """
    first, rest, counts, drives, lengths = grid.arrays
    used = np.arange(int(counts.max())) < counts[:, None]

    def padded(values: Any) -> Any:
        made = np.zeros((*used.shape, *values.shape[1:]), dtype)
        made[used] = values
        return made

    signals = range(first.shape[1])
    bounds = None if limits is None else np.array(limits, dtype)
    schedule = ArrayGrid(
        tuple(first[0, d].astype(dtype) for d in signals),
        tuple(rest[:, d].astype(dtype) for d in signals),
        tuple(padded(drives[:, d]) for d in range(drives.shape[1])),
        padded(lengths),
        np.ones((), dtype),
        bounds,
    )
    return schedule, isinstance(grid, LaneGrid) or not bool(used.all())


class BatchRows(NamedTuple):
    """Outputs at the samples and the worst reports, over a batch."""

    outputs: tuple[Any, ...]
    """One array (samples, batch…) per output asked for."""
    reports: tuple[Any, ...]
    """The worst of every number that steps report, before the envelope was left."""
    left: Any = np.inf
    """Time [s] at the end of the step in which the envelope was left; infinite if it was not."""


def build_march(
    compiled: CompiledMarch, outputs: Sequence[int], padded: bool
) -> Callable[[Sequence[Any], ArrayGrid], BatchRows]:
    """A pure function of (parameter values, schedule) that marches and observes.

    It may be jitted, mapped and differentiated (forward mode) with JAX.
    """
    xp = jax_namespace()
    jax, np_ = xp.jax, xp.np

    def run(values: Sequence[Any], plan: ArrayGrid) -> BatchRows:
        functions = compiled.program.bind_arrays(make_storing_namespace(xp, plan.one), values)
        shape = np_.broadcast_shapes(*(np_.shape(v) for v in values))
        zero = np_.zeros(shape, plan.lengths.dtype)

        def observe(state: Any, signals: Any) -> tuple[Any, ...]:
            row = functions["observe"](*state, *signals)
            return tuple(zero + row[i] for i in outputs)

        def look(state: Any, signals: Any, time: Any, left: Any) -> Any:
            """When the envelope was left."""
            if plan.limits is None:
                return left
            row = functions["judge"](*state, *(signals[k] for k in compiled.signals_in_step()))
            for k in range(len(compiled.envelope)):
                value, (low, high) = row[len(compiled.convergence_scales) + k], plan.limits[:, k]
                inside = ((low <= value) & (value <= high)) | ~np_.isfinite(value)
                left = np_.where(inside | (left < np_.inf), left, time)
            return left

        def one(carry: Any, now: Any) -> tuple[Any, None]:
            state, worst, (time, left) = carry
            signals, dt = now
            found = functions["step"](*state, *signals, dt)
            after = [np_.broadcast_to(a, shape) for a in found[: compiled.size]]
            reports = found[compiled.size :]
            if padded:
                after = [xp.where(dt > 0.0, a, b) for a, b in zip(after, state, strict=True)]
                reports = [xp.where(dt > 0.0, r, 0.0) for r in reports]
            pairs = zip(worst, reports, strict=True)
            worst = tuple(np_.where((a >= b) | (left < np_.inf), a, b) for a, b in pairs)
            time = time + dt
            return (tuple(after), worst, (time, look(after, signals, time, left))), None

        def interval(carry: Any, now: Any) -> tuple[Any, tuple[Any, ...]]:
            signals, *steps = now
            carry, _ = jax.lax.scan(one, carry, tuple(steps))
            return carry, observe(carry[0], signals)

        state = tuple(zero + v for v in functions["init"](*plan.first))
        start = observe(state, plan.first)
        (_, reports, (_, left)), rows = jax.lax.scan(
            interval,
            (state, (zero,) * len(compiled.report), (zero, zero + np_.inf)),
            (plan.sampled, plan.drives, plan.lengths),
        )
        joined = tuple(np_.concatenate([a[None], b]) for a, b in zip(start, rows, strict=True))
        return BatchRows(joined, reports, left)

    return run


@lru_cache(maxsize=64)
def jitted_march(compiled: CompiledMarch, outputs: tuple[int, ...], padded: bool) -> Any:
    """The jitted march of a traced system, kept for the next call."""
    return jax_namespace().jax.jit(build_march(compiled, outputs, padded), compiler_options=WIDE_VECTORS)


@lru_cache(maxsize=64)
def jitted_jacobian(compiled: CompiledMarch, outputs: tuple[int, ...], wrt: tuple[int, ...], padded: bool) -> Any:
    """Jitted (values, plan) -> (first output, its Jacobian in the parameters `wrt`, residual)."""
    jax = jax_namespace().jax
    run = build_march(compiled, outputs, padded)

    def directions(values: Any, plan: ArrayGrid) -> tuple[Any, Any, Any]:
        def column(some: Any) -> tuple[Any, Any]:
            everything = values.at[np.asarray(wrt)].set(some)
            rows = run(list(everything), plan)
            return rows.outputs[0], (rows.outputs[0], rows.reports[0])

        some = values[np.asarray(wrt)]
        jacobian, (value, residual) = jax.jacfwd(column, has_aux=True)(some)
        return value, jacobian, residual

    return jax.jit(directions, compiler_options=WIDE_VECTORS)
