"""Thinner records, on which searches are quick: means over samples, or a first part.

Means over some samples, of inputs and outputs alike, keep what is slower. Where outputs change
too fast for that, the first part of a record stands for the whole, if it moves as much.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.impulse_response import Pair
from martensite.signals.sampling.resampling import resample_record
from martensite.signals.sampling.sampled import Sampled

COARSE = 5000
"""Samples per record to which first searches thin long records."""
MIDDLE = 25_000
"""Samples per record with which the best of the first searches go on."""
LEAST_SAMPLES = 20
"""Samples that a record keeps at least when it is thinned."""
LOST = 0.002
"""Most of the variance of an output that thinning may average away."""
WORTH = 5
"""Least factor of thinning that is worth what it blurs."""
PART = 2.4
"""A record that cannot be thinned keeps so many times as many samples as one that can."""
LIVELY = 0.5
"""Least variance of the outputs of such a part, over that of the whole."""


def coarsen_records(records: Sequence[Sampled], most: int = COARSE) -> list[Sampled]:
    """Return the records of one sample time with about as many samples each, at most twice as many.

    Where the outputs change too fast for means, only the first part of a record is taken.
    """
    factor = min(max(map(len, records)) // most, min(map(len, records)) // LEAST_SAMPLES)
    if (kept := find_thinnest(records, factor)) < factor:
        factor, records = (kept, [_cut_part(r, min(int(PART * most), MIDDLE) * kept) for r in records])
    return [r if factor < 2 else resample_record(r, ratio=float(factor)) for r in records]


def _cut_part(record: Sampled, count: int) -> Sampled:
    """Return the first samples, as many more as it takes until outputs move as in the whole."""
    whole = np.nanvar(record.outputs, axis=0)
    while count < len(record):
        first = record.outputs[:count]
        enough = np.isfinite(first).any(axis=0)
        if np.all(enough) and np.all(np.nanvar(first, axis=0) >= LIVELY * whole):
            break
        count *= 2
    return record.rows(0, count)


def find_thinnest(records: Sequence[Sampled], factor: int) -> int:
    """Return the largest factor, up to a given one, whose averages keep the outputs' variance.

    White noise, which averages away as well, is told by what averages of two samples lose.
    """
    if factor <= 1:
        return factor
    most, pair = factor, _measure_loss(records, 2)
    while factor > 1 and np.any(_measure_loss(records, factor) - 2.0 * (1.0 - 1.0 / factor) * pair > LOST):
        factor //= 2
    return factor if factor >= min(WORTH, most) else 1


def _measure_loss(records: Sequence[Sampled], factor: int) -> Numbers:
    """Return the share of the variance of every output that averages over some samples lose."""
    pairs = [(r.inputs, r.outputs) for r in records]
    means = np.concatenate([y for _, y in thin_records(pairs, factor)])
    outputs = np.concatenate([y for _, y in pairs])
    if np.any(np.isfinite(means).sum(axis=0) < 2):
        return np.ones(outputs.shape[1])
    whole = np.nanvar(outputs, axis=0)
    return 1.0 - np.nanvar(means, axis=0) / np.where(whole > 0.0, whole, 1.0)


def thin_records(pairs: Sequence[Pair], factor: int) -> list[Pair]:
    """Return the records averaged over so many samples, inputs and outputs alike."""
    if factor <= 1:
        return list(pairs)
    made: list[Pair] = []
    for u, y in pairs:
        count = len(u) // factor
        if count:
            blocks = y[: count * factor].reshape(count, factor, -1)
            known = np.isfinite(blocks)
            sums, counts = np.where(known, blocks, 0.0).sum(axis=1), known.sum(axis=1)
            mean = np.where(2 * counts >= factor, sums / np.maximum(counts, 1), np.nan)
            made.append((u[: count * factor].reshape(count, factor, -1).mean(axis=1), mean))
    return made
