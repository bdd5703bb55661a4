"""A waveform that is the time itself: what a grid says of it is when it reads its signals.

So the steps of many waveforms with the same edges are laid out once, and each says its signals at
those times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from martensite.parameters import part
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.driven import grid_of
from martensite.simulate.grid import Grid, rows_of
from martensite.system import AbstractSystem


class Clock(AbstractWaveform):
    """The time [s]."""

    jumps: tuple[float, ...] = part("times at which steps end [s], ascending", default=())

    def value(self, time: float) -> float:
        """The time itself."""
        return time

    def edges(self, duration: float) -> list[float]:
        """The edges that it was given."""
        return list(self.jumps)


Edges = tuple[tuple[str, tuple[float, ...]], ...]
"""Edges of every waveform, by what it drives."""


def edges_of(waveforms: Mapping[str, AbstractWaveform], duration: float) -> Edges:
    """The edges of some waveforms in a run."""
    return tuple((name, tuple(wave.edges(duration))) for name, wave in waveforms.items())


def clocked(
    system: AbstractSystem, edges: Edges, duration: float, samples: int, step: float
) -> Grid:
    """The grid of waveforms with these edges: its signals are the times at which each is read."""
    return grid_of(system, {n: Clock(jumps=jumps) for n, jumps in edges}, duration, samples, step)


def played(grid: Grid, waveforms: Sequence[AbstractWaveform | None]) -> Grid:
    """A grid of times with the signals of waveforms, one per drive; 0 where there is none."""
    waves = [wave or Constant(level=0.0) for wave in waveforms]
    drives, sampled = (
        rows_of(waves, list(zip(*times, strict=True)), len(times))
        for times in (grid.drives, grid.sampled)
    )
    return Grid(grid.times, sampled, grid.counts, grid.lengths, drives)
