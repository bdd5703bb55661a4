"""Saved results: the file equals the dataset, says its units, and is never half-written.

Source of truth: the hand-made result below (its numbers are exact in binary), and the spelling
of units in the CF conventions, which pint reads as well.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5netcdf
import h5py
import numpy as np
import pytest
from builders import plain_system
from fences import ROOT

import martensite as ms
from martensite.base.errors import DataError, UnknownNameError
from martensite.base.status import Status
from martensite.scenario.netcdf import describe_result, read_labelled, save_result
from martensite.signals.base import AbstractWaveform
from martensite.simulate.result import Result

if TYPE_CHECKING:
    import xarray

SCENARIO = '[run]\nduration = "4 s"  # Dauer: ξ, σ\n'
CITED = ("liang1990", "tanaka1986")
TIMES = [0.0, 0.5, 1.0, 1.5, 2.0]
OUTPUTS = plain_system().outputs()


class Ramp(AbstractWaveform):
    def value(self, time: float) -> float:
        return time


def make_result(accuracy: float | None = 0.000125, status_time: float | None = 0.5) -> Result:
    times: Any = TIMES
    columns: Any = {name: [i + t / 8 for t in TIMES] for i, name in enumerate(OUTPUTS)}
    return Result(
        plain_system(),
        Ramp(),
        times,
        columns,
        Status.LONG_STEP,
        status_time,
        40,
        0.05,
        accuracy,
        ["Warning: one.", "Warning: two."],
    )


def load_example(name: str) -> ms.Scenario:
    return ms.load(ROOT / "examples" / name)


def comparable(dataset: xarray.Dataset) -> xarray.Dataset:
    """The dataset without the time at which it was made."""
    dataset = dataset.copy()
    assert dataset.attrs.pop("created").endswith("+00:00")
    return dataset


@pytest.mark.parametrize("known", [True, False])
def test_a_saved_result_is_the_dataset(tmp_path: Path, known: bool) -> None:
    import xarray

    result = make_result() if known else make_result(None, None)
    scenario, citations = (SCENARIO, CITED) if known else ("", ())
    save_result(result, tmp_path / "a.nc", scenario, citations)
    made = comparable(describe_result(result, scenario, None, citations).to_xarray())
    for read in (xarray.load_dataset(tmp_path / "a.nc"), read_labelled(tmp_path / "a.nc").to_xarray()):
        xarray.testing.assert_identical(comparable(read), made)
        assert {n: v.dtype for n, v in read.variables.items()} == {n: v.dtype for n, v in made.variables.items()}


def test_xarray_and_the_package_read_the_same(tmp_path: Path) -> None:
    """Of a batch, with texts, and of several actuators too."""
    import xarray

    wire = load_example("pwm_bias_spring.toml")
    batch = ms.run(wire, over={"preload": ["1 N", "2 N"]}, duration="2 s", step=0.02, samples=5)
    for name, result in (("batch", batch), ("machine", ms.run(load_example("antagonistic_wires.toml"), samples=11))):
        result.save(tmp_path / f"{name}.nc")
        read = read_labelled(tmp_path / f"{name}.nc").to_xarray()
        xarray.testing.assert_identical(read, xarray.load_dataset(tmp_path / f"{name}.nc"))
        assert any(one.dtype == object for one in read.variables.values())


def test_the_dataset_holds_the_columns() -> None:
    result = make_result()
    dataset = result.to_xarray()
    assert set(dataset.data_vars) == set(OUTPUTS)
    assert list(dataset.coords) == ["time"]
    np.testing.assert_array_equal(dataset["time"], TIMES)
    for name in OUTPUTS:
        np.testing.assert_array_equal(dataset[name], result[name])


def test_every_variable_is_labelled_in_the_file(tmp_path: Path) -> None:
    import pint

    save_result(make_result(), tmp_path / "a.nc")
    with h5netcdf.File(tmp_path / "a.nc", "r") as file:
        found = {name: dict(variable.attrs) for name, variable in file.variables.items()}
    assert found["time"]["units"] == "s"
    assert found["drive"]["units"] == "V"
    for name, (unit, long_name, symbol) in OUTPUTS.items():
        assert found[name]["units"] == ("V" if name == "drive" else unit)
        assert (found[name]["long_name"], found[name]["symbol"]) == (long_name, symbol)
    for attributes in found.values():
        assert pint.Unit(attributes["units"]) is not None


def test_times_stay_numbers(tmp_path: Path) -> None:
    save_result(make_result(), tmp_path / "a.nc")
    assert read_labelled(tmp_path / "a.nc")["time"].values.dtype == np.float64


def test_provenance_is_in_the_file(tmp_path: Path) -> None:
    save_result(make_result(), tmp_path / "a.nc", SCENARIO, CITED)
    attributes = read_labelled(tmp_path / "a.nc").attrs
    assert attributes["Conventions"] == "CF-1.10"
    assert attributes["scenario"] == SCENARIO
    assert attributes["citations"].split(", ") == list(CITED)
    assert attributes["status"] == "LONG_STEP"
    assert attributes["accuracy"] == 0.000125
    assert (attributes["steps"], attributes["step"]) == (40, 0.05)
    assert attributes["warnings"].split("\n") == ["Warning: one.", "Warning: two."]
    assert attributes["numpy_version"] == np.__version__
    assert attributes["h5netcdf_version"] == h5netcdf.__version__
    assert attributes["martensite_version"]
    assert "liang-rogers" in attributes["title"]


def test_what_was_not_estimated_is_no_number() -> None:
    attributes = describe_result(make_result(None, None)).attrs
    assert "accuracy" not in attributes and "status_time" not in attributes


def test_a_long_scenario_is_kept_whole(tmp_path: Path) -> None:
    text = "# σ\n" * 40_000  # more than the 64 KiB that HDF5 keeps in an object header
    save_result(make_result(), tmp_path / "a.nc", text)
    assert read_labelled(tmp_path / "a.nc").attrs["scenario"] == text


def test_a_failed_replacement_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.nc"
    save_result(make_result(), target)
    before = target.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(DataError, match=r"a\.nc.*could not be written: No space left"):
        save_result(make_result(None), target, SCENARIO)
    assert target.read_bytes() == before
    assert list(tmp_path.iterdir()) == [target]


FULL_DISK = """
import resource, signal, sys
sys.path[:0] = {path!r}
from test_netcdf import DataError, make_result, save_result
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for limit, file in {files!r}:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        save_result(make_result(), file, "# scenario" * 3000)
    except DataError as error:
        print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits the size of files as POSIX does")
