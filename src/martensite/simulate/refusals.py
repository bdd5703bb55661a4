"""Which of many variants a system would refuse: numbers out of range, or in conflict.

Ranges are checked for all runs at once; what a part checks about its numbers together, one run
after another, and only by parts that have such a check and a varied number in them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.errors import MartensiteError
from martensite.parameters import Parametrised


def refused(part: Parametrised, values: Mapping[str, Any], count: int) -> NDArray[np.bool_]:
    """Runs that are refused.

    Args:
        part: what has the parameters.
        values: path -> one number per run, (runs,), in SI.
        count: number of runs.
    """
    leaves = {leaf.path: leaf for leaf in part.leaves()}
    found = np.zeros(count, np.bool_)
    for path, column in values.items():
        declared = leaves[path].declared
        low = column <= declared.low if declared.open_low else column < declared.low
        found |= low | (column > declared.high) | ~np.isfinite(column)
    for prefix, one in _checking(part, ""):
        own = {path[len(prefix) :]: v for path, v in values.items() if path.startswith(prefix)}
        if own:
            for row in np.flatnonzero(~found):
                found[row] = _objects(one, {path: float(v[row]) for path, v in own.items()})
    return found


def _checking(part: Parametrised, prefix: str) -> Iterator[tuple[str, Parametrised]]:
    """Parts that check their numbers together."""
    if type(part).check is not Parametrised.check:
        yield prefix, part
    for name, child in part.children():
        yield from _checking(child, f"{prefix}{name}.")


def _objects(part: Parametrised, values: Mapping[str, float]) -> bool:
    """Whether a part refuses numbers that are in their ranges."""
    try:
        part.rebuilt(values).check()
    except MartensiteError:
        return True
    return False
