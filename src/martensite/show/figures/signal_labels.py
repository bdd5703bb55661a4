"""What stands on the axes of figures of models, and how many points are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from martensite.base.formats import typeset_unit

MOST = 4000
"""Points of a line beyond which it is drawn by its extremes."""


def write_signal_label(name: str, units: Mapping[str, str]) -> str:
    """Name and unit of a signal, such as position [mm]."""
    unit = units.get(name, "")
    return f"{name.replace('_', ' ')} [{typeset_unit(unit, '–')}]"


def thin_line(values: Any, most: int = MOST) -> Any:
    """Places of the values that a line needs: the extremes of equal stretches, or all."""
    count = len(values)
    if count <= most:
        return np.arange(count)
    size = -(-2 * count // most)
    whole = count // size * size
    rows = np.nan_to_num(np.asarray(values[:whole], dtype=float)).reshape(-1, size)
    first = np.arange(len(rows)) * size
    places = np.concatenate(
        [first, first + np.argmin(rows, axis=1), first + np.argmax(rows, axis=1), np.arange(whole, count)]
    )
    return np.unique(places)
