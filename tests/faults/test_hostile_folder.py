"""Processes that the package starts never import from the current folder, whatever lies there.

Source of truth: a module that leaves a trace where it is imported, under the name of every module that this
process has imported.
"""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from martensite.app.messages import Refusal
from martensite.app.worker_pool import Worker
from martensite.base.child_python import python_command, python_environment
from martensite.design.sweep.backends.dask_cluster import DaskCluster, _import_distributed, _open_client
from martensite.design.sweep.backends.processes import _open_pool
from martensite.logs.binary_files import read_arrays

TRACE = 'with open({!r}, "w") as file:\n    file.write("{}")\n'


@pytest.fixture
def hostile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The current folder holds a module of every name; no module may have been imported in the end."""
    folder, trace = tmp_path / "log", tmp_path / "trace"
    folder.mkdir()
    for name in {full.partition(".")[0] for full in sys.modules} - {"__main__"}:
        (folder / f"{name}.py").write_text(TRACE.format(str(trace), name))
    monkeypatch.chdir(folder)
    yield folder
    assert not trace.exists(), f"`{trace.read_text()}` was imported from the current folder"


@pytest.mark.usefixtures("apart")
@pytest.mark.parametrize("path", ["", "the current folder"])
def test_reading_a_log(hostile: Path, path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where `python -m` has put the current folder on the path of this process."""
    if path:
        monkeypatch.syspath_prepend(str(hostile))
    savemat("log.mat", {"time": np.arange(9.0), "position": np.arange(9.0)})
    assert sorted(read_arrays(Path("log.mat"))) == ["position", "time"]


def ask_worker() -> None:
    async def work() -> None:
        worker = Worker(Path())
        with pytest.raises(Refusal, match="No call"):
            await worker.ask("nothing", {})
        await worker.kill()

    asyncio.run(work())


def run_pool() -> None:
    with _open_pool(1) as pool:
        assert pool.submit(abs, -1).result() == 1


def run_cluster() -> None:
    with _open_client(_import_distributed(), DaskCluster(workers=1)) as client:
        assert client.submit(abs, -1).result() == 1


def run_module() -> None:
    """As ziglang is called."""
    words = python_command("-m", "json.tool")
    done = subprocess.run(words, env=python_environment(), input="1", capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "1"


@pytest.mark.usefixtures("hostile")
@pytest.mark.parametrize("start", [ask_worker, run_pool, run_module, pytest.param(run_cluster, marks=pytest.mark.slow)])
def test_starting_a_process(start: Callable[[], None]) -> None:
    if start is run_cluster:
        pytest.importorskip("distributed")
    start()


def test_the_folder_is_hostile(hostile: Path) -> None:
    """Without the precaution the trace is there."""
    subprocess.run([sys.executable, "-c", "import json"], capture_output=True, check=False)
    trace = hostile.parent / "trace"
    assert trace.exists()
    trace.unlink()
