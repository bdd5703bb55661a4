"""Survey of the columns of logs: varying columns, their ranges, and the drives.

A column varies if its range exceeds its scatter from row to row and is not small compared with its level.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from martensite.logs.layout import list_quantities
from martensite.signals.records import Record

DRIVES, DEFORMATIONS, LOADS = map(list_quantities, ("drive", "shape", "load"))
NOISE, LEVEL = 6.0, 0.02
"""Least range of a signal, in scatters from row to row and as a fraction of its level."""
LOADED = 0.5
"""Range of a load over its largest value above which the load is not constant."""
HEATED = 15.0
"""Range of a temperature above which the temperature is not constant [K]."""


class LogSurvey:
    """Columns of some records that vary, and their ranges."""

    def __init__(self, records: Sequence[Record]) -> None:
        """Survey records in SI."""
        self.records = records
        self.names = list(dict.fromkeys(name for one in records for name in one.columns if name != "time"))
        self.varying = [n for n in self.names if any(_is_varying(n, r[n]) for r in records if n in r.columns)]

    def list_varying(self, names: Sequence[str]) -> list[str]:
        """Return the varying columns of a selection."""
        return [name for name in names if name in self.varying]

    @cached_property
    def drives(self) -> list[str]:
        """Return the varying drives, with the fewest distinct values first."""
        names = self.list_varying(DRIVES)
        return sorted(names, key=lambda name: (self._count_levels(name), DRIVES.index(name)))

    @cached_property
    def shapes(self) -> list[str]:
        """Return the varying strains and positions."""
        return self.list_varying(DEFORMATIONS)

    @cached_property
    def loads(self) -> list[str]:
        """Return the varying stresses and forces."""
        return self.list_varying(LOADS)

    @cached_property
    def warming(self) -> float:
        """Return the largest range of the temperature in a record [K]."""
        return max((_find_range(one["temperature"]) for one in self._with("temperature")), default=0.0)

    @property
    def is_heated(self) -> bool:
        """Return whether the temperature varies by more than `HEATED`."""
        return "temperature" in self.varying and self.warming > HEATED

    @property
    def is_loaded(self) -> bool:
        """Return whether a load varies by more than the fraction `LOADED` of its largest value."""
        return max(map(self._share_range, self.loads), default=0.0) >= LOADED

    @property
    def is_falling(self) -> bool:
        """Return whether all temperatures end well below their first values."""
        return all(_is_falling(_finite(one["temperature"])) for one in self._with("temperature"))

    def _with(self, name: str) -> list[Record]:
        return [one for one in self.records if name in one.columns]

    def _count_levels(self, name: str) -> int:
        """Count the distinct values of a column; a command has few."""
        return sum(len(set(np.round(one[name], 12))) for one in self._with(name))

    def _share_range(self, name: str) -> float:
        """Return the range of a column over its largest value, without the outermost hundredths."""
        ends = [np.nanpercentile(one[name], (2.0, 98.0)) for one in self._with(name)]
        return max(float(high - low) / max(abs(low), abs(high), 1e-300) for low, high in ends)


def _finite(column: Any) -> Any:
    x = np.asarray(column, float)
    return x[np.isfinite(x)]


def _find_range(column: Any) -> float:
    x = _finite(column)
    return float(np.ptp(x)) if x.size else 0.0


def _is_varying(name: str, column: Any) -> bool:
    x = _finite(column)
    if x.size < 2 or np.ptp(x) == 0.0:
        return False
    if name == "temperature":
        return bool(np.ptp(x) > 1.0)
    scatter = float(np.median(np.abs(np.diff(x))))
    low, high = np.percentile(x, (0.5, 99.5)) if scatter > 0.0 else (x.min(), x.max())
    return bool(high - low > max(NOISE * scatter if x.size > 50 else 0.0, LEVEL * np.abs(x).max()))


def _is_falling(x: Any) -> bool:
    return bool(x.size > 1 and x[0] - x[-1] > 0.5 * np.ptp(x))
