"""Inputs of benchmark problem A and the fixed steps that follow them.

What: V^2(t) [V^2] as a smooth sine or as a table of constant levels (pulse-width modulation,
random steps, pulses), and the rows of (V^2, dt) that a fixed-step engine marches over, one row
per output interval of 0.1 s. Plain floats, so that a cold process needs no numpy.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import pairwise
from typing import Any, NamedTuple

from benchmarks.problem_a import OUTPUT_INTERVAL, Wire, lumped

Rows = list[list[tuple[float, float]]]


class Drive(NamedTuple):
    """An input. A table holds levels[i] from edges[i] to edges[i+1]; the sine has no table."""

    name: str
    duration: float = 60.0  # [s]
    edges: tuple[float, ...] = ()  # [s]
    levels: tuple[float, ...] = ()  # [V^2]


def sine_squared(t: Any, cos: Any = math.cos) -> Any:
    """V^2 [V^2] of the two-tone sine drive at time t [s], for any namespace's `cos`."""
    tau = 2 * math.pi * t
    return (2.8 * (0.66 - 0.34 * cos(0.10 * tau) - 0.20 * cos(0.023 * tau))) ** 2


def sine(duration: float = 60.0) -> Drive:
    """The smooth drive of the reference numbers."""
    return Drive("sine", duration)


def pwm(duty: float | None = None, duration: float = 60.0) -> Drive:
    """10 Hz, 5 V; duty constant, or (None) slowly modulated and taken at each period's start."""
    edges, levels = [], []
    for k in range(round(10 * duration)):
        modulated = 0.256 * (0.55 - 0.45 * math.cos(2 * math.pi * 0.1 * (k / 10)))
        edges += [k / 10, (k + (modulated if duty is None else duty)) / 10]
        levels += [25.0, 0.0]
    return Drive("pwm" if duty is None else f"pwm {duty:g}", duration, tuple(edges), tuple(levels))


def random_steps() -> Drive:
    """120 random voltages, each held 0.5 s."""
    import numpy

    rng = numpy.random.default_rng(5)
    volts = rng.uniform(0, 3.6, 120) * (rng.random(120) > 0.35)
    return Drive("random", 60.0, tuple(k / 2 for k in range(120)), tuple((volts**2).tolist()))


def pulses(p: Wire) -> Drive:
    """0.3 s every 3 s, at 1000 K/s of free heating rate."""
    d = lumped(p)
    edges = [t for k in range(20) for t in (3.0 * k, 3.0 * k + 0.3)]
    return Drive("pulses", 60.0, tuple(edges), (1000 * d.M * 400 * d.R0, 0.0) * 20)


def level(drive: Drive, t: float) -> float:
    """V^2 [V^2] at time t [s]."""
    if not drive.edges:
        return sine_squared(t)
    return drive.levels[max(bisect_right(drive.edges, t) - 1, 0)]


def pieces(drive: Drive) -> list[list[tuple[float, float, float | None]]]:
    """(start, end, level) between the edges, per output interval; level None means smooth."""
    count = round(drive.duration / OUTPUT_INTERVAL)
    grid = [k / 10 for k in range(count + 1)]
    if not drive.edges:
        return [[(a, b, None)] for a, b in pairwise(grid)]
    rows = []
    for a, b in pairwise(grid):
        first, last = bisect_right(drive.edges, a + 1e-9), bisect_right(drive.edges, b - 1e-9)
        cuts = [a, *drive.edges[first:last], b]
        held = drive.levels[first - 1 : last]
        rows.append(list(zip(cuts, cuts[1:], held, strict=False)))
    return rows


def uniform(drive: Drive, n: int) -> Rows:
    """n equal steps per output interval; V^2 is the mid-step value, or the mean of a table."""
    dt = OUTPUT_INTERVAL / n
    return [_uniform_row(row, n, dt) for row in pieces(drive)]


def _uniform_row(row: list[tuple[float, float, float | None]], n: int, dt: float) -> list[tuple[float, float]]:
    start = row[0][0]
    if len(row) == 1:
        held = row[0][2]
        mids = (start + (i + 0.5) * dt for i in range(n))
        return [(sine_squared(t) if held is None else held, dt) for t in mids]
    steps = []
    for i in range(n):
        a, b = start + i * dt, start + (i + 1) * dt
        shares = ((min(b, end) - max(a, begin), held) for begin, end, held in row)
        steps.append((sum(s * (held or 0.0) for s, held in shares if s > 0) / dt, dt))
    return steps


def aligned(drive: Drive, longest: float) -> Rows:
    """Steps that land on every edge and are at most `longest` [s]."""
    return [[step for piece in row for step in _equal(piece, longest=longest)] for row in pieces(drive)]


def split(drive: Drive, on: int, off: int) -> Rows:
    """Steps that land on every edge: `on` per powered piece, `off` per unpowered one."""
    return [[step for piece in row for step in _equal(piece, count=on if piece[2] else off)] for row in pieces(drive)]


def _equal(
    piece: tuple[float, float, float | None], count: int = 0, longest: float = math.inf
) -> list[tuple[float, float]]:
    a, b, held = piece
    n = count or math.ceil((b - a) / longest - 1e-9)
    dt = (b - a) / n
    mids = (a + (i + 0.5) * dt for i in range(n))
    return [(sine_squared(t) if held is None else held, dt) for t in mids]


DRIVES = {"sine": sine, "pwm": pwm, "random": random_steps}
