"""A controller for small changes of what it reads: slopes of its kernel, and where it rests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from martensite.base.errors import InputError
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.findings import list_limits
from martensite.control.synthesis.linear import compute_slopes
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Numbers

WIDE = 1e9
"""Limit of the signal so wide that it does not act."""
SHAPED = "manual", "shaping", "slew"
"""Parts that controllers may have around them, and that have no linear system."""
ROUNDS, LEFT = 30, 1e-9
"""Rounds of the search for the memory at rest, and largest remaining change of the memory, over the signal."""
SAME = 1e-11
"""Relative difference of two references that is rounding."""
LEAST_SIGNAL = 1e-3
"""Size of a signal that is as small as any."""


def free_limits(controller: AbstractController) -> AbstractController:
    """Return a controller whose signal has no limits, and whose reference is not shaped."""
    ends = {path: WIDE if path.endswith("high") else -WIDE for path in list_limits(controller)}
    return controller.with_values(ends).with_parts(**{name: None for name in SHAPED if name in controller.declarations})


def remember_first(controller: AbstractController, reference: float, readings: Mapping[str, float]) -> list[float]:
    """Return the memory of a controller before its second sample, with its filters, shaping and slew limit."""
    return [float(one) for one in controller.begin(floats, reference, readings)[1]]


def answer_sample(
    controller: AbstractController,
    xp: Any,
    memory: Sequence[Any],
    reference: Any,
    readings: Mapping[str, Any],
    dt: float,
) -> list[Any]:
    """Return the signal of a sample and what is remembered, with what stands around the controller."""
    signal, after = controller.proceed(xp, tuple(memory), reference, readings, dt)
    return [signal, *after]


def list_step_answers(
    controller: AbstractController, readings: Mapping[str, float], dt: float, samples: int
) -> list[float]:
    """Return changes of the signal after a step of the reading, per its unit: at once, and in the samples behind."""
    free, name = free_limits(controller), controller.measured
    memory = remember_first(free, readings[name], readings)

    def answer(xp: Any, x: Sequence[Any]) -> list[Any]:
        moved = {**readings, name: readings[name] + x[-1]}
        return answer_sample(free, xp, x[:-1], readings[name], moved, dt)

    slopes = compute_slopes(answer, [*memory, 0.0])[1]
    inner, into, out, direct = slopes[1:, :-1], slopes[1:, -1], slopes[0, :-1], slopes[0, -1]
    moved, found = np.zeros(len(memory)), list[float]()
    for _ in range(samples):
        found.append(float(out @ moved + direct))
        moved = inner @ moved + into
    return found


def settle_controller(
    controller: AbstractController, known: Mapping[str, float], signal: float, rising: bool, dt: float
) -> tuple[Numbers, float]:
    """Return the memory of a controller and its reference, where it is at rest with a signal.

    The least change of both for which `answer` gives the signal and leaves the memory as it is. What neither readings
    nor the reference ever move, such as an integral without gain, stays as it begins.

    Args:
        controller: without limits of its signal.
        known: what it reads.
        signal: what it shall answer.
        rising: whether the reference came from below.
        dt: period [s].

    Raises:
        InputError: no such steady state exists, because the controller only switches or does not respond.
    """
    value = known[controller.measured]
    aside = 1e-9 * max(abs(value), 1e-6) * (1.0 if rising else -1.0)
    x = np.array([*remember_first(controller, value + aside, known), value + aside])

    names, count = controller.reads(), len(x)

    def miss(xp: Any, x: Sequence[Any]) -> list[Any]:
        read = {**known, **dict(zip(names, x[count:], strict=True))}
        found, *after = answer_sample(controller, xp, x[: count - 1], x[count - 1], read, dt)
        return [found - signal, *(new - old for new, old in zip(after, x[: count - 1], strict=True))]

    least = max(abs(signal), LEAST_SIGNAL)
    size = np.maximum(np.abs(x), least)
    size[-1] = max(abs(value), 1e-6)
    for _ in range(ROUNDS):
        left, slopes = compute_slopes(miss, [*x.tolist(), *(known[name] for name in names)])
        if np.max(np.abs(left)) <= LEFT * least:
            return x[:-1], float(x[-1])
        free = np.append(find_reached(slopes[1:, : count - 1] + np.eye(count - 1), slopes[1:, count - 1 :]), count - 1)
        step = np.linalg.lstsq(slopes[:, free] * size[free], left, rcond=1e-12)[0]
        x[free] -= size[free] * step
        x[np.isclose(x, x[-1], rtol=SAME, atol=0.0)] = x[-1]  # a reference that is remembered has not moved
    raise InputError(f"`{controller.registered_name}` does not reach a steady state at a signal of {signal:.4g}")


def find_reached(a: Numbers, b: Numbers) -> Numbers:
    """Return the places of the states that inputs move."""
    reached = np.any(b != 0.0, axis=1)
    for _ in range(len(a)):
        reached = reached | np.any(a[:, reached] != 0.0, axis=1)
    return np.flatnonzero(reached)
