"""What a result gives: a table, a data set, a figure, and itself in a few lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from builders import SINE_A, problem_a

from martensite.base.errors import UnknownNameError
from martensite.physics.materials.base import load_material, material_names
from martensite.simulate.api import simulate
from martensite.simulate.result import LINES, Result


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate(problem_a(), SINE_A, 5.0, samples=21)


def test_a_column_that_is_not_there_is_named_with_the_nearest(result: Result) -> None:
    assert len(result["temperature"]) == len(result["time"]) == 21
    with pytest.raises(UnknownNameError, match="Did you mean `temperature`"):
        result["temperatur"]


def test_it_goes_to_pandas_and_xarray(result: Result, tmp_path: Path) -> None:
    table = result.to_pandas()
    assert table.index.name == "time"
    assert table["stress"].to_numpy() == pytest.approx(result["stress"], rel=0, abs=0)
    assert table.attrs["units"]["stress"] == "Pa"
    dataset = result.to_xarray()
    assert np.array_equal(dataset["time"], result["time"])
    result.save(tmp_path / "run.nc")
    assert (tmp_path / "run.nc").stat().st_size > 0


def test_it_is_drawn_and_written(result: Result, tmp_path: Path) -> None:
    figure = result.plot(tmp_path / "run.png", title="a wire")
    assert (tmp_path / "run.png").stat().st_size > 0
    assert figure.axes


def test_a_console_has_a_few_lines_and_a_notebook_a_table(result: Result) -> None:
    assert len(repr(result).splitlines()) <= LINES + 2 < 10
    assert repr(result).startswith("Run: 5 s in ")
    assert str(result.summary()).startswith(str(result).splitlines()[0])
    assert all(len(line) <= 80 for line in str(result.summary()).splitlines()[1:4])
    page = result._repr_html_()
    assert page.count("<tr>") == len(result.outputs)  # the hottest place of a wire that is equally hot is not listed
    assert "wire temperature" in page
    assert "°C" in page


def test_a_material_prints_as_one_short_line() -> None:
    """Name, law and number of parameters of the file."""
    for name in material_names():
        found = load_material(name)
        assert len(repr(found)) < 80 and f"{len(found.values)} parameters" in repr(found)
    assert repr(load_material("nitihf-bigelow2022")) == "Material('nitihf-bigelow2022', law lagoudas, 34 parameters)"


def test_balances_by_name(result: Result) -> None:
    assert result.energy == {"heat": result.heat, "work": result.work}
