"""Stores of sweeps as xarray datasets, and as tables.

Sources of truth: the same variants, each loaded and run by itself; and what is in the store.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sweep_cases
from sweep_cases import wanted, wire

from martensite.base.errors import DataError
from martensite.base.status import Status
from martensite.design.sweep.api import SweepExecution, begin_sweep
from martensite.design.sweep.indices import compute_sensitivity
from martensite.design.sweep.reading import open_sweep, read_sweep
from martensite.design.sweep.store import Store

DIAMETER, HIGH = "element.diameter", "drive.waveform.high"
PART = SweepExecution("serial", part="1/2")


def swept(path: Path, how: SweepExecution = PART, **more: Any) -> Path:
    begin_sweep(wire(), wanted(traces=(("temperature", 4),), **more), path, how).run()
    return path


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A grid of 3 by 4, all of it made."""
    return swept(tmp_path_factory.mktemp("whole") / "grid.zarr", SweepExecution("serial"))


@pytest.fixture
def half(tmp_path: Path) -> Path:
    """Chunks 0 and 2 of 4."""
    return swept(tmp_path / "half.zarr")


@pytest.fixture
def failed(store: Path, tmp_path: Path) -> Path:
    """Run 5 failed, as its status says."""
    import zarr

    path = tmp_path / "failed.zarr"
    shutil.copytree(store, path)
    group: Any = zarr.open_group(str(path), mode="r+")
    group["status"][5] = int(Status.UNSOLVED)
    group["made"][1] = Store(path).digest_chunk(1)
    return path


def test_a_grid_has_its_axes_as_dimensions(store: Path) -> None:
    found = open_sweep(store)
    assert found["stroke"].dims == (DIAMETER, HIGH)
    assert found["temperature"].dims == (DIAMETER, HIGH, "time of temperature")
    assert found[DIAMETER].values == pytest.approx([0.12e-3, 0.16e-3, 0.2e-3], rel=1e-12)
    assert found[HIGH].values == pytest.approx([2.0, 8 / 3, 10 / 3, 4.0], rel=1e-12)
    assert found[DIAMETER].attrs["units"] == "m"
    assert found["stroke"].attrs["units"] == "m"
    assert found["time of temperature"].values[[0, -1]].tolist() == [0.0, 2.0]


@pytest.mark.parametrize("place", [(0, 3), (2, 1)])
def test_a_cell_is_that_variant_run_by_itself(store: Path, place: tuple[int, int]) -> None:
    found = open_sweep(store).isel({DIAMETER: place[0], HIGH: place[1]})
    values = {DIAMETER: f"{float(found[DIAMETER])!r} m", HIGH: f"{float(found[HIGH])!r} V"}
    run = wire(**{k.replace(".", "__"): v for k, v in values.items()}).run()
    assert float(found["stroke"]) == pytest.approx(np.ptp(run["position"]), rel=1e-9)
    shown = np.interp(found["time of temperature"], run.times, run["temperature"])
    assert found["temperature"].values == pytest.approx(shown, rel=1e-9)


def test_a_grid_that_is_turned_is_noticed(store: Path) -> None:
    found = open_sweep(store)["max(temperature)"].values
    flat = open_sweep(store, grid=False)["max(temperature)"].values
    assert np.array_equal(found, flat.reshape(3, 4))
    assert not np.array_equal(found, flat.reshape(4, 3).T)


def test_runs_are_one_dimension_if_asked_for(store: Path) -> None:
    found = open_sweep(store, grid=False)
    assert found["stroke"].dims == ("run",)
    assert found["run"].values.tolist() == list(range(12))
    assert found[HIGH].values == pytest.approx(np.tile([2.0, 8 / 3, 10 / 3, 4.0], 3), rel=1e-12)


def test_nothing_is_read_before_it_is_asked_for(store: Path) -> None:
    pytest.importorskip("dask")
    for grid in (True, False):
        found = open_sweep(store, grid)
        assert all(found[name].chunks for name in ("stroke", "temperature"))


