"""Linearisation of a controller, and its steady state."""

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
"""Signal limit that never acts."""
SHAPED = "manual", "shaping", "slew"
"""Optional parts of controllers that have no linear system."""
ROUNDS, LEFT = 30, 1e-9
"""Largest number of iterations for the steady state, and remaining change of the memory over the signal."""
SAME = 1e-11
"""Relative difference of two references that is rounding."""
LEAST_SIGNAL = 1e-3
"""Least scale of a signal."""


def free_limits(controller: AbstractController) -> AbstractController:
    """Return a controller without signal limits, manual mode, shaping and slew limit."""
    ends = {path: WIDE if path.endswith("high") else -WIDE for path in list_limits(controller)}
    return controller.with_values(ends).with_parts(**{name: None for name in SHAPED if name in controller.declarations})


def answer_sample(
    controller: AbstractController,
    xp: Any,
    memory: Sequence[Any],
    reference: Any,
    readings: Mapping[str, Any],
    dt: float,
) -> list[Any]:
    """Return the signal and the new memory of a sample, with all optional parts."""
    signal, after = controller.proceed(xp, tuple(memory), reference, readings, dt)
    return [signal, *after]


def list_step_answers(
    controller: AbstractController, readings: Mapping[str, float], dt: float, samples: int
) -> list[float]:
    """Return the changes of the signal per unit step of the reading, in successive samples."""
    free, name = free_limits(controller), controller.measured
    memory = free.begin(floats, readings[name], readings)[1]

    def answer(xp: Any, x: Sequence[Any]) -> list[Any]:
        moved = {**readings, name: readings[name] + x[-1]}
        return answer_sample(free, xp, x[:-1], readings[name], moved, dt)

    slopes = compute_slopes(answer, [*memory, 0.0])[1]
    inner, into, out, direct = slopes[1:, :-1], slopes[1:, -1], slopes[0, :-1], slopes[0, -1]
    moved, answers = np.zeros(len(memory)), list[float]()
    for _ in range(samples):
        answers.append(float(out @ moved + direct))
        moved = inner @ moved + into
    return answers


def settle_controller(
    controller: AbstractController, readings: Mapping[str, float], signal: float, rising: bool, dt: float
) -> tuple[Numbers, float]:
    """Return the memory and reference of a controller in the steady state with a signal.

    The solution is the least change of both for which `answer` gives the signal and keeps the memory. States that
    neither readings nor the reference move, such as an integral without gain, stay at their initial values.

    Args:
        controller: controller without signal limits.
        readings: readings by name.
        signal: wanted signal.
        rising: whether the reference came from below.
        dt: sample period [s].

    Raises:
        InputError: there is no such steady state, because the controller only switches or does not respond.
    """
    value = readings[controller.measured]
    aside = 1e-9 * max(abs(value), 1e-6) * (1.0 if rising else -1.0)
    x = np.array([*controller.begin(floats, value + aside, readings)[1], value + aside], float)

    names, count = controller.reads(), len(x)

    def miss(xp: Any, x: Sequence[Any]) -> list[Any]:
        read = {**readings, **dict(zip(names, x[count:], strict=True))}
        answered, *after = answer_sample(controller, xp, x[: count - 1], x[count - 1], read, dt)
        return [answered - signal, *(new - old for new, old in zip(after, x[: count - 1], strict=True))]

    least = max(abs(signal), LEAST_SIGNAL)
    size = np.maximum(np.abs(x), least)
    size[-1] = max(abs(value), 1e-6)
    for _ in range(ROUNDS):
        left, slopes = compute_slopes(miss, [*x.tolist(), *(readings[name] for name in names)])
        if np.max(np.abs(left)) <= LEFT * least:
            return x[:-1], float(x[-1])
        free = np.append(find_reached(slopes[1:, : count - 1] + np.eye(count - 1), slopes[1:, count - 1 :]), count - 1)
        step = np.linalg.lstsq(slopes[:, free] * size[free], left, rcond=1e-12)[0]
        x[free] -= size[free] * step
        x[np.isclose(x, x[-1], rtol=SAME, atol=0.0)] = x[-1]  # a stored reference has not moved
    raise InputError(f"`{controller.registered_name}` does not reach a steady state at a signal of {signal:.4g}")


def find_reached(a: Numbers, b: Numbers) -> Numbers:
    """Return the places of the states that inputs move."""
    reached = np.any(b != 0.0, axis=1)
    for _ in range(len(a)):
        reached = reached | np.any(a[:, reached] != 0.0, axis=1)
    return np.flatnonzero(reached)
