"""What an estimation aims at: outputs of records on one scale, rest, and what blocks expect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.base.errors import InputError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.options import Options
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.signals.sampling.sampled import Sampled


def build_aims(records: Sequence[Sampled], options: Options) -> list[RecordResidual]:
    """What is fitted: the records, on one scale, and what they say of rest."""
    weights = 1.0 / _find_spread(records, options)
    found = [RecordResidual(r, options.skip, weights, options.start) for r in records]
    if options.anchor > 0.0:
        for record in records:
            heavy = weights * np.sqrt(options.anchor * len(record))
            found.append(RecordResidual(at_rest(record), 0, heavy))
    return found


def at_rest(record: Sampled) -> Sampled:
    """One sample: the first inputs, and the mean of the outputs until an input changes."""
    moved = np.any(record.inputs != record.inputs[0], axis=1)
    count = int(np.argmax(moved)) if moved.any() else len(record)
    before = record.outputs[:count]
    known = np.isfinite(before).sum(axis=0)
    levels = np.where(known > 0, np.nansum(before, axis=0) / np.maximum(known, 1), np.nan)
    first = record.rows(0, 1, f"{record.name} at rest")
    return first.with_outputs(levels[None, :])


def _find_spread(records: Sequence[Sampled], options: Options) -> Numbers:
    """What a residual of every output is measured in."""
    if not options.sigma:
        spread = np.nanstd(np.concatenate([r.outputs for r in records]), axis=0)
        return np.where(spread > 0.0, spread, 1.0)
    if len(options.sigma) != records[0].outputs.shape[1] or not min(options.sigma) > 0.0:
        raise InputError(
            f"`sigma` must hold a number above 0 for each of the {records[0].outputs.shape[1]} "
            f"outputs, but is {', '.join(f'{s:g}' for s in options.sigma)}."
        )
    return np.array(options.sigma)


def find_expected(chain: Chain, options: Options) -> tuple[Numbers, Numbers]:
    """Where θ is pulled, and the 1/σ of priors: to what blocks expect, else to where it is."""
    found = [block.priors() for block in chain.blocks]
    centres, weights = (np.concatenate([np.zeros(0), *part]) for part in zip(*found, strict=True))
    weights = weights * options.priors
    return np.where(weights > 0.0, centres, chain.theta), weights


def squares_of(chain: Chain, records: Sequence[Sampled], options: Options) -> ResidualSquares:
    """The sum of squares that a search from the numbers of a chain minimises."""
    return ResidualSquares(chain.engine, build_aims(records, options), options.ridge, *find_expected(chain, options))
