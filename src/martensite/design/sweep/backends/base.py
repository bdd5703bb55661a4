"""Backends: run the chunks of a job, and yield a report of each finished chunk.

A job computes and stores a chunk. Chunks of a crashed worker are computed again, or reported as lost. A chunk with an
unexpected error or a crash is halved until the faulty runs are found; they are reported as lost, and the other runs are
kept. Too many faulty runs in a chunk have a common cause and stop the sweep.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from martensite.base.errors import MartensiteError, StoppedError
from martensite.base.registry import Registry
from martensite.design.sweep.plan import SweepPiece

if TYPE_CHECKING:
    from martensite.design.sweep.job import SweepJob


@dataclass(frozen=True)
class Report:
    """Outcome of a chunk."""

    chunk: int
    status: dict[int, int]
    """Number of runs by status."""
    seconds: float = 0.0
    """CPU time."""
    remarks: tuple[str, ...] = field(default=())
    """Sentences on errors."""


class AbstractBackend(ABC):
    """Executor of chunks."""

    registered_name: ClassVar[str] = ""

    @abstractmethod
    def run(self, job: SweepJob, chunks: Iterable[int]) -> Generator[Report]:
        """Run chunks in any order; stop at an error that affects the next chunk too.

        Raises:
            StoppedError: the sweep cannot continue; finished chunks are kept.
        """


BACKENDS: Registry[AbstractBackend] = Registry("backend", "martensite.design.sweep.backends")


MOST_LOST = 32
"""Number of lost runs in a chunk that stops the sweep."""
NAMED = 5


def keep_runs(
    job: SweepJob, chunk: int, attempt: Callable[[range], SweepPiece], begin: str = ""
) -> tuple[SweepPiece, tuple[str, ...]]:
    """Return the results of a chunk, and sentences about lost runs.

    Args:
        job: provides placeholders for lost runs.
        chunk: number of the chunk.
        attempt: computes some runs.
        begin: first sentence.

    Raises:
        StoppedError: too many runs are lost.
        MartensiteError: an error of an attempt that is not of a single run.
    """
    lost: dict[int, str] = {}

    def halved(rows: range) -> list[SweepPiece]:
        try:
            return [attempt(rows)]
        except MartensiteError:
            raise
        except Exception as error:
            if len(rows) == 1:
                lost[rows.start] = f"{type(error).__name__}: {error}"
                _give_up(chunk, lost)
                return [job.make_lost_piece(rows)]
        middle = (rows.start + rows.stop) // 2
        return halved(range(rows.start, middle)) + halved(range(middle, rows.stop))

    pieces = halved(job.rows(chunk))
    remarks = [begin] if begin else []
    if lost:
        reason = next(iter(lost.values())).rstrip(".")
        remarks.append(f"Lost: run {_name_run(lost)} ({reason}). The others of its chunk were made.")
    return SweepPiece.join(pieces), tuple(remarks)


def _name_run(lost: dict[int, str]) -> str:
    return ", ".join(map(str, list(lost)[:NAMED])) + (" …" if len(lost) > NAMED else "")


def _give_up(chunk: int, lost: dict[int, str]) -> None:
    if len(lost) >= MOST_LOST:
        raise StoppedError(
            f"{MOST_LOST} runs of chunk {chunk} are lost (run {_name_run(lost)}), the first by "
            f"{next(iter(lost.values())).rstrip('.')}. That is no matter of some numbers: try one "
            "alone by `martensite run`. Chunks that were made are kept."
        )
