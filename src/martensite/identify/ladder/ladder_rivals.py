"""Predictions of held-out blocks without a model: a first-order lag behind the inputs, and the last cycle.

Both use the outputs that a fit sees, as `fit` uses them (`martensite.search.rivals`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.ladder.blocked_records import BlockedRecord, measure_blocks
from martensite.search.lags import filter_lag, fit_lag

LAG, CYCLE = "first-order lag", "last cycle"
LAGS = 12
"""Time constants that are tried, besides none."""
PERIODIC = 0.9
"""Correlation of an input with itself one period later from which on it is periodic."""


def score_rivals(blocked: Sequence[BlockedRecord], whole: bool) -> dict[str, float]:
    """Return the fit [%] of every rival on the blocks held out."""
    runs = {LAG: run_lag(blocked, whole), CYCLE: repeat_cycles(blocked, whole)}
    scores = {name: measure_blocks(blocked, run, True).fit for name, run in runs.items() if run is not None}
    return {name: fit for name, fit in scores.items() if np.isfinite(fit)}


def run_lag(blocked: Sequence[BlockedRecord], whole: bool) -> list[Numbers]:
    """Return all records as the linear function of lagged inputs that explains the fitted outputs best."""
    fitted = [one for one in blocked if one.is_fitted]
    y = np.concatenate([one.hide(whole).outputs for one in fitted])
    finite_rows = np.isfinite(y).all(axis=1)

    def gather(lag: float) -> Numbers:
        return np.concatenate([_filter_inputs(one, lag) for one in fitted])[finite_rows]

    ends = fitted[0].record.interval, max(one.record.duration for one in fitted)
    best = fit_lag(gather, y[finite_rows], ends, LAGS, refined=2)
    return [best.zeros + _filter_inputs(one, best.time_constant) @ best.gains for one in blocked]


def _filter_inputs(one: BlockedRecord, lag: float) -> Numbers:
    u = one.record.inputs
    return filter_lag(one.record.interval * np.arange(len(u)), u, lag, early=True)


def repeat_cycles(blocked: Sequence[BlockedRecord], whole: bool) -> list[Numbers] | None:
    """Return the fitted outputs whole periods earlier; None unless every record that is held out is periodic."""
    runs: list[Numbers] = []
    for one in blocked:
        fitted_outputs = one.hide(whole).outputs if one.is_fitted else np.full_like(one.record.outputs, np.nan)
        period = find_period(one.record.inputs[:, 0])
        run = np.full_like(fitted_outputs, np.nan)
        for back in range(period, len(fitted_outputs), period) if period else ():
            run[back:] = np.where(np.isnan(run[back:]), fitted_outputs[:-back], run[back:])
        if any(np.isnan(run[block]).any() for block in one.held_out):
            return None
        runs.append(run)
    return runs


def find_period(u: Numbers) -> int:
    """Return the period of a signal in samples; 0 if it does not repeat itself within half of its length."""
    x = u - u.mean()
    count = len(x)
    power = np.abs(np.fft.rfft(x, 2 * count)) ** 2
    alike = np.fft.irfft(power)[: count // 2] * count / np.arange(count, count - count // 2, -1)
    below = np.flatnonzero(alike < 0.0)
    if not below.size or not alike[0] > 0.0:
        return 0
    middle = alike[1:-1]
    peaks = 1 + np.flatnonzero((middle >= alike[:-2]) & (middle >= alike[2:]) & (middle >= PERIODIC * alike[0]))
    about = int(next(iter(peaks[peaks > below[0]]), 0))
    near = range(about - about // 20, about + about // 20 + 1) if about else ()
    return min(near, key=lambda k: float(np.mean(np.abs(x[k:] - x[:-k]))), default=0)
