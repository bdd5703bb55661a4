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
"""Stands for the status of a run whose chunk is not made yet."""


@dataclass(frozen=True, eq=False)
class SweepColumn:
    """One number of every run."""

    name: str
    """Path of a varied number, or words of a measure."""
    unit: str
    """SI unit."""
    values: Numbers
    """(runs,), in SI; NaN where a run failed or is not made, infinite for what never happened."""
    log: bool = False
    """True for a logarithmic scale."""

    @property
    def declared(self) -> str:
        """SI unit; that of a difference for a stroke of a temperature, which has no zero."""
        stroke = self.unit == "K" and self.name.startswith("stroke")
        return units.DEGREES if stroke else self.unit

    @property
    def shown(self) -> str:
        """Return the unit in which people read it."""
        return units.choose_readable_unit(self.declared)

    def readable(self, values: Any = None) -> Numbers:
        """Return the values of the column, or other values of its unit, in a readable unit."""
        factor, offset = units.find_conversion(self.shown, self.declared)
        return (np.asarray(self.values if values is None else values, float) - offset) / factor

    def words(self, value: float) -> str:
        """Return one of its numbers with its unit."""
        if math.isinf(value):
            return "never"
        number = f"{float(self.readable(value)):.5g}"
        return number if self.shown == "1" else f"{number} {self.shown}"

    def apart(self, difference: float) -> str:
        """Return a difference of two of its numbers with its unit."""
        factor, offset = units.find_conversion(self.shown, self.declared)
        unit = "K" if offset else self.shown
        number = f"{difference / factor:.4g}"
        return number if unit == "1" else f"{number} {unit}"


@dataclass(frozen=True, eq=False)
class SweepTable:
    """The runs of a sweep, as far as they are made."""

    title: str
    sample: str
    """Method that filled the space, such as a grid."""
    varied: Mapping[str, SweepColumn]
    """By path, in the order in which they were asked for."""
    measures: Mapping[str, SweepColumn]
    """By their words."""
    status: NDArray[np.int8]
    """(runs,), of `martensite.simulate.Status`, or `NOT_MADE`."""
    levels: tuple[Numbers, ...] | None = None
    """Levels of every varied number, if runs lie on a grid; the last one varies fastest."""

    @property
    def design(self) -> str:
        """Return the name of the design, without the number of samples."""
        return self.sample.partition(":")[0].strip()

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Return the length of the grid along every varied number."""
        return None if self.levels is None else tuple(map(len, self.levels))

    @cached_property
    def good(self) -> NDArray[np.bool_]:
        """Return the runs that were made and can be trusted."""
        return (self.status > NOT_MADE) & (self.status < Status.UNSOLVED)

    @property
    def missing(self) -> int:
        """Return the number of runs that are not made yet."""
        return int(np.sum(self.status == NOT_MADE))

    @property
    def failed(self) -> int:
        """Return the number of runs that were made and failed."""
        return int(np.sum(self.status >= Status.UNSOLVED))

    @cached_property
    def inputs(self) -> Numbers:
        """Return all varied numbers, (runs, axes)."""
        return np.stack([one.values for one in self.varied.values()], axis=1)

    def column(self, name: str) -> SweepColumn:
        """Return a measure or a varied number, by its name or a unique ending of it.

        Raises:
            UnknownNameError: there is none.
        """
        known = {**self.varied, **self.measures}
        endings = [n for n in known if n.endswith(f".{name}")]
        if name not in known and len(endings) != 1:
            raise UnknownNameError("measure or varied number", name, known)
        return known[name if name in known else endings[0]]

    def chosen(self, names: list[str] | tuple[str, ...] | None = None) -> list[SweepColumn]:
        """Return the measures by name; all without.

        Raises:
            UnknownNameError: there is none of that name.
            DataError: only traces were kept.
        """
        for name in names or ():
            require_known("measure in this sweep", name, self.measures)
        if not self.measures:
            raise DataError("This sweep kept traces only; run it with `--output` as well.")
        return [self.measures[name] for name in names or self.measures]


def shorten_names(names: Mapping[str, SweepColumn] | list[str]) -> dict[str, str]:
    """Return the shortest ending of every path that no other path has as well."""
    found: dict[str, str] = {}
    for name in names:
        words = name.split(".")
        endings = (".".join(words[k:]) for k in range(len(words) - 1, -1, -1))
        found[name] = next(e for e in endings if e == name or sum(n == e or n.endswith(f".{e}") for n in names) < 2)
    return found
