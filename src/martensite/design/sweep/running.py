"""Running a sweep: the chunks that are missing, by a backend, with a word after each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field

from martensite.base.errors import ParameterError, StoppedError
from martensite.design.backends.base import AbstractBackend, Job, Report


@dataclass
class Progress:
    """How far a sweep is."""

    runs: int
    """Runs in all chunks that shall be made, those done before included."""
    before: int
    """Runs done before."""
    status: Counter[int] = field(default_factory=Counter[int])
    """Runs made now, by status."""
    seconds: float = 0.0
    """CPU time of the chunks made now."""
    remarks: list[str] = field(default_factory=list[str])

    @property
    def made(self) -> int:
        """Runs made now."""
        return self.status.total()

    @property
    def done(self) -> int:
        """Runs that are there."""
        return self.before + self.made

    def note(self, report: Report) -> None:
        """Count a chunk."""
        self.status.update(report.status)
        self.seconds += report.seconds
        self.remarks.extend(report.remarks)


Tell = Callable[[Progress], None]


def run_chunks(
    job: Job, wanted: Sequence[int], done: set[int], backend: AbstractBackend, tell: Tell | None = None
) -> Progress:
    """Make the chunks that are wanted and not done yet.

    Args:
        job: makes a chunk and stores it.
        wanted: numbers of chunks.
        done: numbers of chunks that are there.
        backend: who makes them.
        tell: called after every chunk.

    Raises:
        StoppedError: it was interrupted, or cannot go on; chunks that were made are kept.
    """
    there = [chunk for chunk in wanted if chunk in done]
    runs = sum(len(job.rows(chunk)) for chunk in wanted)
    progress = Progress(runs, sum(len(job.rows(chunk)) for chunk in there))
    missing = [chunk for chunk in wanted if chunk not in done]
    try:
        if tell:
            tell(progress)
        with closing(backend.run(job, missing)) as reports:
            for report in reports:
                progress.note(report)
                if tell:
                    tell(progress)
    except KeyboardInterrupt:
        raise StoppedError(
            f"Interrupted when {progress.done:,} of {runs:,} runs were there. They are kept: the "
            "same command goes on from there."
        ) from None
    return progress


def parse_share(chunks: int, part: str | None) -> range:
    """The chunks of part i of N of a sweep, written `i/N` with i from 1 on; all without.

    Raises:
        ParameterError: it is no such part.
    """
    if part is None:
        return range(chunks)
    first, slash, count = part.partition("/")
    if not (slash and first.strip().isdecimal() and count.strip().isdecimal()):
        raise ParameterError(f"A part of a sweep is written `1/16`, not `{part}`.")
    i, total = int(first), int(count)
    if not 1 <= i <= total:
        raise ParameterError(f"Part `{part}` must be between 1/{total} and {total}/{total}.")
    return range(i - 1, chunks, total)
