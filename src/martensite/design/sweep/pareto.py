"""Pareto fronts: the runs that no other beats.

A run beats another if it is at least as good in every goal and better in one. Equal runs do not
beat each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.search.pareto import Places, find_unbeaten


@dataclass(frozen=True, eq=False)
class ParetoFront:
    """Runs that no other beats."""

    goals: tuple[SweepColumn, ...]
    most: tuple[bool, ...]
    """Whether a goal shall be large."""
    runs: Places
    """Their numbers in the sweep, in the order of the first goal, the best first."""
    compared: int
    """Number of runs that were compared."""

    def columns(self, found: SweepTable) -> dict[str, SweepColumn]:
        """Varied numbers and goals, by name."""
        return {**found.varied, **{one.name: one for one in self.goals}}


def find_pareto_front(
    found: SweepTable, minimise: Sequence[str] = (), maximise: Sequence[str] = ()
) -> ParetoFront:
    """The runs of a sweep that no other beats.

    Args:
        found: the runs.
        minimise: measures, or varied numbers, that shall be small.
        maximise: those that shall be large.

    Raises:
        UnknownNameError: there is no such measure or number.
        ParameterError: no goal is given, or one twice.
        DataError: no run has all goals.
    """
    goals = tuple(found.column(name) for name in (*minimise, *maximise))
    names = [one.name for one in goals]
    if not goals:
        raise ParameterError("A front needs goals; say what is wanted by --minimise or --maximise.")
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice:
        raise ParameterError(f"`{twice}` is a goal twice.")
    most = (False,) * len(minimise) + (True,) * len(maximise)
    values = np.stack([-g.values if m else g.values for g, m in zip(goals, most, strict=True)], 1)
    rows = np.flatnonzero(found.good & np.isfinite(values).all(axis=1))
    if not len(rows):
        raise DataError("There is no run that has all goals.")
    best = rows[find_unbeaten(values[rows])]
    order = np.lexsort(values[best].T[::-1])
    return ParetoFront(goals, most, best[order], len(rows))
