"""Records in contiguous blocks: some to fit, some to choose by, the last held out of both.

Every third of the first blocks is left out of all fits and scored; the last fifth of a record is seen by no fit
and no choice. Inputs are known throughout, so that every model runs freely from the first sample of its record to
the last, whatever outputs it was fitted to.

One model is better than another if its error is smaller over all blocks, and if the logarithm of the ratio of their
rms errors, piece by piece, is above 0 by more than its uncertainty. That is the half width of Student's t for the mean
of the pieces, as if these were independent, which they are where they are longer than what the system remembers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.goals import AUTO
from martensite.identify.chains.scores import free_run
from martensite.signals.sampling.sampled import Sampled

HELD = 0.2
"""Share of a record, at its end, that is held out."""
BLOCKS = 15
"""Blocks of the rest, of which every third is left out to choose by."""
PIECES = 3
"""Pieces of a block whose errors are compared."""
CERTAIN = 0.99
"""Probability with which a difference must not be chance."""
LEAST_GAIN = 0.01
"""Least gain, over the error before, that is worth a larger structure."""
FLOOR = 0.2
"""Share of the mean error that is added to those of pieces, so that those where nothing happens do not decide."""
STILL = 0.02
"""Share of the range within which a signal does not move."""


@dataclass(frozen=True, eq=False)
class BlockedRecord:
    """A record, and which of its samples are for what."""

    record: Sampled
    chosen_by: tuple[slice, ...]
    held: tuple[slice, ...]
    fitted: bool = True
    """False of one that is scored only."""

    def hide(self, whole: bool) -> Sampled:
        """Return the record without the outputs that are held out, and without those to choose by unless `whole`."""
        outputs = self.record.outputs.copy()
        for block in (*self.held, *(() if whole else self.chosen_by)):
            outputs[block] = np.nan
        return self.record.with_outputs(outputs)


class BlockErrors(NamedTuple):
    """Errors of a model on some blocks of all records."""

    fit: float
    """NRMSE fit [%], mean over the outputs."""
    pieces: Numbers
    """Root mean square of the errors, over the spread of the outputs, piece by piece."""


class ErrorFall(NamedTuple):
    """By how much an error falls."""

    value: float
    """Mean logarithm of the ratio of the errors before and after, over the pieces."""
    uncertainty: float
    """Half width of its interval."""
    share: float
    """By how much the error over all pieces falls, over that before."""

    @property
    def certain(self) -> bool:
        """Return whether the gain is significant and large enough."""
        return self.value > self.uncertainty and self.share > LEAST_GAIN

    @property
    def text(self) -> str:
        """Return the fall of the errors with its uncertainty, in percent."""
        if not np.isfinite(self.value):
            return "–"
        ends = (self.value, self.value - self.uncertainty, self.value + self.uncertainty)
        middle, low, high = (100.0 * (1.0 - np.exp(-end)) for end in ends)
        return f"{middle:.1f} % ({low:.1f} to {high:.1f})"


def divide_records(
    records: Sequence[Sampled], validation: Sequence[Sampled] = (), other: Sequence[Sampled] = ()
) -> tuple[BlockedRecord, ...]:
    """Return the records in blocks; those that are given to choose by, or to hold out, take the place of blocks."""
    made: list[BlockedRecord] = []
    for record in records:
        last = len(record) if other else round((1.0 - HELD) * len(record))
        ends = np.linspace(0, last, BLOCKS + 1).astype(int).tolist()
        out = [] if validation else [slice(ends[k], ends[k + 1]) for k in range(2, BLOCKS, 3)]
        made.append(BlockedRecord(record, tuple(out), () if other else _cut_blocks(record, last)))
    made += [BlockedRecord(record, _cut_blocks(record), (), False) for record in validation]
    return (*made, *(BlockedRecord(record, (), _cut_blocks(record), False) for record in other))


def _cut_blocks(record: Sampled, first: int = 0) -> tuple[slice, ...]:
    ends = np.linspace(first, len(record), BLOCKS // 3 + 1).astype(int).tolist()
    return tuple(slice(a, b) for a, b in pairwise(ends))


def run_blocks(chain: Chain | None, blocked: Sequence[BlockedRecord], whole: bool) -> list[Numbers]:
    """Free runs over all records, from the states of the fit; without a chain the mean of what was fitted."""
    if chain is None:
        known = np.concatenate([one.hide(whole).outputs for one in blocked if one.fitted])
        return [np.broadcast_to(np.nanmean(known, axis=0), one.record.outputs.shape) for one in blocked]
    return [free_run(chain, one.hide(whole) if one.fitted else one.record, AUTO) for one in blocked]


def measure_blocks(blocked: Sequence[BlockedRecord], runs: Sequence[Numbers], held: bool) -> BlockErrors:
    """Return the errors of runs on the blocks that are held out, or on those to choose by."""
    scale = np.nanstd(np.concatenate([one.record.outputs for one in blocked if one.fitted]), axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    rows: list[tuple[Numbers, Numbers]] = []
    pieces: list[float] = []
    for one, run in zip(blocked, runs, strict=True):
        for block in one.held if held else one.chosen_by:
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
    """By how much errors fall from one model to another, and how sure that is."""
    if len(before.pieces) < 2 or not np.all(np.isfinite((before.pieces, after.pieces))):
        return ErrorFall(np.nan, np.inf, np.nan)
    floor = FLOOR * float(np.mean(before.pieces)) or 1.0
    falls = np.log((before.pieces + floor) / (after.pieces + floor))
    t: Any = import_module("scipy.stats").t
    width = float(t.ppf(level, len(falls) - 1) * np.std(falls, ddof=1) / np.sqrt(len(falls)))
    first, second = (float(np.mean(one.pieces**2)) for one in (before, after))
    return ErrorFall(float(np.mean(falls)), width, 1.0 - (second / first) ** 0.5 if first > 0.0 else 0.0)


def describe_silence(blocked: Sequence[BlockedRecord], held: bool) -> str:
    """Why blocks tell nothing: inputs or outputs stay in all, or both in most of them; empty if they move."""
    what = "blocks held out" if held else "blocks to choose by"
    pairs = [(one.record, block) for one in blocked for block in (one.held if held else one.chosen_by)]
    quiet = [_keeps_still(record.inputs, block, STILL) for record, block in pairs]
    mute = [_keeps_still(record.outputs, block, 5.0 * STILL) for record, block in pairs]
    still = sum(a and b for a, b in zip(quiet, mute, strict=True))
    if not pairs or (2 * still < len(pairs) and not all(quiet) and not all(mute)):
        return ""
    count = len(pairs) if all(quiet) or all(mute) else still
    return (
        f"In {count} of the {len(pairs)} {what} the input or the output does not move: they cannot tell which model is "
        f"right. Record so that the input moves throughout, or give {'--other' if held else '--validate'} a log."
    )


def _keeps_still(signals: Numbers, block: slice, share: float) -> bool:
    """Return whether all signals stay within a share of their range."""
    with np.errstate(all="ignore"):
        whole, part = (np.nanmax(one, axis=0) - np.nanmin(one, axis=0) for one in (signals, signals[block]))
    return bool(np.all(~(part > share * whole)))


def describe_step(records: Iterable[Sampled]) -> str:
    """Why the inputs tell too little: they move once; empty if they do more."""
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
