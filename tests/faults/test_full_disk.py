"""A disk that is full, or a process that is told to end, leaves what was there and nothing half-written.

Source of truth: the bytes that were there before; the sentence of the operating system.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from command import Command
from fences import ROOT

import martensite as ms
from martensite.app.calls import sweep_form
from martensite.base.errors import DataError
from martensite.base.files import replace_together, write_file
from martensite.base.summary import Sentence, Summary
from martensite.export.fmu import to_fmu
from martensite.logs.sampled_files import write_sampled
from martensite.scenario.csv_files import write_csv
from martensite.scenario.model_files import write_model
from martensite.show.pages import write_page
from martensite.signals.sampling.sampled import Sampled

EXAMPLE = ROOT / "examples" / "constant_power.toml"
SMALL = 512
"""Bytes that a file may have, where the disk is full."""


@pytest.fixture(scope="module")
def result() -> ms.Result:
    return ms.run(EXAMPLE)


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No file grows beyond `SMALL` bytes, as on a disk without room."""
    resource = pytest.importorskip("resource")
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # what is imported first here would be cut for ever
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    heard = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, heard)


def record() -> Sampled:
    columns = np.arange(500.0)
    return Sampled("a", 0.1, columns, columns, ("u",), ("y",), {"u": "V", "y": "m"})


def page(path: Path) -> None:
    write_page(Summary("a", [Sentence("long " * 400)], {}, ""), path)


Writer = Callable[[ms.Result, Path], object]
WRITERS: dict[str, Writer] = {
    "a.nc": lambda result, path: result.save(path),
    "a.csv": write_csv,
    "b.csv": lambda _, path: write_sampled(record(), path),
    "a.png": lambda result, path: result.plot(path),
    "a.svg": lambda result, path: result.plot(path),
    "a.html": lambda _, path: page(path),
    "a.md": lambda _, path: page(path),
    "a.json": lambda _, path: write_model(ms.identify.read_model(ROOT / "examples/model_run.json"), path),
    "a.fmu": lambda _, path: to_fmu(ms.load(EXAMPLE), path, platforms=[]),
    "a.h": lambda _, path: ms.export.build_c_core(ms.load(EXAMPLE).system, name="a").write(path.parent),
}


@pytest.mark.parametrize("name", WRITERS)
def test_the_old_file_stays(result: ms.Result, tmp_path: Path, full: None, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"old")
    with pytest.raises(DataError) as told:
        WRITERS[name](result, path)
    assert str(told.value) == f"The file `{path}` could not be written: File too large."
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_a_copy_of_a_store_too(tmp_path: Path, full: None) -> None:
    (tmp_path / "a.zarr").mkdir()
    (tmp_path / "a.zarr" / "c").write_bytes(bytes(400))
    with pytest.raises(DataError, match=r"a\.zip` could not be written: File too large"):
        sweep_form.write_zip(tmp_path / "a.zarr", tmp_path / "a.zip")
    assert [one.name for one in tmp_path.iterdir()] == ["a.zarr"]


@pytest.mark.parametrize("figure", ["a.png", "a.pdf"])
def test_run_writes_all_of_its_files_or_none(tmp_path: Path, full: None, figure: str) -> None:
    target = ["--out", str(tmp_path / "a.nc"), "--figure", str(tmp_path / figure)]
    said = Command("run", str(EXAMPLE), *target).refused()
    assert "could not be written: File too large." in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root mounts a file system")
def test_on_a_file_system_without_room(result: ms.Result, tmp_path: Path) -> None:
    mount = ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", str(tmp_path)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("this machine mounts nothing")
    try:
        with pytest.raises(DataError, match=r"a\.nc` could not be written: No space left on device"):
            result.save(tmp_path / "a.nc")
        assert list(tmp_path.iterdir()) == []
    finally:
        subprocess.run(["umount", str(tmp_path)], check=True)


def test_files_that_belong_together_appear_together(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="does not exist"), replace_together():
        write_file(tmp_path / "a", "new")
        assert not (tmp_path / "a").exists()
        write_file(tmp_path / "none" / "b", "new")
    assert list(tmp_path.iterdir()) == []
    with replace_together():
        write_file(tmp_path / "a", "new")
        write_file(tmp_path / "b", b"new")
    assert {one.name: one.read_text() for one in tmp_path.iterdir()} == {"a": "new", "b": "new"}


ENDED = """
import signal, sys, time
from pathlib import Path
from martensite.base.files import replace_file, replace_together, write_file
{before}
folder = Path(sys.argv[1])
with replace_together():
    write_file(folder / "a.nc", "new")
    with replace_file(folder / "b.nc") as part:
        part.write_text("half")
        print(len(list(folder.iterdir())), flush=True)
        time.sleep(60)
"""
ANSWERED = "signal.signal(signal.SIGTERM, lambda *_: sys.exit(3))"


@pytest.mark.skipif(sys.platform == "win32", reason="ends processes without a signal")
@pytest.mark.parametrize(("before", "code"), [("", -signal.SIGTERM), (ANSWERED, 3)])
def test_a_process_that_is_told_to_end_leaves_nothing(tmp_path: Path, before: str, code: int) -> None:
    """Whether the program answers the signal itself, as one with a clean end of its own does, or not."""
    command = [sys.executable, "-c", ENDED.format(before=before), str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "2\n"
        process.terminate()
        assert process.wait(20) == code
    assert list(tmp_path.iterdir()) == []
