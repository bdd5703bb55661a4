"""Signals and steps of their own for the lanes of a march: for variants of a waveform.

All lanes have the same samples, and between two of them as many steps as the one that needs most:
the others end with steps of no length, which keep the state. So every lane marches through exactly
the steps that it would take alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from martensite.simulate.grid import TimeGrid


@dataclass(frozen=True)
class LaneGrid:
    """Sample times, and the steps between them by lane."""

    times: list[float]
    sampled: Any
    """Signals at the sample times, (samples, drives, lanes)."""
    counts: Any
    """Steps in each interval, (intervals,)."""
    drives: Any
    """What the drives bring in every step, (steps, inputs, lanes)."""
    lengths: Any
    """Length of every step [s], (steps, lanes); 0 where a lane has none."""

    @cached_property
    def arrays(self) -> tuple[Any, Any, Any, Any, Any]:
        """For C: signals at the first sample and at the others, counts, drives, lengths."""
        first, rest = self.sampled[:1].copy(), self.sampled[1:].copy()
        return first, rest, self.counts, self.drives, self.lengths

    @property
    def longest(self) -> float:
        """Longest step [s]."""
        return float(self.lengths.max())

    def lane(self, lane: int) -> TimeGrid:
        """The grid of one lane, without the steps of no length."""
        lengths = self.lengths[:, lane]
        taken = lengths > 0.0
        ends = np.cumsum(self.counts)
        counts = [int(taken[a:b].sum()) for a, b in zip(ends - self.counts, ends, strict=True)]
        sampled = [tuple(row) for row in self.sampled[:, :, lane].tolist()]
        drives = [tuple(row) for row in self.drives[taken, :, lane].tolist()]
        return TimeGrid(self.times, sampled, counts, lengths[taken].tolist(), drives)


def lane_grid(grids: Sequence[TimeGrid]) -> LaneGrid:
    """One grid of all lanes from that of each; they must have the same samples."""
    counts = np.array([grid.counts for grid in grids], np.int_)
    most = counts.max(axis=0)
    starts = np.concatenate([[0], np.cumsum(most)[:-1]])
    drives = np.zeros((int(most.sum()), len(grids[0].drives[0]), len(grids)))
    lengths = np.zeros((len(drives), len(grids)))
    for lane, grid in enumerate(grids):
        first = np.repeat(starts - np.cumsum(counts[lane]) + counts[lane], counts[lane])
        places = first + np.arange(len(grid.lengths))
        drives[places, :, lane] = np.asarray(grid.drives, float)
        lengths[places, lane] = grid.lengths
    sampled = np.stack([np.asarray(grid.sampled, float) for grid in grids], axis=-1)
    return LaneGrid(grids[0].times, sampled, most, drives, lengths)
