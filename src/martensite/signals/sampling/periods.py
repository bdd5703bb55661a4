"""Periodic records: the mean over periods, and the noise from how much periods differ.

    ȳ(t) = 1/P Σ_p y_p(t),   σ² = mean over t of Σ_p (y_p(t) - ȳ(t))² / (P - 1)

σ is the noise of one measurement, σ/√P that of the mean; no model explains more than that.
Pintelon & Schoukens, System Identification (2012).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import DataError
from martensite.signals.sampling.sampled import Numbers, Sampled

DIFFERING = 0.05
"""Spread of an input over periods, in its standard deviations, that is remarked on."""


@dataclass(frozen=True, eq=False)
class Periods:
    """A record averaged over its periods."""

    mean: Sampled
    """One period."""
    noise: Numbers
    """σ of one measurement of every output."""
    count: int
    """P, how many periods were averaged."""

    @property
    def noise_of_mean(self) -> Numbers:
        """σ of the mean of every output."""
        return self.noise / np.sqrt(self.count)

    def ceiling(self) -> Numbers:
        """Fit [%] that a perfect model reaches on one measured period, output by output."""
        y = self.mean.outputs
        spread = np.sqrt(np.nanmean((y - np.nanmean(y, axis=0)) ** 2, axis=0) + self.noise**2)
        return 100.0 * (1.0 - self.noise / np.where(spread > 0.0, spread, 1.0))


def average_periods(record: Sampled, period: float, skip: float = 0.0) -> Periods:
    """Compute the mean over periods and the level of the noise.

    Args:
        record: two whole periods at least.
        period: its length [s], a whole number of samples.
        skip: time [s] left out at the beginning, until the response repeats itself.

    Raises:
        DataError: the period is not a whole number of samples, or there are fewer than two.
    """
    samples = period / record.interval
    length, first = round(samples), round(skip / record.interval)
    if length < 1 or abs(samples - length) > 1e-3:
        raise DataError(
            f"A period must be a whole number of samples, but {period:.6g} s are {samples:.6g} of "
            f"{record.interval:.6g} s; resample record `{record.name}` first."
        )
    count = max(len(record) - first, 0) // length
    if count < 2:
        raise DataError(
            f"Record `{record.name}` holds {count} whole periods of {period:.6g} s after the "
            f"first {skip:.6g} s; at least 2 are needed."
        )
    kept = slice(first, first + count * length)
    u = record.inputs[kept].reshape(count, length, -1)
    y = record.outputs[kept].reshape(count, length, -1)
    known = np.isfinite(y).sum(axis=0)
    mean = np.where(known > 0, np.nansum(y, axis=0) / np.maximum(known, 1), np.nan)
    squares, free = np.nansum((y - mean) ** 2, axis=(0, 1)), np.maximum(known - 1, 0).sum(axis=0)
    noise = np.sqrt(squares / np.maximum(free, 1))
    averaged = replace(
        record.rows(first, first + length),
        inputs=u.mean(axis=0),
        outputs=mean,
        remarks=(*record.remarks, *_describe_differing(record, u)),
    )
    return Periods(averaged, noise, count)


def _describe_differing(record: Sampled, u: Numbers) -> list[str]:
    """Return the sentences on inputs that do not repeat themselves."""
    spread, size = u.std(axis=0).max(axis=0), u.std(axis=(0, 1))
    return [
        f"Input `{name}` differs between periods by up to {s:.3g}; its mean was taken."
        for name, s, whole in zip(record.input_names, spread, size, strict=True)
        if s > DIFFERING * whole
    ]
