"""Chunks on this machine: in this process, or in a pool of processes.

Lost chunks of a crashed process are computed again, each in a separate process. A chunk that crashes its process again
is halved until the faulty runs are found. Only this process receives Ctrl-C, and it ends the others. A chunk counts
when all of it is written. When this process is killed, the others end too.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from multiprocessing import active_children, get_context, parent_process
from threading import Thread
from typing import TYPE_CHECKING

from martensite.base.child_python import safe_children
from martensite.base.errors import StoppedError
from martensite.base.interfaces import override
from martensite.design.sweep.backends.base import BACKENDS, AbstractBackend, Report, keep_runs
from martensite.design.sweep.plan import SweepPiece

if TYPE_CHECKING:
    from martensite.design.sweep.job import SweepJob


@BACKENDS.register("serial")
class Serial(AbstractBackend):
    """This process alone."""

    @override
    def run(self, job: SweepJob, chunks: Iterable[int]) -> Generator[Report]:
        for chunk in chunks:
            yield job(chunk)


START = "spawn"
"""Start method; a forked process would inherit locks of threads."""


@BACKENDS.register("processes")
@dataclass(frozen=True)
class Processes(AbstractBackend):
    """Pool of processes."""

    workers: int = 0
    """Number of processes; 0 for one per core."""

    @property
    def count(self) -> int:
        """Return the number of processes."""
        return self.workers or count_cores()

    @override
    def run(self, job: SweepJob, chunks: Iterable[int]) -> Generator[Report]:
        waiting, broken = iter(chunks), list[int]()
        while True:
            yield from self._pool(job, waiting, broken)
            if not broken:
                return
            for chunk in broken:
                yield salvage_chunk(job, chunk)
            broken.clear()

    def _pool(self, job: SweepJob, waiting: Iterator[int], broken: list[int]) -> Iterator[Report]:
        """Yield reports until all chunks are finished or a process dies; its chunks go to `broken`."""
        with _open_pool(self.count) as pool:
            under_way: dict[Future[Report], int] = {}
            while True:
                room = 0 if broken else 2 * self.count - len(under_way)
                for chunk in islice(waiting, room):
                    try:
                        with _ignore_interrupts():
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


def count_cores() -> int:
    """Return the number of cores for this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def salvage_chunk(job: SweepJob, chunk: int) -> Report:
    """Compute the chunk of a dead process again, and keep every successful run.

    Raises:
        StoppedError: no process can be started, or too many runs crash.
    """
    begin = f"A process died at chunk {chunk}, which was made again."
    piece, remarks = keep_runs(job, chunk, partial(_run_alone, job), begin)
    return replace(job.store(chunk, piece), remarks=remarks)


def _run_alone(job: SweepJob, rows: range) -> SweepPiece:
    """Compute runs in a separate process."""
    with _open_pool(1) as pool:
        try:
            with _ignore_interrupts():
                ready = pool.submit(os.getpid)
            ready.result()
        except BrokenProcessPool:
            raise StoppedError(
                "No process can be started here. In a script, sweep under "
                '`if __name__ == "__main__":`; or choose the backend `serial`.'
            ) from None
        try:
            return pool.submit(job.compute, rows).result()
        except BrokenProcessPool:
            raise RuntimeError("its process died") from None


@contextmanager
def _open_pool(count: int) -> Iterator[ProcessPoolExecutor]:
    """Open a pool that drops waiting chunks at its end, and running chunks after an interrupt."""
    before = active_children()
    with safe_children():
        pool = ProcessPoolExecutor(count, get_context(START), initializer=_end_with_parent)
        try:
            yield pool
        except (KeyboardInterrupt, GeneratorExit):
            for process in active_children():
                if process not in before:
                    process.kill()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _end_with_parent() -> None:
    """End this process when its parent ends, even by a kill."""
    parent = parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    Thread(target=watch, daemon=True).start()


@contextmanager
def _ignore_interrupts() -> Iterator[None]:
    """Start processes that ignore Ctrl-C."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
