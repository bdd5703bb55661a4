"""Drawing of a sweep on the page: its layout, and its runs, thinned to a visible number.

During the sweep, notes report the progress and the new points.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_conversion, round_digits
from martensite.app.worker import Desk
from martensite.base.status import Status
from martensite.design.sweep.api import PlannedSweep, Progress
from martensite.design.sweep.backends.base import AbstractBackend, Report
from martensite.design.sweep.job import SweepJob
from martensite.design.sweep.reading import count_statuses, read_axes, read_levels
from martensite.design.sweep.store import STATUS, Store
from martensite.design.sweep.table import SweepColumn, shorten_names
from martensite.search.free_numbers import FreeNumber

MOST_DRAWN = 20_000
"""Largest number of drawn runs."""
DIGITS = 6
Rows = NDArray[np.int64]
LEAST_PAUSE = 0.3
"""Smallest time between two notes [s]."""
MOST_POINTS = 4000
"""Largest number of runs in a note."""


@dataclass(frozen=True)
class SweepDrawing:
    """Drawing of a store on the page."""

    store: Store

    @cached_property
    def spec(self) -> JsonTable:
        """Return the stored request."""
        return self.store.spec

    @cached_property
    def axes(self) -> list[FreeNumber]:
        """Return the varied numbers."""
        return read_axes(self.store)

    @cached_property
    def levels(self) -> tuple[Any, ...] | None:
        """Return the levels of each axis of a grid."""
        return read_levels(self.store, self.axes)

    @cached_property
    def size(self) -> int:
        """Return the number of runs."""
        return int(self.store.group[STATUS].shape[0])

    @cached_property
    def strides(self) -> list[int]:
        """Return the stride of drawn levels of each axis of a grid, or of runs of a sample."""
        if self.levels is None:
            return [-(-self.size // MOST_DRAWN)]
        shape = [len(one) for one in self.levels]
        steps = [1] * len(shape)
        while np.prod(counts := [-(-n // k) for n, k in zip(shape, steps, strict=True)]) > MOST_DRAWN:
            steps[int(np.argmax(counts))] += 1
        return steps

    def select_drawn_runs(self, rows: Rows) -> Rows:
        """Return the drawn ones of some runs."""
        if self.levels is None:
            return rows[rows % self.strides[0] == 0]
        places = np.unravel_index(rows, [len(one) for one in self.levels])
        pairs = zip(places, self.strides, strict=True)
        return rows[np.logical_and.reduce([place % stride == 0 for place, stride in pairs])]

    def rows(self, chunk: int) -> Rows:
        """Return the runs of a chunk."""
        length = int(self.spec["chunk"])
        return np.arange(chunk * length, min((chunk + 1) * length, self.size))

    def points(self, chunks: Iterable[int]) -> JsonTable:
        """Return the drawn runs of finished chunks: indices, status, and columns in SI.

        A grid has columns of measures only.
        """
        table: JsonTable = {"rows": [], "status": [], "columns": {n: [] for n in self._names}}
        for first, last in _list_stretches(sorted(chunks)):
            rows = np.arange(self.rows(first)[0], self.rows(last)[-1] + 1)
            drawn_rows = self.select_drawn_runs(rows)
            if len(drawn_rows):
                self._add(table, rows, drawn_rows)
        return table

    def _add(self, table: JsonTable, rows: Rows, drawn_rows: Rows) -> None:
        region, places = slice(int(rows[0]), int(rows[-1]) + 1), drawn_rows - rows[0]
        table["rows"] += drawn_rows.tolist()
        table["status"] += self.store.group[STATUS][region][places].tolist()
        for name, column in table["columns"].items():
            values = self.store.group[name][region][places].tolist()
            column += [round_digits(value, DIGITS) for value in values]

    @cached_property
    def _names(self) -> list[str]:
        varied = [one.target.name for one in self.axes] if self.levels is None else []
        return [*varied, *self.spec["measures"]]

    def layout(self) -> JsonTable:
        """Return the columns and their display (displayed number = SI · factor + offset)."""
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
                    **self._describe_measure(one.target.name),
                    "short": short[one.target.name],
                    "log": one.logarithmic,
                    "levels": None if self.levels is None else self.levels[k],
                }
                for k, one in enumerate(self.axes)
            ],
            "measures": [{**self._describe_measure(name), "short": name} for name in self.spec["measures"]],
            "strides": self.strides,
            "statuses": [[int(one), one.name.lower(), one.sentence] for one in Status],
        }

    def _describe_measure(self, name: str) -> JsonTable:
        array = self.store.group[name]
        column = SweepColumn(name, str(array.attrs["units"]), np.empty(0))
        how = describe_conversion(column.declared, column.display_unit)
        about = str(array.attrs["long_name"])
        return {**how, "name": name, "about": about, "unit": column.unit}


def _list_stretches(chunks: Sequence[int]) -> Iterable[tuple[int, int]]:
    begin = 0
    for k in range(1, len(chunks) + 1):
        if k == len(chunks) or chunks[k] != chunks[k - 1] + 1:
            yield chunks[begin], chunks[k - 1]
            begin = k


@dataclass(frozen=True)
class ReportingBackend(AbstractBackend):
    """A backend that also collects its reports."""

    inner: AbstractBackend
    fresh: list[int]
    """Finished chunks since the last note."""

    def run(self, job: SweepJob, chunks: Iterable[int]) -> Generator[Report]:
        """Run the job with the inner backend, and collect the finished chunks."""
        with closing(self.inner.run(job, chunks)) as reports:
            for report in reports:
                self.fresh.append(report.chunk)
                yield report


@dataclass
class SweepProgress:
    """Progress of one sweep."""

    planned_sweep: PlannedSweep
    key: str
    desk: Desk
    fresh: list[int] = field(default_factory=list[int])
    number: int = 0
    """Number of the last note; a page that misses a note requests the points."""
    _before: Counter[int] = field(default_factory=Counter[int])
    _began: float = 0.0
    _last: float = 0.0

    def run(self) -> Progress:
        """Run the missing chunks."""
        self._before = count_statuses(self.planned_sweep.store, 0)[0]
        self._began = time.monotonic()
        heard = replace(self.planned_sweep, backend=ReportingBackend(self.planned_sweep.backend, self.fresh))
        return heard.run(self._tell)

    @cached_property
    def drawing(self) -> SweepDrawing:
        """Return the drawing of the sweep."""
        return SweepDrawing(self.planned_sweep.store)

    def _tell(self, progress: Progress) -> None:
        now = time.monotonic()
        if now - self._last >= LEAST_PAUSE or progress.done == progress.runs or self._stopped:
            self._last = now
            self._note(progress, now - self._began)
        if self._stopped:
            raise KeyboardInterrupt

    @property
    def _stopped(self) -> bool:
        return self.desk.stop.is_set()

    def _note(self, progress: Progress, elapsed: float) -> None:
        """Send progress and new runs, in several notes if necessary."""
        points = self.drawing.points(self.fresh)
        self.fresh.clear()
        for begin in range(0, max(len(points["rows"]), 1), MOST_POINTS):
            self.number += 1
            piece = slice(begin, begin + MOST_POINTS)
            self.desk.tell(
                {
                    **self._state(progress, elapsed),
                    "number": self.number,
                    "rows": points["rows"][piece],
                    "status": points["status"][piece],
                    "columns": {name: values[piece] for name, values in points["columns"].items()},
                }
            )

    def _state(self, progress: Progress, elapsed: float) -> JsonTable:
        rate = progress.new_runs / elapsed if progress.new_runs and elapsed > 0.0 else None
        return {
            "phase": "running",
            "key": self.key,
            "runs": progress.runs,
            "done": progress.done,
            "rate": rate,
            "left": (progress.runs - progress.done) / rate if rate else None,
            "counts": name_statuses(self._before + progress.status),
            "remarks": progress.remarks[-5:],
        }


def name_statuses(counts: Counter[int]) -> dict[str, int]:
    """Return the number of runs by name of status."""
    return {Status(one).name.lower(): n for one, n in sorted(counts.items()) if n}