def test_what_was_asked_for_is_in_the_attributes(store: Path) -> None:
    told = open_sweep(store).attrs
    assert told["scenario"] == wire().text
    assert (told["sample"], told["seed"], told["step"]) == ("grid", 0, 0.1)
    assert (told["runtime"], told["precision"]) == ("floats", "float64")
    assert told["over"] == list(sweep_cases.OVER)
    assert str(Path.cwd()) not in str(told)


def test_it_is_written_as_netcdf(store: Path, tmp_path: Path) -> None:
    import xarray

    found = open_sweep(store).load()
    found.to_netcdf(tmp_path / "sweep.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as again:
        xarray.testing.assert_equal(found, again)
        assert list(again.attrs["over"]) == found.attrs["over"]


def test_runs_that_are_not_made_say_so(half: Path) -> None:
    found, flat = open_sweep(half), open_sweep(half, grid=False)
    gone = np.repeat([False, True, False, True], 3)
    assert np.array_equal(flat["status"].values == -1, gone)
    assert np.array_equal(np.isnan(flat["stroke"].values), gone)
    assert np.array_equal(np.isnan(flat["temperature"].values).all(axis=1), gone)
    assert np.array_equal(np.isnan(found["stroke"].values).ravel(), gone)
    assert not np.isnan(found[HIGH].values).any()
    assert found["status"].attrs["flag_meanings"].split()[0] == "not_made"
    table = read_sweep(half)
    assert (table.missing, table.failed) == (6, 0)


def test_what_was_written_of_a_chunk_that_is_not_made_does_not_count(half: Path) -> None:
    import zarr

    group: Any = zarr.open_group(str(half), mode="r+")
    group["stroke"][3:6] = 1.0
    assert np.isnan(open_sweep(half, grid=False)["stroke"].values[3:6]).all()
    assert np.isnan(read_sweep(half).measures["stroke"].values[3:6]).all()


def test_a_run_that_failed_has_no_numbers(store: Path, failed: Path) -> None:
    whole, found = open_sweep(store, grid=False), open_sweep(failed, grid=False)
    others = np.arange(12) != 5
    for name in ("stroke", "temperature"):
        assert np.isnan(found[name].values[5]).all()
        assert np.array_equal(found[name].values[others], whole[name].values[others])
        assert found[name].attrs == whole[name].attrs
    assert found[DIAMETER].values[5] == whole[DIAMETER].values[5]
    assert read_sweep(failed).failed == 1


def test_samples_have_no_grid(tmp_path: Path) -> None:
    over = "diameter=0.12..0.2 mm log", "length=+- 2 %"
    path = tmp_path / "sobol.zarr"
    begin_sweep(wire(), wanted(*over, sample="sobol:4"), path, SweepExecution("serial")).run()
    assert open_sweep(path)["stroke"].dims == ("run",)
    table = read_sweep(path)
    assert (table.design, table.shape) == ("sobol", None)
    assert [one.is_logarithmic for one in table.varied.values()] == [True, False]
    assert list(table.varied) == [DIAMETER, "element.length"]


def test_the_table_is_the_dataset(store: Path) -> None:
    table, found = read_sweep(store), open_sweep(store, grid=False)
    assert table.shape == (3, 4)
    for column in (*table.varied.values(), *table.measures.values()):
        assert np.array_equal(column.values, found[column.name].values)
        assert column.unit == found[column.name].attrs["units"]


def test_the_heat_of_a_resistor_depends_on_what_it_must(store: Path) -> None:
    """Constant resistivity: energy goes with the square of diameter and of voltage."""
    table = read_sweep(store)
    (found,) = compute_sensitivity(table, ["energy"])
    a, b = (np.square(levels) for levels in table.levels or ())
    means, squares = (a.mean(), b.mean()), (np.mean(a**2), np.mean(b**2))
    variance = squares[0] * squares[1] - (means[0] * means[1]) ** 2
    first = [a.var() * means[1] ** 2 / variance, b.var() * means[0] ** 2 / variance]
    assert found.indices["first"].values == pytest.approx(first, rel=1e-6)
    both = a.var() * b.var() / variance
    assert found.indices["total"].values == pytest.approx([f + both for f in first], rel=1e-6)


def test_what_is_no_sweep_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="holds no sweep"):
        open_sweep(tmp_path / "none.zarr")
    with pytest.raises(DataError, match="holds no sweep"):
        read_sweep(tmp_path)
