"""What the page draws of a sweep: its layout, and its runs, thinned out to what can be seen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_conversion, round_digits
from martensite.base.status import Status
from martensite.design.sweep.axes import SweepAxis
from martensite.design.sweep.reading import read_axes, read_levels
from martensite.design.sweep.store import STATUS, Store
from martensite.design.sweep.table import SweepColumn, shorten_names

MOST_DRAWN = 20_000
"""Runs that are drawn of a sweep."""
DIGITS = 6
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class SweepDrawing:
    """A store as the page sees it."""

    store: Store

    @cached_property
    def spec(self) -> JsonTable:
        """What was asked for."""
        return self.store.spec

    @cached_property
    def axes(self) -> list[SweepAxis]:
        """What is varied."""
        return read_axes(self.store)

    @cached_property
    def levels(self) -> tuple[Any, ...] | None:
        """Levels of every axis of a grid."""
        return read_levels(self.store, self.axes)

    @cached_property
    def size(self) -> int:
        """Number of runs."""
        return int(self.store.group[STATUS].shape[0])

    @cached_property
    def strides(self) -> list[int]:
        """Every how many-th level of each axis of a grid is drawn, or run of a sample."""
        if self.levels is None:
            return [-(-self.size // MOST_DRAWN)]
        shape = [len(one) for one in self.levels]
        found = [1] * len(shape)
        while np.prod(drawn := [-(-n // k) for n, k in zip(shape, found, strict=True)]) > MOST_DRAWN:
            found[int(np.argmax(drawn))] += 1
        return found

    def kept(self, rows: Rows) -> Rows:
        """Those of some runs that are drawn."""
        if self.levels is None:
            return rows[rows % self.strides[0] == 0]
        places = np.unravel_index(rows, [len(one) for one in self.levels])
        pairs = zip(places, self.strides, strict=True)
        return rows[np.logical_and.reduce([place % stride == 0 for place, stride in pairs])]

    def rows(self, chunk: int) -> Rows:
        """Runs of a chunk."""
        length = int(self.spec["chunk"])
        return np.arange(chunk * length, min((chunk + 1) * length, self.size))

    def points(self, chunks: Iterable[int]) -> JsonTable:
        """Drawn runs of chunks that are there: numbers of runs, status, and columns in SI.

        Columns of a grid are its measures alone: levels say the rest.
        """
        found: JsonTable = {"rows": [], "status": [], "columns": {n: [] for n in self._names}}
        for first, last in _list_stretches(sorted(chunks)):
            rows = np.arange(self.rows(first)[0], self.rows(last)[-1] + 1)
            kept = self.kept(rows)
            if len(kept):
                self._add(found, rows, kept)
        return found

    def _add(self, found: JsonTable, rows: Rows, kept: Rows) -> None:
        region, places = slice(int(rows[0]), int(rows[-1]) + 1), kept - rows[0]
        found["rows"] += kept.tolist()
        found["status"] += self.store.group[STATUS][region][places].tolist()
        for name, column in found["columns"].items():
            values = self.store.group[name][region][places].tolist()
            column += [round_digits(value, DIGITS) for value in values]

    @cached_property
    def _names(self) -> list[str]:
        varied = [one.target.name for one in self.axes] if self.levels is None else []
        return [*varied, *self.spec["measures"]]

    def layout(self) -> JsonTable:
        """What the columns are, and how they are shown (shown = SI · factor + offset)."""
        short = shorten_names([one.target.name for one in self.axes])
        return {
            "title": self.spec["title"],
            "sample": self.spec["sample"],
            "runs": self.size,
            "over": self.spec["over"],
            "text": self.spec["scenario"],
            **{name: self.spec[name] for name in ("seed", "step", "runtime", "chunk", "version")},
            "axes": [
                {
                    **self._shown(one.target.name),
                    "short": short[one.target.name],
                    "log": one.log,
                    "levels": None if self.levels is None else self.levels[k],
                }
                for k, one in enumerate(self.axes)
            ],
            "measures": [{**self._shown(name), "short": name} for name in self.spec["measures"]],
            "strides": self.strides,
            "statuses": [[int(one), one.name.lower(), one.sentence] for one in Status],
        }

    def _shown(self, name: str) -> JsonTable:
        array = self.store.group[name]
        column = SweepColumn(name, str(array.attrs["units"]), np.empty(0))
        how = describe_conversion(column.declared, column.shown)
        about = str(array.attrs["long_name"])
        return {**how, "name": name, "about": about, "unit": column.unit}


def _list_stretches(chunks: Sequence[int]) -> Iterable[tuple[int, int]]:
    """First and last of chunks that follow each other."""
    begin = 0
    for k in range(1, len(chunks) + 1):
        if k == len(chunks) or chunks[k] != chunks[k - 1] + 1:
            yield chunks[begin], chunks[k - 1]
            begin = k
