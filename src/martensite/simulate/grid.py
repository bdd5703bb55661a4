"""The time grid: samples, and between them steps that never straddle an edge of the input."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from martensite.errors import InputError, UnitError
from martensite.signals.base import AbstractWaveform

MOST_STEPS = 20_000_000


@dataclass(frozen=True)
class Grid:
    """Sample times, and the steps between them."""

    times: list[float]
    sampled: list[float]
    """Signal at the sample times."""
    counts: list[int]
    """Steps in each interval between samples."""
    lengths: list[float]
    """Length of every step [s]."""
    drives: list[float]
    """Signal of every step."""

    @property
    def longest(self) -> float:
        """Longest step [s]."""
        return max(self.lengths)


def require_unit(waveform: AbstractWaveform | type[AbstractWaveform], unit: str) -> None:
    """Raise `UnitError` if a waveform of a fixed unit meets a source of another `unit`."""
    if waveform.unit not in (None, unit):
        kind = "a plain number" if waveform.unit == "1" else f"in {waveform.unit}"
        raise UnitError(
            f"The signal of waveform `{waveform.registered_name}` is {kind}, but the drive takes "
            f"{unit}; a duty drives `pwm-voltage`."
        )


def build_grid(
    waveform: AbstractWaveform, duration: float, samples: int, step: float, at_end: bool
) -> Grid:
    """Cut [0, duration] at samples and edges, and the pieces into steps of at most `step` [s].

    The signal of a step is its value at mid-step (second order), or at its end (from the
    left) for signals that prescribe a state.
    """
    times = [duration * i / (samples - 1) for i in range(samples)]
    edges = [*waveform.edges(duration), math.inf]
    if duration / step + len(edges) + samples > MOST_STEPS:
        raise InputError(
            f"A run of {duration:.6g} s in steps of {step:.3g} s needs more than "
            f"{MOST_STEPS:,} steps; allow a larger tolerance or a shorter duration."
        )
    counts: list[int] = []
    lengths: list[float] = []
    drives: list[float] = []
    share = 1.0 - 1e-9 if at_end else 0.5
    next_edge, hair = 0, 1e-12 * duration
    for first, last in pairwise(times):
        cuts = [first]
        while edges[next_edge] < last - hair:
            if edges[next_edge] > cuts[-1] + hair:
                cuts.append(edges[next_edge])
            next_edge += 1
        before = len(lengths)
        for a, b in pairwise([*cuts, last]):
            pieces = max(1, math.ceil((b - a) / step - 1e-9))
            length = (b - a) / pieces
            lengths += [length] * pieces
            drives += [waveform.value(a + (k + share) * length) for k in range(pieces)]
        counts.append(len(lengths) - before)
    return Grid(times, [waveform.value(t) for t in times], counts, lengths, drives)
