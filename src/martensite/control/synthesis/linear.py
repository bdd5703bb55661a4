"""The linear system of a plant around an operating point, exact and in discrete time.

    x_k+1 = A x_k + B u_k,    y_k = C x_k + D u_k

for deviations from rest, with signals held for a period. The derivatives are those of the step
itself, by dual numbers, and hold for the direction in which the plant got where it rests: on the
heating branch under a signal a little higher, on the cooling branch under one a little lower. In
the other direction it leaves the branch, at first with hardly any transformation: no linear
system holds for both. What a controller designed here does there, a run must show.

The flat state of a plant holds numbers that do not take part in small motions: the last turning point of the law, the
stress of the step before. `realise_readings` uses outputs that can be measured or estimated instead: with z = C_z x
for chosen outputs, A_z is the least-squares solution of

    C_z A v = A_z C_z v    for all v that signals reach,    v = B, A B, A² B, …

and the residual is 0 if the chosen outputs determine the small motions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from martensite.actuators.assembly import AbstractSystem, advance_steps
from martensite.base.errors import InputError, require_known
from martensite.identify.chains.linear_system import LinearSystem
from martensite.kernels import floats
from martensite.kernels.dual import Dual, DualNamespace
from martensite.kernels.namespace import Namespace
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import steps_in
from martensite.simulate.operating_point import SteadyPoint

PUSH = 1e-3
"""Change of the signal that says where it goes, over the signal."""
REACHED = 400
"""Samples after an impulse of which the reached states are taken."""
NOISE = 1e-9
"""Singular values below this share of the largest are rounding."""


def linearise_plant(
    point: SteadyPoint, period: float | None = None, *, inputs: Sequence[str] | None = None, push: float = PUSH
) -> LinearSystem:
    """Return the linear system around an operating point, with the flat state of the plant.

    Args:
        point: where the plant rests, and on which branch.
        period: time for which signals are held [s]; of a system in discrete time its own.
        inputs: names of drives; the one that is varied if none are given.
        push: by how much of itself the signal is raised (heating) or lowered (cooling).

    Raises:
        InputError: a name does not fit, or no period is given.
    """
    system = point.system
    names = [drive.name for drive in system.drives()]
    chosen = list(inputs or (point.drive,))
    for name in chosen:
        require_known("drive", name, names)
    interval = system.sample_time() or period
    if not interval or interval <= 0.0:
        raise InputError("A plant in continuous time is linearised for a period above 0 s.")
    way = 1.0 if point.direction == "heating" else -1.0
    signals = list(point.signals)
    signals[names.index(point.drive)] += way * push * max(abs(point.signal), 1e-3)
    size = len(point.state)
    rows = _differentiate_plant(system, [*point.state.tolist(), *signals], size, interval)
    columns = [size + names.index(name) for name in chosen]
    return LinearSystem(
        rows[:size, :size],
        rows[:size, columns],
        rows[size:, :size],
        rows[size:, columns],
        interval,
        np.array([point.signals[c - size] for c in columns]),
        point.state,
        np.array(list(point.outputs.values())[: len(rows) - size]),
        tuple(chosen),
        tuple(system.outputs()),
    )


def _differentiate_plant(system: AbstractSystem, at: list[float], size: int, interval: float) -> Numbers:
    """Return the derivatives of the next state and of the outputs now, by state and signals."""
    shape = NestedShape(system.init(floats, *at[size:]))
    turns = 1 if system.sample_time() else steps_in(system, interval)

    def period(xp: Namespace, numbers: Sequence[Any]) -> Sequence[Any]:
        state, drives = shape.rebuild(numbers[:size]), numbers[size:]
        after, _ = advance_steps(xp, system, state, [(drives, interval / turns)], turns)
        return [*flatten_numbers(after), *system.observe(xp, state, *drives)]

    return compute_slopes(period, at)[1]


def compute_slopes(
    function: Callable[[Any, Sequence[Any]], Sequence[Any]], at: Sequence[float]
) -> tuple[Numbers, Numbers]:
    """Return the values of a kernel and all their slopes, shape (values, variables), in one pass: tangents are rows."""
    xp, rows = DualNamespace(floats), np.eye(len(at))
    pairs = [xp.parts(one) for one in function(xp, [Dual(x, row, xp.level) for x, row in zip(at, rows, strict=True)])]
    slopes = [np.zeros(len(at)) if slope is None else slope + np.zeros(len(at)) for _, slope in pairs]
    return np.array([float(value) for value, _ in pairs]), np.stack(slopes)


@dataclass(frozen=True, eq=False)
class Readings:
    """A plant for small signals, in what can be read of it."""

    linear: LinearSystem
    """With the readings as states and as outputs."""
    residual: float
    """Share of their motion that these readings do not explain; 0 if they say all."""


def realise_readings(linear: LinearSystem, states: Sequence[str]) -> Readings:
    """Return a linear system whose states are some of its outputs.

    Args:
        linear: from `linearise_plant`.
        states: names of outputs. Such as only repeat each other do no harm.

    Raises:
        InputError: the output does not exist, or it jumps with the signal.
    """
    places = [_find_output(linear, name) for name in states]
    seen, direct = linear.c[places], linear.d[places]
    reached = _compute_reached(linear, seen)
    sizes = np.maximum(np.abs(reached).max(axis=(0, 2)), 1e-300)
    if np.any(np.abs(direct) > NOISE * sizes[:, None]):
        name = states[int(np.argmax(np.abs(direct).max(axis=1) / sizes))]
        raise InputError(f"`{name}` jumps with the signal, so that it is no state.")
    scaled = reached / sizes[:, None]
    now, then = (np.concatenate(list(part), axis=1) for part in (scaled[:-1], scaled[1:]))
    a = cast("Numbers", np.linalg.lstsq(now.T, then.T, rcond=NOISE)[0].T)
    left = float(np.linalg.norm(then - a @ now) / max(float(np.linalg.norm(then)), 1e-300))
    a, count = a * sizes[:, None] / sizes, len(places)
    inner = LinearSystem(
        a,
        seen @ linear.b,
        np.eye(count),
        np.zeros((count, linear.b.shape[1])),
        linear.interval,
        linear.inputs,
        linear.outputs[places],
        linear.outputs[places],
        linear.input_names,
        tuple(states),
    )
    return Readings(inner, left)


def _compute_reached(linear: LinearSystem, seen: Numbers) -> Numbers:
    """C_z Aᵏ B for all k, shape (samples, states, inputs)."""
    kept, found = linear.b, np.empty((REACHED, len(seen), linear.b.shape[1]))
    for k in range(REACHED):
        found[k] = seen @ kept
        kept = linear.a @ kept
    return found


def _find_output(linear: LinearSystem, name: str) -> int:
    require_known("output", name, linear.output_names)
    return linear.output_names.index(name)


def average_plants(parts: Sequence[Readings]) -> Readings:
    """Return the mean of linear systems with the same states, such as those of both branches."""
    each = [part.linear for part in parts]

    def mean(name: str) -> Any:
        return np.mean([getattr(one, name) for one in each], axis=0)

    means = {name: mean(name) for name in ("a", "b", "inputs", "state", "outputs")}
    return Readings(replace(each[0], **means), max(part.residual for part in parts))
