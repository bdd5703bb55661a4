"""Logs for identification in text, MAT, netCDF and Parquet files.

Source of truth: the numbers that were written, by SciPy, h5py, h5netcdf and pyarrow.
"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import pytest
from scipy.io import savemat

from martensite.base.errors import DataError, InputError
from martensite.logs.sampled_files import read_sampled, write_sampled
from martensite.signals.sampling.sampled import Sampled

TIMES = 0.02 * np.arange(50)
DUTY = np.where(TIMES > 0.3, 20.0, 0.0)
MM = 1.5 * TIMES
UNITS = {"duty": "%", "position": "mm"}


def check(found: Sampled) -> None:
    assert found.interval == pytest.approx(0.02)
    assert found.units == UNITS
    assert found.inputs[:, 0] == pytest.approx(DUTY)
    assert found.outputs[:, 0] == pytest.approx(MM)


def text(path: Path, heads: str, *columns: Any) -> Path:
    lines = [heads, *(",".join(f"{v:.9g}" for v in row) for row in zip(*columns, strict=True))]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_text(tmp_path: Path) -> None:
    log = text(tmp_path / "log.csv", "time [ms],duty [%],position [m]", 1e3 * TIMES, DUTY, 1e-3 * MM)
    check(read_sampled(log, ["duty"], ["position"], units=UNITS))
    slower = read_sampled(log, ["duty"], ["position"], interval=0.1, units=UNITS)
    assert (slower.interval, len(slower)) == (0.1, 10)


def test_text_without_times_takes_the_interval_of_its_rows(tmp_path: Path) -> None:
    log = text(tmp_path / "log.txt", "duty [%],position [mm]", DUTY, MM)
    check(read_sampled(log, ["duty"], ["position"], 0.02, UNITS))
    with pytest.raises(DataError, match="give the interval between its rows"):
        read_sampled(log, ["duty"], ["position"])


def test_what_is_written_is_read(tmp_path: Path) -> None:
    given = read_sampled(
        text(tmp_path / "a.csv", "time [s],duty [%],position [mm]", TIMES, DUTY, MM),
        ["duty"],
        ["position"],
        units=UNITS,
    )
    given.outputs[7] = np.nan
    write_sampled(given, tmp_path / "b.csv")
    back = read_sampled(tmp_path / "b.csv", ["duty"], ["position"], units=UNITS)
    assert back.outputs == pytest.approx(given.outputs, nan_ok=True)
    assert back.inputs == pytest.approx(given.inputs)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_mat(tmp_path: Path, version: str) -> None:
    path = tmp_path / "log.mat"
    arrays = {"t": TIMES[:, None], "duty": DUTY[None, :], "position": MM, "Ts": 0.02}
    if version == "5":
        savemat(path, arrays)
    else:
        with h5py.File(path, "w", userblock_size=512) as file:
            for name, array in arrays.items():
                file[name] = np.atleast_2d(np.asarray(array, dtype=float)).T
        head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"  # as MATLAB begins it
        with path.open("r+b") as raw:
            raw.write(head.ljust(512, b"\0"))
    check(read_sampled(path, ["duty"], ["position"], units=UNITS))
    with pytest.raises(DataError, match="column `position` has no unit"):
        read_sampled(path, ["duty"], ["position"], units={"duty": "%"})


def test_columns_of_a_matrix(tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", {"u": DUTY, "y": np.stack([MM, 2.0 * MM], axis=1)})
    found = read_sampled(tmp_path / "log.mat", ["u"], ["y2"], 0.02)
    assert found.outputs[:, 0] == pytest.approx(2.0 * MM)
    with pytest.raises(DataError, match="give the interval"):
        read_sampled(tmp_path / "log.mat", ["u"], ["y2"])
    savemat(tmp_path / "words.mat", {"log": {"u": "nothing"}})
    with pytest.raises(DataError, match="no numeric arrays"):
        read_sampled(tmp_path / "words.mat", ["u"], ["y"])


def test_netcdf(tmp_path: Path) -> None:
    with h5netcdf.File(tmp_path / "log.nc", "w") as file:
        file.dimensions["time"] = len(TIMES)
        for name, values, unit in (
            ("time", TIMES, "s"),
            ("duty", DUTY, "%"),
            ("position", 1e-3 * MM, "m"),
            ("temperature", MM, "degree_Celsius"),
        ):
            written = file.create_variable(name, ("time",), data=values)
            written.attrs["units"] = unit
    check(read_sampled(tmp_path / "log.nc", ["duty"], ["position"], units=UNITS))
    warm = read_sampled(tmp_path / "log.nc", ["duty"], ["temperature"])
    assert warm.outputs[:, 0] == pytest.approx(MM)


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="pyarrow is not installed")
def test_parquet(tmp_path: Path) -> None:
    import pyarrow  # type: ignore[import-not-found]
    from pyarrow import parquet  # type: ignore[import-not-found]

    columns = {"time [s]": TIMES, "duty [%]": DUTY, "position [mm]": MM, "note": ["x"] * 50}
    parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
    check(read_sampled(tmp_path / "log.parquet", ["duty"], ["position"], units=UNITS))


def test_parquet_without_pyarrow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "log.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match=r"pip install .*\[parquet\]'"):
        read_sampled(tmp_path / "log.parquet", ["duty"], ["position"])


def test_bad_files(tmp_path: Path) -> None:
    log = text(tmp_path / "log.csv", "time [s],duty [%],position [mm]", TIMES, DUTY, MM)
    with pytest.raises(DataError, match="Did you mean `position`"):
        read_sampled(log, ["duty"], ["positon"])
    with pytest.raises(DataError, match="There is no file"):
        read_sampled(tmp_path / "log.xls", ["duty"], ["position"])
    for name in ("absent.mat", "absent.csv"):
        with pytest.raises(DataError, match="There is no file"):
            read_sampled(tmp_path / name, ["duty"], ["position"])
    for name in ("junk.mat", "junk.nc"):
        (tmp_path / name).write_bytes(b"no such file" * 50)
        with pytest.raises(DataError, match="cannot be read"):
            read_sampled(tmp_path / name, ["duty"], ["position"])
    savemat(tmp_path / "log.mat", {"t": TIMES[::-1], "duty": DUTY, "position": MM})
    with pytest.raises(DataError, match="time must increase"):
        read_sampled(tmp_path / "log.mat", ["duty"], ["position"], units=UNITS)


def test_a_wrong_number_would_be_noticed(tmp_path: Path) -> None:
    log = text(tmp_path / "log.csv", "time [s],duty [%],position [m]", TIMES, DUTY, MM)
    with pytest.raises(AssertionError):
        check(read_sampled(log, ["duty"], ["position"], units=UNITS))
