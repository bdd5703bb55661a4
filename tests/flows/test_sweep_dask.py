"""Sweeps over a Dask cluster: the same bits, and nothing lost with its workers.

Sources of truth: the same sweep in this process; jobs whose runs double their number.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from threading import Timer
from typing import Any

import pytest
from sweep_cases import Doubling, arrays, ran, undisturbed, wanted, wire

from martensite.base.errors import InputError, StoppedError
from martensite.base.status import Status
from martensite.design.sweep.api import SweepExecution, begin_sweep
from martensite.design.sweep.backends import dask_cluster
from martensite.design.sweep.backends.base import Report
from martensite.design.sweep.backends.dask_cluster import DaskCluster

distributed: Any = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """A cluster of threads that speaks TCP, as one elsewhere would."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address="127.0.0.1:0"
    ) as cluster:
        yield cluster.scheduler_address


def test_a_cluster_makes_the_same_bits(scheduler: str, tmp_path: Path) -> None:
    expected = undisturbed(tmp_path / "whole.zarr")
    path = tmp_path / "s.zarr"
    assert begin_sweep(wire(), wanted(), path, SweepExecution("dask", scheduler=scheduler)).run().new_runs == 12
    assert dict(arrays(path)) == expected
    assert begin_sweep(wire(), wanted(), path, SweepExecution("dask", scheduler=scheduler)).run().new_runs == 0


@dataclass(frozen=True)
class Counted(Doubling):
    """Says how many of its chunks have been asked for when one is made."""

    def asked(self) -> Iterator[int]:
        for chunk in self.chunks:
            (self.path / "asked").write_text(str(chunk + 1))
            yield chunk


def test_few_tasks_are_under_way_at_a_time(scheduler: str, tmp_path: Path) -> None:
    job = Counted(tmp_path, size=120)
    for made, _ in enumerate(DaskCluster(scheduler=scheduler).run(job, job.asked()), 1):
        under_way = int((tmp_path / "asked").read_text()) - made
        assert under_way <= 2 * dask_cluster.AHEAD
    assert job.stored() == job.expected()


@dataclass(frozen=True)
class Hesitant(Doubling):
    """Fails at its first chunk the first time."""

    def __call__(self, chunk: int) -> Report:
        mark = self.path / "failed"
        if chunk == 0 and not mark.exists():
            mark.touch()
            raise OSError("the network was away")
        return super().__call__(chunk)


def test_a_task_that_fails_is_made_again(scheduler: str, tmp_path: Path) -> None:
    assert ran(DaskCluster(scheduler=scheduler), Hesitant(tmp_path)).status == {Status.OK: 24}
    assert (tmp_path / "failed").exists()


@dataclass(frozen=True)
class Stubborn(Doubling):
    """Cannot write."""

    def store(self, *_: Any, **__: Any) -> Report:
        raise StoppedError("Chunk 0 could not be written: the disk is full.")


def test_an_error_on_purpose_stops_the_sweep(scheduler: str, tmp_path: Path) -> None:
    with pytest.raises(StoppedError, match="the disk is full"):
        ran(DaskCluster(scheduler=scheduler), Stubborn(tmp_path))


class Ended:
    """A task that ended with an error."""

    def __init__(self, error: Exception) -> None:
        self.error = error

    def result(self) -> Report:
        raise self.error


def test_what_kills_workers_is_salvaged(tmp_path: Path) -> None:
    job = Doubling(tmp_path, size=2, chunk=2, deadly=(1,))
    killed = distributed.KilledWorker("task", None, 3)
    report = dask_cluster._build_report(distributed, Ended(killed), job, 0)
    assert report.status == {Status.OK: 1, Status.LOST: 1}
    assert "run 1 (RuntimeError: its process died)" in report.remarks[1]


@pytest.mark.parametrize("error", [distributed.CancelledError("a"), distributed.comm.CommClosedError("closed")])
@pytest.mark.parametrize("place", ["wait", "Client.submit", "Client.cancel"])
def test_a_scheduler_that_is_lost_is_a_sentence(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str, error: Exception
) -> None:
    """Wherever it is noticed, it is the same as when it is gone."""

    def lost(*_: Any, **__: Any) -> Any:
        raise error

    monkeypatch.setattr(f"distributed.{place}", lost)
    with pytest.raises(StoppedError, match=r"scheduler is gone.*goes on"):
        ran(DaskCluster(scheduler=scheduler), Doubling(tmp_path))


@pytest.mark.slow
def test_a_scheduler_that_is_killed_is_a_sentence(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Its process is gone, and so is the noise of those that look for it."""
    words = "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", "at.json"
    same = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}  # the job is of a module of the tests
    with subprocess.Popen([sys.executable, *words], cwd=tmp_path, stderr=subprocess.DEVNULL, env=same) as running:
        file = tmp_path / "at.json"
        while not file.exists():
            assert running.poll() is None
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        Timer(2.0, running.kill).start()  # nobody works there: it waits
        with pytest.raises(StoppedError, match=r"scheduler is gone.*goes on"):
            ran(DaskCluster(scheduler=address), Doubling(tmp_path))
    assert "Traceback" not in capfd.readouterr().err


def test_a_scheduler_that_does_not_answer_is_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_cluster, "PATIENCE", 0.2)
    for address in ("tcp://127.0.0.1:1", "nonsense://"):
        with pytest.raises(InputError, match=f"No Dask scheduler answers at `{address}`"):
            next(DaskCluster(scheduler=address).run(Doubling(Path()), [0]))


def test_without_dask_it_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install .*\[cluster\]'"):
        next(DaskCluster().run(Doubling(Path()), [0]))


@pytest.mark.slow
def test_workers_that_die_on_a_cluster_of_processes(tmp_path: Path) -> None:
    """One task kills every worker that it comes to; Dask itself gives it up."""
    dask: Any = pytest.importorskip("dask")

    with dask.config.set({"distributed.scheduler.allowed-failures": 1}):
        found = ran(DaskCluster(workers=2), Doubling(tmp_path, size=16, deadly=(5,)))
    assert found.status == {Status.OK: 15, Status.LOST: 1}
    assert any("run 5 (RuntimeError: its process died)" in remark for remark in found.remarks)
    assert (tmp_path / "dead").exists()
