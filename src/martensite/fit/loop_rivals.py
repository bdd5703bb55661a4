"""Baseline predictions of loops, from other loops or from the major loop of the same record.

    nearest record       the loop under the nearest load, at the same temperature of the same branch
    neighbouring loads   temperature and column of the two nearest loads, averaged at equal fraction of each branch
    scaled major loop    after a reversal, the branch of the major loop scaled to the point of reversal

The fraction of a branch is the relative change of its column, with a small contribution of its drive. Below the lowest
and above the highest load, the two nearest loads are extrapolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.characterise.loop_paths import FULL, trace_loop
from martensite.characterise.straight_lines import fit_isotonic

FLAT = 0.02
"""Contribution of the drive to the fraction of a branch, which separates flat rows."""
FRACTIONS = np.linspace(0.0, 1.0, 201)
FARTHEST = 2.0
"""Largest extrapolation to a load, in distances between its neighbours."""


@dataclass(frozen=True)
class LoopColumns:
    """Drive and measured column of a loop; NaN in held-out rows."""

    drive: Any
    column: Any
    load: float = 0.0
    """Mean load, which orders loops."""


@dataclass(frozen=True)
class LoopLeg:
    """One full leg, in the order of the drive."""

    drive: Any
    column: Any

    def at(self, drive: Any) -> Any:
        """Return the column at values of the drive, constant beyond its ends."""
        return np.interp(drive, self.drive, self.column)

    @property
    def fractions(self) -> Any:
        """Return the fraction of the leg at each row, from 0 to 1."""
        sign = 1.0 if self.column[-1] >= self.column[0] else -1.0
        done = fit_isotonic(sign * self.column)
        done = (done - done[0]) / ((done[-1] - done[0]) or 1.0)
        way = (self.drive - self.drive[0]) / ((self.drive[-1] - self.drive[0]) or 1.0)
        return (1.0 - FLAT) * done + FLAT * way


Branches = dict[bool, LoopLeg]
"""Last full leg by direction: True if the drive rises."""


def find_branches(loop: LoopColumns) -> Branches:
    """Return the last full leg of each direction, without held-out rows."""
    branches: Branches = {}
    span = float(np.ptp(loop.drive))
    for first, last in trace_loop(loop.drive).legs:
        rows = np.arange(first, last + 1)
        change = loop.drive[last] - loop.drive[first]
        rows = rows[np.isfinite(loop.column[rows])]
        if abs(change) >= FULL * span and len(rows) > 2 and len(np.unique(loop.drive[rows])) > 2:
            kelvin, places = np.unique(loop.drive[rows], return_index=True)
            branches[bool(change > 0.0)] = LoopLeg(kelvin, loop.column[rows][places])
    return branches


def has_reversals(loop: LoopColumns) -> bool:
    """Return whether the drive turns back within its range."""
    span = float(np.ptp(loop.drive))
    return any(abs(loop.drive[b] - loop.drive[a]) < FULL * span for a, b in trace_loop(loop.drive).legs[1:])


def repeat_branches(loop: LoopColumns, branches: Branches) -> Any:
    """Return the column of other branches at the same drive, (rows,); after a reversal scaled to its point.

    The scaled branch ends where the branch of the other direction begins.
    """
    prediction = np.full(len(loop.drive), np.nan)
    span = float(np.ptp(loop.drive))
    for first, last in trace_loop(loop.drive).legs:
        branch = branches.get(bool(loop.drive[last] > loop.drive[first]))
        if branch is None:
            continue
        x = loop.drive[first : last + 1]
        major = branch.at(x)
        begin = prediction[first] if first else np.nan
        if first and np.isfinite(begin) and abs(x[0] - _far_end(branch, x)) < FULL * span:
            end = branch.at(_far_end(branch, x))
            room = major[0] - end
            major = end + (major - end) * ((begin - end) / room if abs(room) > 0.0 else 1.0)
        prediction[first + (first > 0) : last + 1] = major[first > 0 :]
    return prediction


def _far_end(branch: LoopLeg, x: Any) -> float:
    """Return the end of a branch towards which a leg goes."""
    return float(branch.drive[-1] if x[-1] > x[0] else branch.drive[0])


def average_neighbours(loop: LoopColumns, others: Sequence[LoopColumns]) -> Any:
    """Return the column between the two nearest loads, (rows,); None without two different loads."""
    ranked = sorted(others, key=lambda one: abs(one.load - loop.load))
    first = next((one for one in ranked if one.load != loop.load), None)
    if first is None:
        return None
    apart = [one for one in ranked if one.load != first.load]
    across = [one for one in apart if (one.load - loop.load) * (first.load - loop.load) < 0.0]
    second = next(iter(across or apart), None)
    if second is None:
        return None
    weight = (loop.load - first.load) / (second.load - first.load)
    if abs(weight) > FARTHEST:
        return None
    pair = find_branches(first), find_branches(second)
    mixed = {
        way: _mix(pair[0][way], pair[1][way], weight) for way in (True, False) if way in pair[0] and way in pair[1]
    }
    return repeat_branches(loop, mixed) if mixed else None


def _mix(one: LoopLeg, other: LoopLeg, weight: float) -> LoopLeg:
    """Return the branch at a weight between two, at equal fraction."""
    columns: list[Any] = []
    for name in ("drive", "column"):
        values = [np.interp(FRACTIONS, x.fractions, getattr(x, name)) for x in (one, other)]
        columns.append((1.0 - weight) * values[0] + weight * values[1])
    return LoopLeg(np.maximum.accumulate(columns[0]), columns[1])
