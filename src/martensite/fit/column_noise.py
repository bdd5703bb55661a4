"""Noise of followed columns, declared or estimated from row to row."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from martensite.fit.problem import Problem

INCREDIBLE = 0.05
"""Fraction of the range of a column above which the estimated noise may be signal."""
OUTLYING = 4.0
"""Standard deviations beyond which a row is a corner of the signal, not noise."""


class FollowedNoise(NamedTuple):
    """Noise of a drive column."""

    drive: str
    column: str
    sigma: float
    """Standard deviation [SI]."""
    is_declared: bool
    """True if the noise was given, False if it was estimated from the column."""


def estimate_column_noise(times: ArrayLike, values: ArrayLike) -> float:
    """Return the noise of a smooth column, as its standard deviation about neighbouring rows.

    Every row is interpolated by a polynomial through its 2, 4 or 6 neighbours; the remainder has the variance
    σ² (1 + Σ w²). The least of the three counts, because curvature of the signal adds to the others.

    Args:
        times: times of the rows [s].
        values: values of the column. The result is 0 for fewer than 9.
    """
    t, x = np.asarray(times, float), np.asarray(values, float)
    if len(t) < 9:
        return 0.0
    return min(_estimate_by_neighbours(t, x, reach) for reach in (1, 2, 3))


def _estimate_by_neighbours(t: Any, x: Any, reach: int) -> float:
    count = len(t) - 2 * reach
    places = [k for k in range(2 * reach + 1) if k != reach]
    near = np.stack([t[k : k + count] for k in places], axis=1) - t[reach : reach + count, None]
    weights = np.ones_like(near)
    for j in range(len(places)):
        for k in range(len(places)):
            if k != j:
                weights[:, j] *= near[:, k] / (near[:, k] - near[:, j])
    estimate = sum(weights[:, j] * x[k : k + count] for j, k in enumerate(places))
    rest = (x[reach : reach + count] - estimate) / np.sqrt(1.0 + np.sum(weights**2, axis=1))
    limit = OUTLYING * 1.4826 * float(np.median(np.abs(rest)))
    inner = rest[np.abs(rest) <= limit]
    return math.sqrt(float(np.mean(inner**2))) if limit > 0.0 else 0.0


def find_input_noise(problem: Problem) -> tuple[list[FollowedNoise], list[str]]:
    """Return the noise of all driving columns, declared or estimated, and notes on columns left unchanged."""
    estimates: dict[tuple[str, str], list[tuple[float, float, int]]] = {}
    for one in problem.experiments:
        for drive, column in one.follows.items():
            table = one.find_followed_waveform(drive)
            sigma = estimate_column_noise(table.times, table.values)
            estimates.setdefault((drive, column), []).append((sigma, float(np.ptp(table.values)), len(table.times)))
    noises, notes = list[FollowedNoise](), list[str]()
    for (drive, column), rows in estimates.items():
        given = problem.input_noise.get(column, problem.input_noise.get(drive))
        if given is not None:
            noises.append(FollowedNoise(drive, column, given, True))
            continue
        sigma = math.sqrt(sum(s * s * n for s, _, n in rows) / sum(n for *_, n in rows))
        if sigma > INCREDIBLE * max(reach for _, reach, _ in rows):
            notes.append(
                f"Column `{column}` changes from row to row too much to tell its noise from its signal; if it is "
                f"noisy, say how much: `--noise {column}=AMOUNT`."
            )
        elif sigma > 0.0:
            noises.append(FollowedNoise(drive, column, sigma, False))
    return noises, notes
