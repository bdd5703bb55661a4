"""Refused variants of a system: values out of range or in conflict.

Ranges are checked for all runs together. Checks across several values are made run by run, only for parts with such
a check and a varied value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import Machine, System
from martensite.base.errors import MartensiteError
from martensite.base.parameters import Parametrised


def find_refused(part: Parametrised, values: Mapping[str, Any], count: int) -> NDArray[np.bool_]:
    """Return which of `count` runs are refused; values are by path, (runs,), in SI."""
    leaves = {leaf.path: leaf for leaf in part.leaves()}
    refusal = np.zeros(count, np.bool_)
    for path, column in values.items():
        declared = leaves[path].declared
        low = column <= declared.low if declared.open_low else column < declared.low
        refusal |= low | (column > declared.high) | ~np.isfinite(column)
    for prefix, one in _list_checking(part, ""):
        own = {path[len(prefix) :]: v for path, v in values.items() if path.startswith(prefix)}
        if own:
            rows = np.flatnonzero(~refusal)
            refusal[rows] = _check_objects(one, {path: v[rows] for path, v in own.items()})
    return refusal


def _list_checking(part: Parametrised, prefix: str) -> Iterator[tuple[str, Parametrised]]:
    """Yield the parts with checks across several values; assembled systems check names only."""
    if type(part).check is not Parametrised.check and not isinstance(part, System | Machine):
        yield prefix, part
    for name, child in part.children():
        yield from _list_checking(child, f"{prefix}{name}.")


def _check_objects(part: Parametrised, values: Mapping[str, Any]) -> list[bool]:
    """Return the runs that a part rejects although all values are in range.

    One private copy of the part takes the parameters of one run after another.
    """
    twin = part.rebuilt(dict.fromkeys(values, 0.0))
    places = [(_find_holder(twin, path).__dict__, path.rpartition(".")[2]) for path in values]
    refusal: list[bool] = []
    for numbers in zip(*(column.tolist() for column in values.values()), strict=True):
        for (attributes, name), number in zip(places, numbers, strict=True):
            attributes[name] = number
        refusal.append(_is_refused(twin))
    return refusal


def _find_holder(part: Parametrised, path: str) -> Parametrised:
    for name in path.split(".")[:-1]:
        part = part.__dict__[name]
    return part


def _is_refused(part: Parametrised) -> bool:
    try:
        part.check()
    except MartensiteError:
        return True
    return False
