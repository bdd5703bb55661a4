"""Results of a sweep, as columns with one value per run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base import units
from martensite.base.errors import DataError, UnknownNameError, require_known
from martensite.base.status import Status
from martensite.signals.sampling.sampled import Numbers

NOT_MADE = -1
"""Status of a missing run."""


@dataclass(frozen=True, eq=False)
class SweepColumn:
    """Value of every run."""

    name: str
    """Path of a parameter, or text of a measure."""
    unit: str
    """SI unit."""
    values: Numbers
    """(runs,), in SI; NaN for a failed or missing run, infinite for an event that never happens."""
    is_logarithmic: bool = False
    """True for a logarithmic scale."""

    @property
    def declared(self) -> str:
        """Return the SI unit; for a stroke of a temperature the unit of a difference."""
        stroke = self.unit == "K" and self.name.startswith("stroke")
        return units.DEGREES if stroke else self.unit

    @property
    def display_unit(self) -> str:
        """Return the familiar unit."""
        return units.choose_readable_unit(self.declared)

    def readable(self, values: Any = None) -> Numbers:
        """Return the values of the column, or other values, in its familiar unit."""
        factor, offset = units.find_conversion(self.display_unit, self.declared)
        return (np.asarray(self.values if values is None else values, float) - offset) / factor

    def words(self, value: float) -> str:
        """Return a value with its unit."""
        if math.isinf(value):
            return "never"
        number = f"{float(self.readable(value)):.5g}"
        return number if self.display_unit == "1" else f"{number} {self.display_unit}"

    def apart(self, difference: float) -> str:
        """Return a difference with its unit."""
        factor, offset = units.find_conversion(self.display_unit, self.declared)
        unit = "K" if offset else self.display_unit
        number = f"{difference / factor:.4g}"
        return number if unit == "1" else f"{number} {unit}"


@dataclass(frozen=True, eq=False)
class SweepTable:
    """Runs of a sweep."""

    title: str
    sample: str
    """Method of sampling, such as a grid."""
    varied: Mapping[str, SweepColumn]
    """Varied parameters by path, in their requested order."""
    measures: Mapping[str, SweepColumn]
    """Measures by their text."""
    status: NDArray[np.int8]
    """(runs,), of `martensite.simulate.Status`, or `NOT_MADE`."""
    levels: tuple[Numbers, ...] | None = None
    """Levels of every parameter of a grid; the last one varies fastest."""

    @property
    def design(self) -> str:
        """Return the name of the design."""
        return self.sample.partition(":")[0].strip()

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Return the shape of the grid, or None."""
        return None if self.levels is None else tuple(map(len, self.levels))

    @cached_property
    def good(self) -> NDArray[np.bool_]:
        """Return true for each successful run."""
        return (self.status > NOT_MADE) & (self.status < Status.UNSOLVED)

    @property
    def missing(self) -> int:
        """Return the number of missing runs."""
        return int(np.sum(self.status == NOT_MADE))

    @property
    def failed(self) -> int:
        """Return the number of failed runs."""
        return int(np.sum(self.status >= Status.UNSOLVED))

    @cached_property
    def inputs(self) -> Numbers:
        """Return all varied parameters, (runs, axes)."""
        return np.stack([one.values for one in self.varied.values()], axis=1)

    def column(self, name: str) -> SweepColumn:
        """Return a measure or a varied parameter by its name or a unique ending.

        Raises:
            UnknownNameError: the name is unknown.
        """
        columns = {**self.varied, **self.measures}
        endings = [n for n in columns if n.endswith(f".{name}")]
        if name not in columns and len(endings) != 1:
            raise UnknownNameError("measure or varied number", name, columns)
        return columns[name if name in columns else endings[0]]

    def choose_measures(self, names: list[str] | tuple[str, ...] | None = None) -> list[SweepColumn]:
        """Return the measures by name, by default all.

        Raises:
            UnknownNameError: the name is unknown.
            DataError: the sweep has traces only.
        """
        for name in names or ():
            require_known("measure in this sweep", name, self.measures)
        if not self.measures:
            raise DataError("This sweep kept traces only; run it with `--output` as well.")
        return [self.measures[name] for name in names or self.measures]


def shorten_names(names: Mapping[str, SweepColumn] | list[str]) -> dict[str, str]:
    """Return the shortest unique ending of every path."""
    short: dict[str, str] = {}
    for name in names:
        words = name.split(".")
        endings = (".".join(words[k:]) for k in range(len(words) - 1, -1, -1))
        short[name] = next(e for e in endings if e == name or sum(n == e or n.endswith(f".{e}") for n in names) < 2)
    return short
