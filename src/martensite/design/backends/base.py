"""Backends: they take a job and the numbers of chunks, and yield a report of each as it is done.

A job makes a chunk and puts it where it belongs; a report is small. A backend loses nothing: what a
worker takes with it when it dies is made again, or reported as lost.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

from martensite.base.registry import Registry
from martensite.design.sweep.plan import SweepPiece


@dataclass(frozen=True)
class Report:
    """What became of a chunk."""

    chunk: int
    status: dict[int, int]
    """Number of runs by status."""
    seconds: float = 0.0
    """CPU time that it took."""
    remarks: tuple[str, ...] = field(default=())
    """Sentences on what went wrong on the way."""


class Job(Protocol):
    """Makes chunks; it can be sent to another process."""

    def __call__(self, chunk: int) -> Report:
        """Make a chunk and store it."""
        ...

    def rows(self, chunk: int) -> range:
        """The runs of a chunk."""
        ...

    def compute(self, rows: range) -> SweepPiece:
        """Make some runs."""
        ...

    def lost(self, rows: range) -> SweepPiece:
        """What stands for runs that cannot be made."""
        ...

    def store(self, chunk: int, piece: SweepPiece, remarks: tuple[str, ...] = ()) -> Report:
        """Store a chunk."""
        ...


class AbstractBackend(ABC):
    """Who runs chunks."""

    registered_name: ClassVar[str] = ""

    @abstractmethod
    def run(self, job: Job, chunks: Iterable[int]) -> Generator[Report]:
        """Make chunks, in any order; stop at an error that the next chunk would meet as well.

        Raises:
            StoppedError: it cannot go on; chunks that were made before are kept.
        """


BACKENDS: Registry[AbstractBackend] = Registry("backend", "martensite.design.backends")
