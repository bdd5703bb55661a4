"""Effect of free parameters on the values of an experiment, and distances of random effects from their centres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.fit.free_parameters import is_nuisance
from martensite.search.free_numbers import FreeNumber

MovedRows = list[tuple[int, list[tuple[int, int | None]]]]
"""Index of a free parameter -> rows of the values it moves, each with its base row, if any."""


def find_moved_rows(free: Sequence[FreeNumber], labels: Sequence[str], paths: Sequence[str]) -> MovedRows:
    """Return the rows of values that each free parameter moves.

    Args:
        free: all free parameters.
        labels: record and groups of the experiment.
        paths: paths of the values.
    """
    acting = [(i, x) for i, x in enumerate(free) if x.record in (None, *labels) and not is_nuisance(x.path)]
    spread = [x for _, x in acting if x.record and x.spread]
    taken = {path for path in paths for x in spread if x.moves(path)}

    def list_rows(one: FreeNumber) -> list[tuple[int, int | None]]:
        moved = ((j, x) for j, x in enumerate(paths) if one.moves(x) and (one.record or x not in taken))
        return [(j, _find_base(one, path, paths)) for j, path in moved]

    return [(i, list_rows(one)) for i, one in acting]


def _find_base(free: FreeNumber, path: str, paths: Sequence[str]) -> int | None:
    """Return the base row of a difference; None without a base."""
    beside = path.removesuffix(free.path) + free.base
    ends = [j for j, one in enumerate(paths) if one == beside or one.endswith("." + free.base)]
    return min(ends, key=lambda j: paths[j] != beside) if free.base else None


def weigh_spreads(
    free: Sequence[FreeNumber], spreads: Sequence[tuple[int, int | None]], u: Sequence[float], scale: float
) -> tuple[Any, Any]:
    """Return the distances from centres in spreads, (ln v - ln c)/s or (v - c)/s, and their derivatives.

    Args:
        free: all free parameters.
        spreads: indices of a parameter with a spread and of its centre, or None for a fixed centre.
        u: fraction of each parameter in its range, 0 to 1.
        scale: noise of measurements, as a common factor.
    """
    apart, slopes = np.zeros(len(spreads)), np.zeros((len(spreads), len(free)))
    for row, (i, centre) in enumerate(spreads):
        own = free[i]
        ends = [(i, own.value(float(u[i])), 1.0)]
        ends.append((-1, own.start, -1.0) if centre is None else (centre, free[centre].value(float(u[centre])), -1.0))
        for place, value, sign in ends:
            apart[row] += sign * (math.log(value) if own.relative else value)
            if place >= 0:
                by_value = 1.0 / value if own.relative else 1.0
                slopes[row, place] += sign * by_value * free[place].slope(float(u[place]))
        apart[row], slopes[row] = (one * scale / own.spread for one in (apart[row], slopes[row]))
    return apart, slopes


def refuse_late_base(free: Sequence[FreeNumber]) -> None:
    """Raise `ParameterError` if a parameter is relative to a later one."""
    for k, one in enumerate(free):
        late = next((x.name for x in free[k:] if one.base and x.path == one.base), None)
        if late is not None:
            raise ParameterError(f"Free parameter `{one.name}` is relative to `{late}`, which must come before it.")


def refuse_double(one: Experiment, free: Sequence[FreeNumber]) -> None:
    """Raise `ParameterError` if two parameters move the same value of an experiment."""
    own = [x for x in free if x.record in (None, *one.labels) and not is_nuisance(x.path)]
    for leaf in one.system.leaves():
        moving = [x for x in own if x.moves(leaf.path)]
        movers = [x.name for x in moving]
        centred = {x.record is None for x in moving} == {True, False} and all(x.spread or not x.record for x in moving)
        if len(movers) > (2 if centred else 1):
            raise ParameterError(
                f"Free parameters `{movers[0]}` and `{movers[1]}` both move `{leaf.path}` of "
                f"record `{one.name}`; leave one of them out."
            )
