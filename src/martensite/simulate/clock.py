"""Steps that waveforms with the same edges share, and what each brings in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from martensite.actuators.assembly import AbstractSystem
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.grid import Steps, TimeGrid, cut_steps

Edges = tuple[float, ...]
"""Times at which any waveform jumps or bends [s]."""


def edges_of(waveforms: Mapping[str, AbstractWaveform], duration: float) -> Edges:
    """The edges of some waveforms in a run."""
    return tuple(sorted({edge for wave in waveforms.values() for edge in wave.edges(duration)}))


def steps_of(edges: Edges, duration: float, samples: int, step: float) -> Steps:
    """The steps of waveforms with these edges."""
    return cut_steps(edges, [duration * i / (samples - 1) for i in range(samples)], step)


def play_waveforms(
    system: AbstractSystem, steps: Steps, waveforms: Sequence[AbstractWaveform | None]
) -> TimeGrid:
    """A grid of steps with what waveforms bring, one per drive; 0 where there is none."""
    at_end = [drive.at_end for drive in system.drives()]
    return steps.grid([wave or Constant(level=0.0) for wave in waveforms], at_end)
