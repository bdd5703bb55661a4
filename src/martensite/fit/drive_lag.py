"""Lag behind a drive, and period of a drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.search.lags import filter_lag, fit_lag
from martensite.signals.records import Record

if TYPE_CHECKING:
    from martensite.fit.experiment import Experiment

LAGS = 16
"""Tried time constants."""
SQUARED = ("V", "A")
"""Units of drives that heat by their square."""
TURNED = 0.1
"""Range about the mean in which the period is searched, as a fraction."""


@dataclass(frozen=True)
class DriveLag:
    """First-order lag from the heating drive to the measured column."""

    time_constant: float
    """[s]; 0 for none."""
    gain: float
    """Measured unit per unit of the heating drive."""
    zero: float

    def predict(self, record: Record, drive: str) -> Any:
        """Return the prediction (rows,) of a record."""
        return self.zero + self.gain * filter_drive(record, drive, self.time_constant)


def filter_drive(record: Record, drive: str, time_constant: float) -> Any:
    """Return the heating column, (rows,), behind a lag [s] from an initial steady state."""
    u = np.asarray(record[drive], float)
    heat = np.where(np.isfinite(u), u, 0.0) ** (2.0 if record.units[drive] in SQUARED else 1.0)
    return filter_lag(record.times, heat[:, None], time_constant)[:, 0]


def fit_drive_lag(
    records: Sequence[Record], drive: str, column: str, lags: int = LAGS, *, refined: int = 0
) -> DriveLag:
    """Return the lag that explains a column of some records best; rows with NaN are ignored.

    Args:
        records: records with times.
        drive: drive column.
        column: explained column.
        lags: number of time constants tried, besides no lag.
        refined: number of finer grids around the best time constant.
    """
    masks = [np.isfinite(np.asarray(one[column], float)) for one in records]
    y = np.concatenate([np.asarray(r[column], float)[s] for r, s in zip(records, masks, strict=True)])

    def gather(lag: float) -> Any:
        return np.concatenate([filter_drive(r, drive, lag)[s] for r, s in zip(records, masks, strict=True)])[:, None]

    longest = max(r.times[-1] - r.times[0] for r in records)
    least = min(float(np.median(np.diff(r.times))) for r in records)
    best = fit_lag(gather, y[:, None], (least, longest), lags, refined)
    return DriveLag(best.time_constant, float(best.gains[0, 0]), float(best.zeros[0]))


def find_drive(one: Experiment) -> str:
    """Return the drive that follows the column with the largest relative changes; empty without a drive."""
    share = {drive: _measure_move(np.asarray(one.record[name], float)) for drive, name in one.follows.items()}
    return max(share, key=share.__getitem__, default="")


def _measure_move(x: Any) -> float:
    return float(np.nanmax(x) - np.nanmin(x)) / (float(np.nanmax(np.abs(x))) or 1.0)


def find_period(experiment: Experiment) -> float:
    """Return the mean period [s] of the drive of an experiment; its length without a return, 0 without a drive.

    The count covers passages from below a quarter of its range to above three quarters, and back.
    """
    if not experiment.follows:
        return 0.0
    table = experiment.find_followed_waveform(find_drive(experiment))
    x, length = np.asarray(table.values), table.times[-1] - table.times[0]
    share = (x - x.min()) / (np.ptp(x) or 1.0)
    sides = np.sign(np.where(np.abs(share - 0.5) >= 0.25, share - 0.5, 0.0))
    passages = int(np.count_nonzero(np.diff(sides[sides != 0.0])))
    return 2.0 * length / passages if passages > 1 else length


def refine_period(one: Experiment) -> float:
    """Return the period [s] near the mean period at which the drive repeats best; 0 without a drive."""
    about = find_period(one)
    if about == 0.0:
        return 0.0
    table = one.find_followed_waveform(find_drive(one))
    times, values = np.asarray(table.times), np.asarray(table.values)
    tried = about * np.linspace(1.0 - TURNED, 1.0 + TURNED, 81)

    def misfit(period: float) -> float:
        late = times[times >= times[0] + period]
        return float(np.mean(np.abs(np.interp(late, times, values) - np.interp(late - period, times, values))))

    apart = [misfit(period) for period in tried if period < 0.9 * (times[-1] - times[0])]
    return float(tried[int(np.argmin(apart))]) if apart else about
