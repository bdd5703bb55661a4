"""`run --log`, `fit` and `identify` take the same files, the product's own netCDF too; of text in their own tests.

Source of truth: the columns of the run whose files are read back.
"""

from __future__ import annotations

import re
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
from command import Command
from fences import ROOT
from scipy.io import savemat

import martensite as ms
from martensite.base.errors import DataError

EXAMPLES = ROOT / "examples"
WIRE = EXAMPLES / "constant_power.toml"
KINDS = (".nc", ".mat")
HEADS = ["time [s]", "drive [W]", "temperature [K]", "position [m]"]
IDENTIFY = ("--input", "drive", "--output", "temperature", "--stage", "oe(1,1,1)")


@pytest.fixture(scope="module")
def result() -> ms.Result:
    return ms.run(WIRE, samples=101)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, result: ms.Result) -> Path:
    """A run in two kinds of files, and a scenario that follows its drive."""
    found = tmp_path_factory.mktemp("logs")
    result.save(found / "log.nc")
    savemat(found / "log.mat", {head.partition(" ")[0]: result[head.partition(" ")[0]] for head in HEADS})
    text = re.sub(r"(?m)^waveform = .*$", 'waveform = { kind = "log", column = "drive" }', WIRE.read_text("utf-8"))
    (found / "wire.toml").write_text(text, encoding="utf-8")
    return found


def test_a_result_is_read_back_as_a_table(folder: Path, result: ms.Result) -> None:
    found = ms.read_table(folder / "log.nc")
    assert set(found.columns) == {"time", *result.columns}
    for name in found.columns:
        assert found[name].tolist() == list(result[name]), name
        assert found.units[name] == ("s" if name == "time" else result.unit(name))


def test_of_several_actuators_each_has_its_columns(tmp_path: Path) -> None:
    machine = ms.run(EXAMPLES / "antagonistic_wires.toml", samples=11)
    machine.save(tmp_path / "machine.nc")
    found = ms.read_table(tmp_path / "machine.nc")
    assert set(found.columns) == {"time", *machine.columns}
    assert found["protagonist.temperature"].tolist() == list(machine["protagonist.temperature"])


def test_a_file_without_units_names_its_columns(folder: Path, result: ms.Result) -> None:
    with pytest.raises(DataError, match=r"in which unit `drive`, `temperature`, `position` is.*in this order"):
        ms.read_table(folder / "log.mat")
    found = ms.read_table(folder / "log.mat", HEADS)
    assert found["temperature"].tolist() == list(result["temperature"])
    assert "drive" not in ms.read_table(folder / "log.mat", [HEADS[0], "-", *HEADS[2:]]).columns
    with pytest.raises(DataError, match="holds 4 columns, but 1 are named"):
        ms.read_table(folder / "log.mat", HEADS[:1])


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_follows_any_of_them(folder: Path, tmp_path: Path, kind: str) -> None:
    columns = [w for k, head in enumerate(HEADS, 1) for w in ("--as", f"{k}={head}")] if kind == ".mat" else []
    log = ["--log", str(folder / f"log{kind}"), *columns]
    told = Command("run", str(folder / "wire.toml"), "--no-figure", "--out", str(tmp_path / "o.nc"), *log).report()
    (warm,) = (one for one in told["comparison"] if one["quantity"] == "temperature")
    assert warm["rms"] < 0.02 * warm["range"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_fit_takes_any_of_them(folder: Path, kind: str) -> None:
    """The number that the run was made with is found again, from samples that smear the edges of its drive."""
    columns = [w for k, head in enumerate(HEADS, 1) for w in ("--as", f"{k}={head}")] if kind == ".mat" else []
    log = [str(folder / f"log{kind}"), *columns, "--scenario", str(folder / "wire.toml")]
    told = Command("fit", *log, "--free", "preload=0.3..0.9 N").report()
    (found,) = told["parameters"].values()
    assert found["value"] == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("kind", KINDS)
def test_identification_takes_any_of_them(folder: Path, kind: str) -> None:
    units = ["--unit", "drive=W", "--unit", "temperature=K"] if kind == ".mat" else []
    assert "RMS error" in Command("identify", str(folder / f"log{kind}"), *IDENTIFY, *units).fine()


@pytest.mark.parametrize("value", [np.inf, -np.inf])
def test_an_infinite_sample_is_refused_by_all(folder: Path, tmp_path: Path, value: float) -> None:
    """In netCDF as in text: a score of such a log would be no number."""
    path = tmp_path / "log.nc"
    path.write_bytes((folder / "log.nc").read_bytes())
    with h5netcdf.File(path, "a") as file:
        file.variables["temperature"][7] = value
    scenario = str(folder / "wire.toml")
    for words in (
        ["run", scenario, "--log", str(path), "--out", str(tmp_path / "o.nc"), "--no-figure"],
        ["fit", str(path), "--scenario", scenario, "--free", "preload=0.3..0.9 N"],
        ["identify", str(path), *IDENTIFY],
    ):
        assert "row 8, column `temperature`: numbers must be finite, but this is `" in Command(*words).refused()


def test_a_missing_sample_is_a_gap_where_there_may_be_such(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "log.nc"
    path.write_bytes((folder / "log.nc").read_bytes())
    with h5netcdf.File(path, "a") as file:
        file.variables["temperature"][7] = np.nan
    with pytest.raises(DataError, match="row 8, column `temperature`: numbers must be finite, but this is `nan`"):
        ms.read_table(path)
    assert np.isnan(ms.read_table(path, gaps=True)["temperature"][7])
