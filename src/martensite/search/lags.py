"""First-order lag behind inputs: the model without hysteresis that fits and black-box models must beat.

    y = z + Σ g_k x_k,    τ dx_k/dt = u_k - x_k

Inputs are held from their row to the next, or during the step to it, and the lag begins in the steady state. The time
constant is the best of a grid, which can be refined around it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

LONG = 10_000
"""Rows above which a recursion in Python is slower than the import of scipy.signal."""
Filter = Callable[[float], Any]
"""Time constant [s] -> lagged inputs of all fitted rows, (rows, inputs)."""


@dataclass(frozen=True)
class Lag:
    """First-order lag from inputs to outputs."""

    time_constant: float
    """[s]; 0 for none."""
    gains: Any
    """(inputs, outputs)"""
    zeros: Any
    """(outputs,)"""


def filter_lag(times: Any, inputs: Any, time_constant: float, *, early: bool = False) -> Any:
    """Return inputs (rows, inputs) behind a lag [s], from a steady state at the first row.

    Args:
        times: times of the rows [s].
        inputs: inputs (rows, inputs).
        time_constant: time constant [s]; 0 for no lag.
        early: an input acts during the step to its row, not from its row on.
    """
    u, steps = np.asarray(inputs, float), np.diff(np.asarray(times, float))
    if time_constant <= 0.0 or not len(steps):
        return u
    if len(steps) > LONG and np.ptp(steps) <= 1e-6 * steps[0]:
        from scipy.signal import lfilter

        keep = float(np.exp(-steps[0] / time_constant))
        return u[:1] + lfilter([(1.0 - keep) * early, (1.0 - keep) * (not early)], [1.0, -keep], u - u[:1], axis=0)
    decay_factors = np.exp(-steps / time_constant).tolist()
    columns = [_follow(decay_factors, column[0], column[1:] if early else column[:-1]) for column in u.T.tolist()]
    return np.array(columns).T


def _follow(decay_factors: Sequence[float], start: float, levels: Sequence[float]) -> list[float]:
    lagged_levels = [start]
    for keep, level in zip(decay_factors, levels, strict=True):
        lagged_levels.append(level + (lagged_levels[-1] - level) * keep)
    return lagged_levels


def fit_lag(filtered: Filter, outputs: Any, ends: tuple[float, float], lags: int, refined: int = 0) -> Lag:
    """Return the lag that explains outputs best.

    Args:
        filtered: lagged inputs of the fitted rows.
        outputs: outputs of these rows, (rows, outputs).
        ends: shortest and longest time constant [s].
        lags: number of time constants tried, besides no lag; 0 for no lag.
        refined: number of finer grids around the best time constant.
    """
    y = np.asarray(outputs, float)
    best, least = Lag(0.0, np.zeros((filtered(0.0).shape[1], y.shape[1])), y.mean(axis=0)), float(np.sum(y.var(axis=0)))
    grid, step = np.array([0.0, *np.geomspace(*ends, lags)]), (ends[1] / ends[0]) ** (1.0 / max(lags, 1))
    for _ in range(1 + refined):
        for lag in grid:
            x = filtered(float(lag))
            middle, mean = x.mean(axis=0), y.mean(axis=0)
            gains = np.linalg.lstsq(x - middle, y - mean, rcond=None)[0]
            error = float(np.mean(np.sum(((x - middle) @ gains - (y - mean)) ** 2, axis=1)))
            if error < least:
                best, least = Lag(float(lag), gains, mean - middle @ gains), error
        if best.time_constant == 0.0:
            break
        grid, step = best.time_constant * np.geomspace(1.0 / step, step, lags), step ** (2.0 / lags)
    return best
