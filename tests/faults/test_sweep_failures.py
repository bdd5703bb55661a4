"""What goes wrong on the way, and that nothing is lost by it: every case ends with the same bits.

Sources of truth: the same sweep, undisturbed; jobs whose runs double their number.
"""

from __future__ import annotations

import errno
import resource
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sweep_cases import Doubling, Poison, arrays, undisturbed, wanted, wire

from martensite.base.errors import DataError, InputError, StoppedError
from martensite.base.status import Status
from martensite.design.sweep.api import Progress, SweepExecution, begin_sweep
from martensite.design.sweep.backends.base import MOST_LOST, keep_runs
from martensite.design.sweep.store import Store

SERIAL = SweepExecution("serial")


# ---------------------------------------------------------------- runs that raise


def kept_of(job: Doubling, chunk: int) -> tuple[list[float], tuple[str, ...]]:
    piece, remarks = keep_runs(job, chunk, job.compute)
    return piece.scalars["double"].tolist(), remarks


def test_a_run_that_raises_is_the_only_one_lost(tmp_path: Path) -> None:
    job = Doubling(tmp_path, failing=(4, 6))
    numbers, (remark,) = kept_of(job, 1)
    np.testing.assert_array_equal(numbers, [np.nan, 10.0, np.nan, 14.0])
    assert "run 4, 6 (Poison: no)" in remark
    assert kept_of(job, 2) == ([16.0, 18.0, 20.0, 22.0], ())


def test_a_chunk_that_is_lost_as_a_whole_stops_the_sweep(tmp_path: Path) -> None:
    job = Doubling(tmp_path, size=MOST_LOST, chunk=MOST_LOST, failing=tuple(range(MOST_LOST)))
    with pytest.raises(StoppedError, match=r"32 runs of chunk 0 .*run 0, 1.*Poison"):
        kept_of(job, 0)


def test_an_error_on_purpose_is_not_salvaged(tmp_path: Path) -> None:
    job = Doubling(tmp_path, failing=(1,), error=DataError("no compiler"))
    with pytest.raises(DataError, match="no compiler"):
        kept_of(job, 0)


def test_a_run_of_a_sweep_that_raises_is_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = undisturbed(tmp_path / "whole.zarr")
    begun = begin_sweep(wire(), wanted(), tmp_path / "s.zarr", SERIAL)
    compute = type(begun.plan).compute

    def poisoned(plan: Any, rows: range) -> Any:
        if 7 in rows:
            raise Poison("seven")
        return compute(plan, rows)

    monkeypatch.setattr(type(begun.plan), "compute", poisoned)
    (remark,) = begun.run().remarks
    assert "run 7 (Poison: seven)" in remark
    for name, data in arrays(tmp_path / "s.zarr"):
        if name == "made":  # of chunks
            continue
        width = len(data) // 12
        row = slice(7 * width, 8 * width)
        assert data[: row.start] == expected[name][: row.start]
        assert data[row.stop :] == expected[name][row.stop :]
    assert Store(tmp_path / "s.zarr").group["status"][7] == Status.LOST


# ---------------------------------------------------------------- disks


@contextmanager
def small_files(most: int) -> Any:
    """No file may be longer: the system refuses to write on."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_disk_that_takes_no_more_stops_the_sweep_and_it_goes_on(tmp_path: Path) -> None:
    expected = undisturbed(tmp_path / "whole.zarr")
    path = tmp_path / "s.zarr"
    limit = small_files(4)

    def tell(now: Progress) -> None:
        if now.new_runs == 6:
            limit.__enter__()

    begun = begin_sweep(wire(), wanted(), path, SERIAL)
    try:
        with pytest.raises(StoppedError, match=r"Chunk 2 of .* could not be written: .*goes on"):
            begun.run(tell)
    finally:
        limit.__exit__(None, None, None)
    assert StoppedError.exit_code == 1
    assert Store(path).list_finished_chunks() == {0, 1}
    assert begin_sweep(wire(), wanted(), path, SERIAL).run().new_runs == 6
    assert dict(arrays(path)) == expected


def test_a_full_disk_is_called_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = begin_sweep(wire(), wanted(), tmp_path / "s.zarr", SERIAL)

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("zarr.storage._local._put", full)
    with pytest.raises(StoppedError, match="the disk is full"):
        begun.run()
    with pytest.raises(StoppedError, match="could not be made: the disk is full"):
        begin_sweep(wire(), wanted(), tmp_path / "t.zarr", SERIAL)
    assert [path.name for path in tmp_path.iterdir()] == ["s.zarr"]


def test_a_folder_that_cannot_be_written_is_bad_input(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"There is no folder .*file` to write"):
        begin_sweep(wire(), wanted(), tmp_path / "file" / "s.zarr", SERIAL)


# ---------------------------------------------------------------- interruptions


def test_ctrl_c_is_a_sentence_and_it_goes_on(tmp_path: Path) -> None:
    expected = undisturbed(tmp_path / "whole.zarr")
    path = tmp_path / "s.zarr"

    def tell(now: Progress) -> None:
        if now.new_runs == 3:
            raise KeyboardInterrupt

    with pytest.raises(StoppedError, match="Interrupted when 3 of 12 runs were there"):
        begin_sweep(wire(), wanted(), path, SERIAL).run(tell)
    assert begin_sweep(wire(), wanted(), path, SERIAL).run().new_runs == 9
    assert dict(arrays(path)) == expected


# ---------------------------------------------------------------- several at a time


def test_whoever_comes_second_opens_what_the_first_has_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both find nothing there; one is faster."""
    path = tmp_path / "s.zarr"
    rename = Path.rename

    def late(part: Path, target: Path) -> Path:
        monkeypatch.setattr(Path, "rename", rename)
        begin_sweep(wire(), wanted(), path, replace(SERIAL, part="1/4")).run()
        return rename(part, target)

    monkeypatch.setattr(Path, "rename", late)
    second = begin_sweep(wire(), wanted(), path, SERIAL)
    assert second.store.list_finished_chunks() == {0}
    assert second.run().new_runs == 9
    assert [one.name for one in tmp_path.iterdir()] == ["s.zarr"]


# ---------------------------------------------------------------- the tests themselves
