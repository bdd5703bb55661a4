"""What every waveform promises: edges where it jumps or bends, and its own mean."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from martensite.signals.base import AbstractWaveform
from martensite.testing.conformance import require_condition

DURATION = 6.0
"""Of the time that is looked at [s]."""
CUTS = 60
"""Intervals between two edges of which the mean is compared."""


def check_levels(wave: AbstractWaveform) -> None:
    """Levels are finite, and stay between `low` and `high` where these are declared."""
    levels = [wave.value(t) for t in np.linspace(0.0, 2.0 * DURATION, 6001).tolist()]
    require_condition(np.isfinite(levels).all(), "A level is not finite.")
    if {"low", "high"} <= set(wave.declarations):
        inside = wave.low <= min(levels) and max(levels) <= wave.high  # type: ignore[attr-defined]
        require_condition(inside, f"Levels go from {min(levels):g} to {max(levels):g}, beyond `low`, `high`.")


def check_edges(wave: AbstractWaveform) -> None:
    """Edges ascend, and lie within the duration that is asked for."""
    edges = wave.edges(DURATION)
    require_condition(edges == sorted(set(edges)), "The edges do not ascend.")
    inside = all(0.0 < t < DURATION for t in edges)
    require_condition(inside, f"An edge is not between 0 and {DURATION} s, the duration that is asked for.")


def check_kinks(wave: AbstractWaveform) -> None:
    """Every jump and bend is an edge: between edges the second difference falls as it should."""
    for a, b in pairwise([0.0, *wave.edges(DURATION), DURATION]):
        inner = np.linspace(a, b, 1003)[1:-1]
        levels = np.array([wave.value(t) for t in inner.tolist()])
        fine = np.abs(np.diff(levels, 2))
        coarse = np.abs(np.diff(levels[::2], 2)).max()
        require_condition(
            fine.max() <= 0.3 * coarse + 1e-12 * (1.0 + np.abs(levels).max()),
            f"There is a jump or bend near {inner[int(np.argmax(fine))]:.4g} s that is no edge.",
        )


def check_right_limits(wave: AbstractWaveform) -> None:
    """The value at an edge is the one after it."""
    for edge in wave.edges(DURATION):
        at, after = wave.value(edge), wave.value(edge + 1e-9)
        require_condition(
            abs(at - after) <= 1e-6 * (1.0 + abs(after)),
            f"At its edge at {edge:.6g} s the value is {at:g}, just after it {after:g}.",
        )


def check_means(wave: AbstractWaveform) -> None:
    """Between edges the mean and the mean square are those of the values."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    for a, b in list(pairwise([0.0, *wave.edges(DURATION), DURATION]))[:CUTS]:
        pieces = np.linspace(a, b, 9)
        half = 0.5 * (b - a) / 8.0
        middles = 0.5 * (pieces[1:] + pieces[:-1])
        times = (middles[:, None] + half * nodes).ravel()
        levels = np.array([wave.value(t) for t in times.tolist()]).reshape(8, -1)
        found = wave.moments(a, b)
        size = np.abs(levels).max()
        mean, square = ((x * weights).sum() / 16.0 for x in (levels, levels * levels))
        near = abs(found.mean - mean) <= 1e-6 * size and abs(found.square - square) <= (1e-6 * size * size)
        require_condition(near, f"Between {a:.4g} and {b:.4g} s `moments` are not those of the values.")
