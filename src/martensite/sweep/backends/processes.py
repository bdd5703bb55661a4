"""Chunks over the cores of this machine, one process each (Python's process pool).

A process that dies takes its chunks with it. They are made again, each in a process of its own; a
chunk that kills its process once more is halved until the runs that do it are found. Those are
reported as lost, the others are kept.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_context

from martensite.sweep.backends.base import BACKENDS, AbstractBackend, Job, Report
from martensite.sweep.plan import Piece

START = "spawn"
"""A forked process would inherit the threads of JAX, half of them."""


@BACKENDS.register("processes")
@dataclass(frozen=True)
class Processes(AbstractBackend):
    """A pool of processes."""

    workers: int = 0
    """How many; 0 for one per core."""

    @property
    def count(self) -> int:
        """Number of processes."""
        return self.workers or len(os.sched_getaffinity(0))

    def run(self, job: Job, chunks: Iterable[int]) -> Iterator[Report]:
        """Two chunks per process are under way at a time."""
        waiting, broken = iter(chunks), list[int]()
        while True:
            yield from self._pool(job, waiting, broken)
            if not broken:
                return
            for chunk in broken:
                yield salvaged(job, chunk)
            broken.clear()

    def _pool(self, job: Job, waiting: Iterator[int], broken: list[int]) -> Iterator[Report]:
        """Reports of chunks until there are no more, or a process has died; then what it had."""
        with ProcessPoolExecutor(self.count, get_context(START)) as pool:
            under_way: dict[Future[Report], int] = {}
            while True:
                room = 0 if broken else 2 * self.count - len(under_way)
                for chunk in islice(waiting, room):
                    try:
                        under_way[pool.submit(job, chunk)] = chunk
                    except BrokenProcessPool:
                        broken.append(chunk)
                        break
                if not under_way:
                    return
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    chunk = under_way.pop(future)
                    try:
                        yield future.result()
                    except BrokenProcessPool:
                        broken.append(chunk)


def salvaged(job: Job, chunk: int) -> Report:
    """Make a chunk whose process has died, keeping every run that can be made."""
    rows, lost = job.rows(chunk), list[int]()
    piece = Piece.joined(_kept(job, rows, lost))
    remark = f"The process of chunk {chunk} died; "
    if lost:
        named = ", ".join(map(str, lost[:5])) + (" …" if len(lost) > 5 else "")
        remark += f"run {named} kills it and is lost, the others were made again."
    else:
        remark += "it was made again."
    return job.store(chunk, piece, (remark,))


def _kept(job: Job, rows: range, lost: list[int]) -> list[Piece]:
    """Pieces of some runs, halved wherever a process of their own dies."""
    try:
        with ProcessPoolExecutor(1, get_context(START)) as pool:
            return [pool.submit(job.compute, rows).result()]
    except BrokenProcessPool:
        if len(rows) == 1:
            lost.append(rows.start)
            return [job.lost(rows)]
    middle = (rows.start + rows.stop) // 2
    halves = range(rows.start, middle), range(middle, rows.stop)
    return [piece for half in halves for piece in _kept(job, half, lost)]
