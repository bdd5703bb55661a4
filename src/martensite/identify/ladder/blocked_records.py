"""Records in contiguous blocks: for fits, for the choice of a structure, and held out of both.

Every third of the first blocks is left out of all fits and scored; the last fifth of a record is held out of fits and
choices. Inputs are known throughout, so every model runs freely from the first to the last sample of its record.

A model is better if its error over all blocks is smaller, and if the mean logarithm of the ratio of the rms errors,
piece by piece, exceeds its uncertainty. The uncertainty is the half width of Student's t for the mean of the pieces,
which are independent if they are longer than the memory of the system.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from operator import and_
from typing import Any, NamedTuple

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.goals import AUTO
from martensite.identify.chains.scores import free_run
from martensite.signals.sampling.sampled import Sampled

HELD = 0.2
"""Fraction of a record, at its end, that is held out."""
BLOCKS = 15
"""Number of blocks of the rest, of which every third is for the choice."""
PIECES = 3
"""Number of pieces of a block whose errors are compared."""
CERTAIN = 0.99
"""Confidence level of a difference."""
LEAST_GAIN = 0.01
"""Least relative gain that is worth a larger structure."""
FLOOR = 0.2
"""Fraction of the mean error that is added to the errors of pieces, so that quiet pieces do not decide."""
STILL = 0.02
"""Fraction of the range within which a signal counts as constant."""


@dataclass(frozen=True, eq=False)
class BlockedRecord:
    """A record with the use of its samples."""

    record: Sampled
    chosen_by: tuple[slice, ...]
    held_out: tuple[slice, ...]
    is_fitted: bool = True
    """False if it is scored only."""

    def blocks(self, is_held_out: bool) -> tuple[slice, ...]:
        """Return the held-out blocks, or the blocks to choose by."""
        return self.held_out if is_held_out else self.chosen_by

    def hide(self, whole: bool) -> Sampled:
        """Return the record without held-out outputs, and without outputs to choose by unless `whole`."""
        outputs = self.record.outputs.copy()
        for block in (*self.held_out, *(() if whole else self.chosen_by)):
            outputs[block] = np.nan
        return self.record.with_outputs(outputs)


class BlockErrors(NamedTuple):
    """Errors of a model on blocks of all records."""

    fit: float
    """Mean NRMSE fit over the outputs [%]."""
    pieces: Numbers
    """Root mean square errors of the pieces, over the spread of the outputs."""


class ErrorFall(NamedTuple):
    """Decrease of an error."""

    value: float
    """Mean logarithm of the ratio of the errors before and after, over the pieces."""
    uncertainty: float
    """Half width of its confidence interval."""
    share: float
    """Relative decrease of the error over all pieces."""

    @property
    def certain(self) -> bool:
        """Return whether the gain is significant and large enough."""
        return self.value > self.uncertainty and self.share > LEAST_GAIN

    @property
    def text(self) -> str:
        """Return the decrease with its uncertainty, in percent."""
        if not np.isfinite(self.value):
            return "–"
        ends = (self.value, self.value - self.uncertainty, self.value + self.uncertainty)
        middle, low, high = (100.0 * (1.0 - np.exp(-end)) for end in ends)
        return f"{middle:.1f} % ({low:.1f} to {high:.1f})"


def divide_records(
    records: Sequence[Sampled], validation: Sequence[Sampled] = (), other: Sequence[Sampled] = ()
) -> tuple[BlockedRecord, ...]:
    """Return the records in blocks; given records to choose by, or to hold out, replace blocks."""
    blocked: list[BlockedRecord] = []
    for record in records:
        last = len(record) if other else round((1.0 - HELD) * len(record))
        ends = np.linspace(0, last, BLOCKS + 1).astype(int).tolist()
        out = [] if validation else [slice(ends[k], ends[k + 1]) for k in range(2, BLOCKS, 3)]
        blocked.append(BlockedRecord(record, tuple(out), () if other else _cut_blocks(record, last)))
    blocked += [BlockedRecord(record, _cut_blocks(record), (), False) for record in validation]
    return (*blocked, *(BlockedRecord(record, (), _cut_blocks(record), False) for record in other))


def _cut_blocks(record: Sampled, first: int = 0) -> tuple[slice, ...]:
    ends = np.linspace(first, len(record), BLOCKS // 3 + 1).astype(int).tolist()
    return tuple(slice(a, b) for a, b in pairwise(ends))


def run_blocks(chain: Chain | None, blocked: Sequence[BlockedRecord], whole: bool) -> list[Numbers]:
    """Return free runs over all records, from the states of the fit; without a chain the mean of the fitted outputs."""
    if chain is None:
        fitted = np.concatenate([one.hide(whole).outputs for one in blocked if one.is_fitted])
        return [np.broadcast_to(np.nanmean(fitted, axis=0), one.record.outputs.shape) for one in blocked]
    return [free_run(chain, one.hide(whole) if one.is_fitted else one.record, AUTO) for one in blocked]


def measure_blocks(blocked: Sequence[BlockedRecord], runs: Sequence[Numbers], is_held_out: bool) -> BlockErrors:
    """Return the errors of runs on the held-out blocks, or on the blocks to choose by."""
    scale = np.nanstd(np.concatenate([one.record.outputs for one in blocked if one.is_fitted]), axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    rows: list[tuple[Numbers, Numbers]] = []
    pieces: list[float] = []
    for one, run in zip(blocked, runs, strict=True):
        for block in one.blocks(is_held_out):
            y, error = one.record.outputs[block], (one.record.outputs - run)[block] / scale
            rows.append((y / scale, error))
            squares = [float(np.nanmean(part**2)) for part in np.array_split(error, PIECES) if np.isfinite(part).any()]
            pieces += [float(np.sqrt(square)) for square in squares]
    if not rows:
        return BlockErrors(np.nan, np.zeros(0))
    y, error = (np.concatenate(part) for part in zip(*rows, strict=True))
    away = np.nansum((y - np.nanmean(y, axis=0)) ** 2, axis=0)
    with np.errstate(all="ignore"):
        fits = 100.0 * (1.0 - np.sqrt(np.nansum(error**2, axis=0) / away))
    return BlockErrors(float(np.mean(fits)), np.array(pieces))


def compare_errors(before: BlockErrors, after: BlockErrors, level: float = CERTAIN) -> ErrorFall:
    """Return the decrease of errors from one model to another."""
    if len(before.pieces) < 2 or not np.all(np.isfinite((before.pieces, after.pieces))):
        return ErrorFall(np.nan, np.inf, np.nan)
    floor = FLOOR * float(np.mean(before.pieces)) or 1.0
    falls = np.log((before.pieces + floor) / (after.pieces + floor))
    t: Any = import_module("scipy.stats").t
    width = float(t.ppf(level, len(falls) - 1) * np.std(falls, ddof=1) / np.sqrt(len(falls)))
    first, second = (float(np.mean(one.pieces**2)) for one in (before, after))
    return ErrorFall(float(np.mean(falls)), width, 1.0 - (second / first) ** 0.5 if first > 0.0 else 0.0)


def describe_silence(blocked: Sequence[BlockedRecord], is_held_out: bool) -> str:
    """Return why blocks are uninformative: inputs or outputs are constant in all, or both in most; else empty."""
    what = "blocks held out" if is_held_out else "blocks to choose by"
    pairs = [(one.record, block) for one in blocked for block in one.blocks(is_held_out)]
    quiet = [_keeps_still(record.inputs, block, STILL) for record, block in pairs]
    mute = [_keeps_still(record.outputs, block, 5.0 * STILL) for record, block in pairs]
    count = len(pairs) if all(quiet) or all(mute) else sum(map(and_, quiet, mute))
    if not pairs or 2 * count < len(pairs):
        return ""
    return (
        f"In {count} of the {len(pairs)} {what} the input or the output does not move: they cannot tell which model is "
        f"right. Record so that the input moves throughout, or give {'--other' if is_held_out else '--validate'} a log."
    )


def _keeps_still(signals: Numbers, block: slice, fraction: float) -> bool:
    """Return whether all signals stay within a fraction of their range."""
    with np.errstate(all="ignore"):
        whole, part = (np.nanmax(one, axis=0) - np.nanmin(one, axis=0) for one in (signals, signals[block]))
    return bool(np.all(~(part > fraction * whole)))


def describe_step(records: Iterable[Sampled]) -> str:
    """Return why the inputs are uninformative: they move once; else empty."""
    count = 0
    for record in records:
        for column in record.inputs.T:
            moved = np.abs(np.diff(column)) > 0.05 * STILL * np.ptp(column)
            count += int(np.sum(moved & ~np.concatenate([[False], moved[:-1]])))
    if count > 1:
        return ""
    return (
        "The input moves once: a single step shows how fast the output answers, but no nonlinearity, and leaves "
        "nothing to choose by. Record steps or ramps of several heights, up and down."
    )
