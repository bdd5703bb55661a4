"""Predictions without a model, which a model must beat before it is said to predict.

mean            the mean of the rows that were seen
lag             a + b x, where x is the drive (squared, for volts and amperes) behind a first-order lag
nearest         the record whose load is nearest, at the same place of its loop
last cycle      the same record, one period of its drive earlier
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.signals.records import Record

LAGS = 16
"""Time constants that are tried."""
HEATING_POWER = {"voltage": 2.0, "current": 2.0}
"""Drive -> exponent with which it heats; 1 for others."""


@dataclass(frozen=True)
class DriveLag:
    """A first-order lag from what heats to what is measured."""

    time_constant: float
    """[s]; 0 for none."""
    gain: float
    """Measured unit per unit of what heats."""
    zero: float
    rms: float
    """Error over the rows it was fitted to."""

    def predict(self, record: Record, drive: str) -> Any:
        """(rows,): what it says of a record."""
        return self.zero + self.gain * filter_drive(record, drive, self.time_constant)


def filter_drive(record: Record, drive: str, time_constant: float) -> Any:
    """What heats, (rows,), behind a lag [s]; it begins at rest."""
    times, u = np.asarray(record.times), np.asarray(record[drive], float)
    heat = np.abs(np.where(np.isfinite(u), u, 0.0)) ** HEATING_POWER.get(drive, 1.0)
    if time_constant <= 0.0:
        return heat
    kept = np.exp(-np.diff(times) / time_constant).tolist()
    found, rows = [float(heat[0])], heat.tolist()
    for keep, level in zip(kept, rows[:-1], strict=True):
        found.append(level + (found[-1] - level) * keep)
    return np.array(found)


def fit_drive_lag(records: Sequence[Record], drive: str, column: str, used: Sequence[Any] | None = None) -> DriveLag:
    """The lag that explains a column of some records best.

    Args:
        records: with times.
        drive: column that drives.
        column: that is explained.
        used: (rows,) of each, True for what may be seen.
    """
    measured = [np.asarray(r[column], float) for r in records]
    seen = [
        np.isfinite(y) if used is None else np.isfinite(y) & u for y, u in zip(measured, used or measured, strict=True)
    ]
    y = np.concatenate([m[s] for m, s in zip(measured, seen, strict=True)])
    longest = max(r.times[-1] - r.times[0] for r in records)
    least = min(float(np.median(np.diff(r.times))) for r in records)
    best = DriveLag(0.0, 0.0, float(y.mean()), float(y.std()))
    for lag in (0.0, *np.geomspace(least, longest, LAGS)):
        x = np.concatenate([filter_drive(r, drive, lag)[s] for r, s in zip(records, seen, strict=True)])
        slope = float(np.cov(x, y, bias=True)[0, 1] / max(float(np.var(x)), 1e-300))
        zero = float(y.mean() - slope * x.mean())
        rms = float(np.sqrt(np.mean((zero + slope * x - y) ** 2)))
        if rms < best.rms:
            best = DriveLag(float(lag), slope, zero, rms)
    return best


def predict_last_cycle(record: Record, column: str, period: float) -> Any:
    """(rows,): what the column was one period [s] earlier; NaN in the first."""
    times, y = np.asarray(record.times), np.asarray(record[column], float)
    known = np.isfinite(y)
    found = np.interp(times - period, times[known], y[known])
    return np.where(times - times[0] >= period, found, np.nan)


def predict_from_nearest(record: Record, others: Mapping[str, Record], loads: Mapping[str, float], column: str) -> Any:
    """(rows,): the column of the loop with the nearest load, at the same temperature of the same branch.

    Args:
        record: a loop of temperature.
        others: loops by name.
        loads: mean loads by name, that of the record among them.
        column: that is predicted.
    """
    name = min(others, key=lambda one: abs(loads[one] - loads[record.name]))
    branches = [_cut_branches(one) for one in (others[name], record)]
    y, found = np.asarray(others[name][column], float), np.full(len(record), np.nan)
    for there, here in zip(*branches, strict=True):
        kelvin = np.asarray(others[name]["temperature"], float)[there]
        order = np.argsort(kelvin)
        found[here] = np.interp(np.asarray(record["temperature"], float)[here], kelvin[order], y[there][order])
    return found


def _cut_branches(record: Record) -> list[Any]:
    """Rows of heating and of cooling: before and after the hottest, or the other way round from the coldest."""
    kelvin = np.asarray(record["temperature"], float)
    hot, cold, rows = int(np.nanargmax(kelvin)), int(np.nanargmin(kelvin)), np.arange(len(kelvin))
    if min(hot, len(kelvin) - 1 - hot) >= min(cold, len(kelvin) - 1 - cold):
        return [rows[: hot + 1], rows[hot + 1 :]]
    return [rows[cold + 1 :], rows[: cold + 1]]