def test_a_disk_that_fills_is_a_sentence(tmp_path: Path) -> None:
    """HDF5 would end the process with a segmentation fault when it cannot finish its file."""
    files = [(limit, str(tmp_path / f"{limit}.nc")) for limit in (1, 30_000, 10_000_000)]
    code = FULL_DISK.format(path=[str(Path(__file__).parent), *sys.path], files=files)
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "".join(f"The file `{one}` could not be written: File too large.\n" for _, one in files[:2])
    assert [one.name for one in tmp_path.iterdir()] == ["10000000.nc"]


def test_saving_replaces_an_older_file(tmp_path: Path) -> None:
    target = tmp_path / "a.nc"
    target.write_text("old")
    save_result(make_result(), target)
    assert len(read_labelled(target)["time"].values) == len(TIMES)
    assert list(tmp_path.iterdir()) == [target]


def test_a_missing_folder_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="folder"):
        save_result(make_result(), tmp_path / "none" / "a.nc")


def test_reading_what_is_no_result_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no file"):
        read_labelled(tmp_path / "absent.nc")
    (tmp_path / "text.nc").write_text("not a netCDF file")
    with pytest.raises(DataError, match=r"text\.nc.*cannot be read"):
        read_labelled(tmp_path / "text.nc")
    with h5netcdf.File(tmp_path / "other.nc", "w") as file:
        file.attrs["title"] = "something else"
    with pytest.raises(DataError, match="lacks `time`"):
        read_labelled(tmp_path / "other.nc")
    with h5py.File(tmp_path / "loop.nc", "w") as file:
        file["time"] = h5py.SoftLink("/time")
    with pytest.raises(DataError, match=r"loop\.nc.*cannot be read"):
        read_labelled(tmp_path / "loop.nc")


def test_a_name_that_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    save_result(make_result(), tmp_path / "a.nc")
    saved = read_labelled(tmp_path / "a.nc")
    with pytest.raises(UnknownNameError, match="Did you mean `temperature`"):
        saved["temperatur"]
    assert "temperature [K] ('time',) (5,)" in repr(saved)
