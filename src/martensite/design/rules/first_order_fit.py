r"""Models of first order with dead time from one step response.

    y(t) = y₀ + K Δ (1 - e^(-(t - L)/T))  for t > L          first order with dead time
    y(t) = y₀ + k' Δ (t - L)              for t > L          integrating

Least squares over K, T and L, with K known in closed form for every T and L: a grid, then the
method of Nelder and Mead. The integrating model is the straight line through the response between
a tenth and a half of its way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.design.rules.formulas import FirstOrder, Integrating

Numbers = NDArray[Any]
QUIET = 6.0
"""Least change of a response, in standard deviations of its noise from sample to sample."""


class Response(NamedTuple):
    """One step and what was fitted to it."""

    first_order: FirstOrder
    integrating: Integrating
    fit: float
    """100 % (1 - ‖error‖/‖y - mean‖) of the first-order model."""


def fit_first_order(reading: Numbers, before: int, period: float, step: float) -> Response:
    """Models of one response.

    Args:
        reading: samples, the step being at number `before`.
        before: samples before the step that say where it begins.
        period: time between samples [s].
        step: change of the signal.

    Raises:
        DataError: the output does not answer.
    """
    start = float(reading[: before + 1].mean())
    y = np.asarray(reading[before:]) - start
    t = period * np.arange(len(y))
    noise = float(np.std(np.diff(reading))) / math.sqrt(2.0)
    if not np.abs(y).max() > max(QUIET * noise, 1e-12 * (1.0 + abs(start))):
        raise DataError(
            f"The output moves by {np.abs(y).max():.3g} only after a step of {step:g} of the "
            f"signal: take another bias, a larger step or more time."
        )
    T, L = _search_times(t, y)
    gain, error = _fit_gain(t, y, T, L)
    fit = 100.0 * (1.0 - math.sqrt(error / float(((y - y.mean()) ** 2).sum())))
    return Response(FirstOrder(gain / step, T, L), _fit_line(t, y, step), fit)


def _fit_gain(t: Numbers, y: Numbers, T: float, L: float) -> tuple[float, float]:
    """Best gain for a time constant and a dead time, and the squares that are left."""
    shape = -np.expm1(-np.maximum(t - L, 0.0) / T)
    gain = float(shape @ y / max(float(shape @ shape), 1e-300))
    return gain, float(((y - gain * shape) ** 2).sum())


def _search_times(t: Numbers, y: Numbers) -> tuple[float, float]:
    """Time constant and dead time of least squares: a grid, then a local search."""
    end, least = float(t[-1]), float(t[1])
    grid = [
        (T, L)
        for T in np.geomspace(0.2 * least, 2.0 * end, 30).tolist()
        for L in np.linspace(0.0, 0.5 * end, 30).tolist()
    ]
    T, L = min(grid, key=lambda pair: _fit_gain(t, y, *pair)[1])
    found: Any = import_module("scipy.optimize").minimize(
        lambda x: _fit_gain(t, y, math.exp(x[0]), abs(x[1]))[1] / float(y @ y),
        (math.log(T), L),
        method="Nelder-Mead",
        options={
            "xatol": 1e-6,
            "fatol": 1e-12,
            "maxiter": 400,
            "initial_simplex": ((math.log(T), L), (math.log(T) + 0.3, L), (math.log(T), L + least)),
        },
    )
    return math.exp(found.x[0]), abs(float(found.x[1]))


def _fit_line(t: Numbers, y: Numbers, step: float) -> Integrating:
    """The straight line through the first half of the way."""
    way = float(y[np.argmax(np.abs(y))])
    gone = y / way
    last = max(int(np.argmax(gone >= 0.5)), 1)
    first = min(int(np.argmax(gone >= 0.1)), last - 1)
    rows: Sequence[int] = range(max(first - 1, 0), last + 1)
    slope, start = np.polyfit(t[rows], y[rows], 1)
    return Integrating(float(slope) / step, max(-float(start) / float(slope), 0.0))
