"""Decimated records for quick searches: means over samples, or a first part.

Means over samples of inputs and outputs keep slow changes. If outputs change too fast, the first part of a record is
used, provided that it has a similar variance.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.impulse_response import Pair
from martensite.signals.sampling.resampling import resample_record
from martensite.signals.sampling.sampled import Sampled

COARSE = 5000
"""Samples per record in first searches."""
MIDDLE = 25_000
"""Samples per record in the second stage of a search."""
LEAST_SAMPLES = 20
"""Least number of samples of a decimated record."""
LOST = 0.002
"""Largest fraction of the variance of an output that averaging may remove."""
WORTH = 5
"""Least useful factor."""
PART = 2.4
"""Samples of a first part, over the samples of a decimated record."""
LIVELY = 0.5
"""Least variance of a first part over the variance of the record."""


def coarsen_records(records: Sequence[Sampled], most: int = COARSE) -> list[Sampled]:
    """Return the records of one sample time with about `most` samples each, at most twice as many.

    If the outputs change too fast for means, the first part of each record is returned.
    """
    factor = min(max(map(len, records)) // most, min(map(len, records)) // LEAST_SAMPLES)
    if (thin := find_thinnest(records, factor)) < factor:
        factor, records = thin, [_cut_part(r, min(int(PART * most), MIDDLE) * thin) for r in records]
    return [r if factor < 2 else resample_record(r, ratio=float(factor)) for r in records]


def _cut_part(record: Sampled, count: int) -> Sampled:
    """Return the first samples, doubled until the outputs vary as in the whole record."""
    whole = np.nanvar(record.outputs, axis=0)
    while count < len(record):
        first = record.outputs[:count]
        enough = np.isfinite(first).any(axis=0)
        if np.all(enough) and np.all(np.nanvar(first, axis=0) >= LIVELY * whole):
            break
        count *= 2
    return record.rows(0, count)


def find_thinnest(records: Sequence[Sampled], factor: int) -> int:
    """Return the largest factor, up to a given one, whose means keep the variance of the outputs.

    White noise, which averages out as well, is recognised from means of two samples.
    """
    if factor <= 1:
        return factor
    most, pair = factor, _measure_loss(records, 2)
    while factor > 1 and np.any(_measure_loss(records, factor) - 2.0 * (1.0 - 1.0 / factor) * pair > LOST):
        factor //= 2
    return factor if factor >= min(WORTH, most) else 1


def _measure_loss(records: Sequence[Sampled], factor: int) -> Numbers:
    pairs = [(r.inputs, r.outputs) for r in records]
    means = np.concatenate([y for _, y in thin_records(pairs, factor)])
    outputs = np.concatenate([y for _, y in pairs])
    if np.any(np.isfinite(means).sum(axis=0) < 2):
        return np.ones(outputs.shape[1])
    whole = np.nanvar(outputs, axis=0)
    return 1.0 - np.nanvar(means, axis=0) / np.where(whole > 0.0, whole, 1.0)


def thin_records(pairs: Sequence[Pair], factor: int) -> list[Pair]:
    """Return the records averaged over `factor` samples."""
    if factor <= 1:
        return list(pairs)
    thinned: list[Pair] = []
    for u, y in pairs:
        count = len(u) // factor
        if count:
            blocks = y[: count * factor].reshape(count, factor, -1)
            finite_samples = np.isfinite(blocks)
            sums, counts = np.where(finite_samples, blocks, 0.0).sum(axis=1), finite_samples.sum(axis=1)
            mean = np.where(2 * counts >= factor, sums / np.maximum(counts, 1), np.nan)
            thinned.append((u[: count * factor].reshape(count, factor, -1).mean(axis=1), mean))
    return thinned
