"""Linear system of a plant around an operating point, exact and in discrete time.

    x_k+1 = A x_k + B u_k,    y_k = C x_k + D u_k

for deviations from the steady state, with signals held for a period. The derivatives of the step by dual numbers hold
for the direction in which the operating point was reached: for a slightly higher signal on the heating branch, for a
slightly lower one on the cooling branch. In the other direction the plant leaves the branch with hardly any
transformation, so that no linear system holds for both. Test a design in a run.

The flat state of a plant holds values without a part in small motions, such as the last turning point of the law.
`realise_readings` uses outputs that can be measured or estimated instead: with z = C_z x for chosen outputs, A_z is the
least-squares solution of

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
"""Relative change of the signal that selects the branch."""
REACHED = 400
"""Number of samples after an impulse in the set of reached states."""
NOISE = 1e-9
"""Singular values over the largest below which they are rounding."""


def linearise_plant(
    point: SteadyPoint, period: float | None = None, *, inputs: Sequence[str] | None = None, push: float = PUSH
) -> LinearSystem:
    """Return the linear system around an operating point, with the flat state of the plant.

    Args:
        point: steady state with its branch.
        period: time for which signals are held [s]; default: the period of a system in discrete time.
        inputs: names of drives; default: the varied drive.
        push: relative increase (heating) or decrease (cooling) of the signal.

    Raises:
        InputError: a name does not fit, or there is no period.
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
    """Return the derivatives of the next state and of the present outputs, by state and signals."""
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
    """Return the values of a kernel and all their slopes, shape (values, variables), in one pass."""
    xp, rows = DualNamespace(floats), np.eye(len(at))
    pairs = [xp.parts(one) for one in function(xp, [Dual(x, row, xp.level) for x, row in zip(at, rows, strict=True)])]
    slopes = [np.zeros(len(at)) if slope is None else slope + np.zeros(len(at)) for _, slope in pairs]
    return np.array([float(value) for value, _ in pairs]), np.stack(slopes)


@dataclass(frozen=True, eq=False)
class Readings:
    """A plant for small signals with readings as its states."""

    linear: LinearSystem
    """System with the readings as states and outputs."""
    residual: float
    """Fraction of the motion of the readings that they do not determine."""


def realise_readings(linear: LinearSystem, states: Sequence[str]) -> Readings:
    """Return a linear system whose states are some of its outputs.

    Args:
        linear: system from `linearise_plant`.
        states: names of outputs; redundant outputs are allowed.

    Raises:
        InputError: an output does not exist, or jumps with the signal.
    """
    places = [_find_output(linear, name) for name in states]
    output_rows, direct = linear.c[places], linear.d[places]
    reached = _compute_reached(linear, output_rows)
    sizes = np.maximum(np.abs(reached).max(axis=(0, 2)), 1e-300)
    if np.any(np.abs(direct) > NOISE * sizes[:, None]):
        name = states[int(np.argmax(np.abs(direct).max(axis=1) / sizes))]
        raise InputError(f"`{name}` jumps with the signal, so that it is no state.")
    scaled = reached / sizes[:, None]
    now, then = (np.concatenate(list(part), axis=1) for part in (scaled[:-1], scaled[1:]))
    a = cast("Numbers", np.linalg.lstsq(now.T, then.T, rcond=NOISE)[0].T)
    residual = float(np.linalg.norm(then - a @ now) / max(float(np.linalg.norm(then)), 1e-300))
    a, count = a * sizes[:, None] / sizes, len(places)
    inner = LinearSystem(
        a,
        output_rows @ linear.b,
        np.eye(count),
        np.zeros((count, linear.b.shape[1])),
        linear.interval,
        linear.inputs,
        linear.outputs[places],
        linear.outputs[places],
        linear.input_names,
        tuple(states),
    )
    return Readings(inner, residual)


def _compute_reached(linear: LinearSystem, output_rows: Numbers) -> Numbers:
    """Return C_z Aᵏ B for all k, shape (samples, states, inputs)."""
    motion, reached = linear.b, np.empty((REACHED, len(output_rows), linear.b.shape[1]))
    for k in range(REACHED):
        reached[k] = output_rows @ motion
        motion = linear.a @ motion
    return reached


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
