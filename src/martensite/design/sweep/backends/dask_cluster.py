"""Chunks on a Dask cluster: a running one, or processes of this machine.

Every task computes one chunk and writes it into its region of the store, which all workers reach under the same path.
Dask repeats a task whose worker dies. A task that has killed several workers is salvaged in processes of this machine
(`martensite.design.sweep.backends.processes`). A few tasks per thread are in progress at a time, so a scheduler never
has a whole sweep. <https://distributed.dask.org/en/stable/resilience.html>
"""

from __future__ import annotations

import logging
import os
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from typing import TYPE_CHECKING, Any

from martensite.base.child_python import safe_children
from martensite.base.errors import InputError, StoppedError
from martensite.base.lazy import write_install_line
from martensite.design.sweep.backends.base import BACKENDS, AbstractBackend, Report
from martensite.design.sweep.backends.processes import count_cores, salvage_chunk

if TYPE_CHECKING:
    from martensite.design.sweep.job import SweepJob

PATIENCE = 10.0
"""Time limit for the answer of a scheduler [s]."""
RETRIES = 2
"""Number of repetitions of a failed task, elsewhere if possible."""
CLIENT_LOGS = ("distributed.client", "distributed.core", "distributed.batched")
AHEAD = 2
"""Tasks in progress per thread."""


@BACKENDS.register("dask")
@dataclass(frozen=True)
class DaskCluster(AbstractBackend):
    """Workers of a Dask cluster."""

    workers: int = 0
    """Processes of a cluster on this machine; 0 for one per core."""
    scheduler: str | None = None
    """Address of a scheduler, such as tcp://host:8786; None for a cluster on this machine."""

    def __post_init__(self) -> None:
        """Raise `InputError` for workers with a running cluster."""
        if self.scheduler and self.workers:
            raise InputError(
                "Option `--workers` has no effect on a Dask cluster that is running; "
                "leave out `--workers` or `--scheduler`."
            )

    def run(self, job: SweepJob, chunks: Iterable[int]) -> Generator[Report]:
        """Run chunks as tasks, and yield their reports in the order in which they end.

        Raises:
            InputError: Dask is not installed, or no scheduler answers.
            StoppedError: the scheduler is lost.
        """
        dask = _import_distributed()
        try:
            with _mute_client(), _open_client(dask, self) as client:
                yield from _collect_reports(dask, client, job, iter(chunks))
        except (dask.CancelledError, dask.comm.CommClosedError, TimeoutError) as error:
            first = (str(error).splitlines() or ["no answer"])[0].rstrip(":")
            raise StoppedError(
                f"The Dask scheduler is gone ({first}). Chunks that were made are kept; give the same command again "
                "with one that runs: it goes on from there."
            ) from None


def _collect_reports(dask: Any, client: Any, job: SweepJob, waiting: Iterator[int]) -> Iterator[Report]:
    under_way: dict[Any, int] = {}
    run = os.urandom(4).hex()
    try:
        while True:
            room = AHEAD * max(sum(client.ncores().values()), 1) - len(under_way)
            for chunk in islice(waiting, max(room, 0)):
                key = f"martensite-{run}-{chunk}"
                under_way[client.submit(job, chunk, key=key, pure=False, retries=RETRIES)] = chunk
            if not under_way:
                return
            with client.as_current():
                done = dask.wait(list(under_way), return_when="FIRST_COMPLETED").done
            for future in done:
                yield _build_report(dask, future, job, under_way.pop(future))
    finally:
        client.cancel(list(under_way))


def _build_report(dask: Any, future: Any, job: SweepJob, chunk: int) -> Report:
    """Return the report of a finished task."""
    try:
        return future.result()
    except dask.KilledWorker:
        return salvage_chunk(job, chunk)
    except RuntimeError as error:
        if not future.cancelled():  # an error of the task itself
            raise
        raise StoppedError(
            f"Dask gave up a task ({str(error).splitlines()[0]}): scheduler and workers need the same packages as this "
            "process. Chunks that were made are kept; give the same command again."
        ) from None


@contextmanager
def _mute_client() -> Iterator[None]:
    """Hide the logs of Dask's client about a lost scheduler; an error replaces them."""

    def is_other(record: logging.LogRecord) -> bool:
        return record.name not in CLIENT_LOGS

    handlers = list(logging.getLogger("distributed").handlers)
    for handler in handlers:
        handler.addFilter(is_other)
    try:
        yield
    finally:
        for handler in handlers:
            handler.removeFilter(is_other)


@contextmanager
def _open_client(dask: Any, wanted: DaskCluster) -> Iterator[Any]:
    """Yield a client of a cluster, and close both at the end."""
    if wanted.scheduler is not None:
        with _connect_client(dask, wanted.scheduler) as client:
            yield client
        return
    with (  # a worker that died is started again at any time
        safe_children(),
        dask.LocalCluster(
            n_workers=wanted.workers or count_cores(), threads_per_worker=1, dashboard_address="127.0.0.1:0"
        ) as cluster,
        _connect_client(dask, cluster) as client,
    ):
        yield client


def _connect_client(dask: Any, address: Any) -> Any:
    try:
        return dask.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(f"No Dask scheduler answers at `{address}`: {error}.") from None


def _import_distributed() -> Any:
    try:
        return import_module("distributed")
    except ImportError:
        raise InputError(
            f"The backend `dask` needs Dask, which is not installed; run `{write_install_line('cluster')}`."
        ) from None
