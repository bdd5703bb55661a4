"""The march in JAX: one scan over samples, one inside it over steps, any batch shape.

Parameters, drive and step lengths are data: changing them never recompiles. Intervals with
fewer steps than the longest are padded with steps of no length, which keep the state.

Chunks of a batch are dealt out in turn to the devices of JAX (processor cores, a GPU, or several) and
run side by side, the results are fetched in order. Some chunks are always under way, so that no device
waits for the host; no more than a few are, so that memory does not grow with the number of variants. A
chunk is computed by the same program on every device of a kind: which device has it changes nothing.

JAX sees a processor as one device unless it is told otherwise before it starts, by the environment
variable `XLA_FLAGS=--xla_force_host_platform_device_count=<cores>`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from martensite.base.errors import ParameterError
from martensite.kernels.jax_setup import WIDE_VECTORS, jax_namespace, make_storing_namespace
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.envelope import envelope_of
from martensite.simulate.grid import LaneGrid, TimeGrid
from martensite.simulate.march import judge_table
from martensite.simulate.marching import Marched, RunLimits

if TYPE_CHECKING:
    from martensite.simulate.variants import Numbers, Values, VariantSetup


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
    start: Any = None
    """State at the first sample; at rest if None."""


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

        begin = functions["init"](*plan.first) if plan.start is None else plan.start
        state = tuple(zero + v for v in begin)
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


def march_jax(
    compiled: CompiledMarch,
    values: Sequence[float],
    grid: TimeGrid,
    limits: RunLimits | None = None,
    start: Sequence[float] = (),
) -> Marched:
    """One run on JAX, with every output, from a start or from rest."""
    plan, padded = build_schedule(grid, limits=limits)
    plan = plan._replace(start=tuple(start) or None)
    rows = jitted_march(compiled, tuple(range(len(compiled.outputs))), padded)(values, plan)
    table = np.stack([np.asarray(column) for column in rows.outputs], axis=1)
    return judge_table(table, *map(float, rows.reports[:2]), left=float(rows.left))


# ---------------------------------------------------------------- many runs on many devices

CHUNKS = {"cpu": 256}
"""Variants marched together by kind of device: on a processor the state stays in its cache."""
WIDE_CHUNK = 32_768
"""The same on a device with thousands of lanes, which needs many variants to be busy."""
AHEAD = 2
"""Chunks under way on every device."""


def devices_of(count: int | None = None) -> list[Any]:
    """The first `count` devices of JAX, or all of them; `ParameterError` if there are not as many."""
    found = list(jax_namespace().jax.devices())
    if count is None:
        return found
    if not 1 <= count <= len(found):
        kinds = f"{len(found)} device{'s' if len(found) > 1 else ''} of kind {found[0].platform}"
        raise ParameterError(f"The batch is to run on {count} devices, but JAX has {kinds}.")
    return found[:count]


def chunk_for(devices: Sequence[Any]) -> int:
    """Variants marched together on devices of this kind, if nothing else is said."""
    return CHUNKS.get(devices[0].platform, WIDE_CHUNK)


def march_chunks(
    run: Callable[[Any, ArrayGrid], BatchRows], chunks: Iterable[Sequence[Any]], plan: ArrayGrid, devices: Sequence[Any]
) -> Iterator[BatchRows]:
    """March chunk after chunk, each on the next device, and yield the rows of each as arrays of numpy, in order.

    The run is a `jitted_march`; values of a chunk are made when a device is about to take it.
    """
    jax = jax_namespace().jax
    plans = [jax.device_put(plan, device) for device in devices]
    under_way: deque[BatchRows] = deque()
    for k, values in enumerate(chunks):
        if len(under_way) == AHEAD * len(devices):
            yield jax.device_get(under_way.popleft())
        place = k % len(devices)
        under_way.append(run(jax.device_put(list(values), devices[place]), plans[place]))
    while under_way:
        yield jax.device_get(under_way.popleft())


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
