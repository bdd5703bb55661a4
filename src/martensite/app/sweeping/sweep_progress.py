"""A sweep that is watched: a note now and then with how far it is and what has come since."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Generator, Iterable
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cached_property

from martensite.app.messages import JsonTable
from martensite.app.sweeping.sweep_drawing import SweepDrawing
from martensite.app.worker import Desk
from martensite.base.status import Status
from martensite.design.backends.base import AbstractBackend, Report
from martensite.design.sweep.api import PlannedSweep, Progress
from martensite.design.sweep.job import SweepJob
from martensite.design.sweep.reading import count_statuses

LEAST_PAUSE = 0.3
"""Least time between two notes [s]."""
MOST_POINTS = 4000
"""Runs in a note."""


@dataclass(frozen=True)
class ReportingBackend(AbstractBackend):
    """A backend whose reports are also put on a pile."""

    inner: AbstractBackend
    fresh: list[int]
    """Chunks made since the last note."""

    def run(self, job: SweepJob, chunks: Iterable[int]) -> Generator[Report]:
        """As the other does it."""
        with closing(self.inner.run(job, chunks)) as reports:
            for report in reports:
                self.fresh.append(report.chunk)
                yield report


@dataclass
class SweepProgress:
    """One sweep, from its first missing chunk to its end."""

    begun: PlannedSweep
    key: str
    desk: Desk
    fresh: list[int] = field(default_factory=list[int])
    number: int = 0
    """Of the last note: who misses one asks for the points."""
    _before: Counter[int] = field(default_factory=Counter[int])
    _began: float = 0.0
    _last: float = 0.0

    def run(self) -> Progress:
        """Make what is missing.

        Raises:
            StoppedError: it was cancelled, or cannot go on; what was made is kept.
        """
        self._before = count_statuses(self.begun.store, 0)[0]
        self._began = time.monotonic()
        heard = replace(self.begun, backend=ReportingBackend(self.begun.backend, self.fresh))
        return heard.run(self._tell)

    @cached_property
    def drawing(self) -> SweepDrawing:
        """What is drawn of it."""
        return SweepDrawing(self.begun.store)

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
        """Tell how far it is, with the runs since the last note, in pieces if they are many."""
        found = self.drawing.points(self.fresh)
        self.fresh.clear()
        for begin in range(0, max(len(found["rows"]), 1), MOST_POINTS):
            self.number += 1
            piece = slice(begin, begin + MOST_POINTS)
            self.desk.tell(
                {
                    **self._state(progress, elapsed),
                    "number": self.number,
                    "rows": found["rows"][piece],
                    "status": found["status"][piece],
                    "columns": {name: values[piece] for name, values in found["columns"].items()},
                }
            )

    def _state(self, progress: Progress, elapsed: float) -> JsonTable:
        rate = progress.made / elapsed if progress.made and elapsed > 0.0 else None
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
    """Runs by the name of their status."""
    return {Status(one).name.lower(): n for one, n in sorted(counts.items()) if n}
