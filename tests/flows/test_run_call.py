"""`run`: one call for files, scenarios, systems and batches; arguments are converted or refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from builders import problem_a

import martensite as ms
from martensite.scenario.netcdf import read_labelled

EXAMPLE = Path(__file__).parents[2] / "examples" / "pwm_bias_spring.toml"
PULSE = ms.Step(high=2.5, at=1.0, until=8.0)


def test_a_file_a_scenario_and_its_system_give_the_same(c_compiler: str) -> None:
    scenario = ms.load(EXAMPLE)
    by_file, by_scenario = ms.run(EXAMPLE, runtime="c"), ms.run(scenario, runtime="c")
    for one in (by_scenario, scenario.run(runtime="c")):
        np.testing.assert_equal(one.columns, by_file.columns)
    again = ms.run(
        scenario.system, scenario.waveform, scenario.duration, samples=scenario.samples, tolerance=scenario.tolerance
    )
    assert again["position"] == pytest.approx(by_file["position"], abs=1e-12)


def test_columns_are_arrays_with_units() -> None:
    result = ms.run(problem_a(), PULSE, "12 s", samples=51)
    celsius = result["temperature"] - 273.15
    assert isinstance(celsius, np.ndarray) and celsius.shape == result["time"].shape == (51,)
    assert result.unit("temperature") == "K"


def test_a_bench_runs_and_has_no_batches() -> None:
    loop = ms.load(EXAMPLE.with_name("closed_loop.toml"))
    assert loop.bench is not None
    assert ms.run(loop.bench, duration=0.2).columns.keys() == ms.run(loop, duration=0.2).columns.keys()
    with pytest.raises(ms.InputError, match="A bench has no batches"):
        ms.run(loop, over={"mass": [0.1]})


def test_a_batch_is_a_result_with_one_more_dimension(tmp_path: Path) -> None:
    batch = ms.run(problem_a(), PULSE, 12.0, over={"h0": ["60 W/m^2/K", 100.0]}, samples=51)
    assert batch["position"].shape == (2, 51)
    assert batch.variants is not None and batch.variants.accuracy is not None
    assert {name: list(values) for name, values in batch.variants.over.items()} == {
        "environment.cooling.h0": [60.0, 100.0]
    }
    for row, h0 in zip(batch["temperature"], (60.0, 100.0), strict=True):
        single = ms.run(problem_a().with_values({"h0": h0}), PULSE, 12.0, samples=51)
        assert np.abs(row - single["temperature"]).max() <= 2e-4 * single.range("temperature")
    assert batch.stroke == pytest.approx([np.ptp(row) for row in batch["position"]], rel=1e-3)
    numbers = batch.summary().data
    assert numbers["stroke"] == batch.stroke.tolist() and numbers["accuracy"] == batch.variants.accuracy.tolist()
    assert str(batch).startswith("2 variants of 12 s over environment.cooling.h0: 2 ok")
    assert len(batch._repr_html_()) > 100 and len(repr(batch).splitlines()) <= 9
    assert batch.to_pandas().shape == (102, len(batch.columns))
    batch.save(tmp_path / "batch.nc")
    found = read_labelled(tmp_path / "batch.nc")
    assert found.to_xarray().sizes == {"variant": 2, "time": 51}
    assert found["position"].values.tolist() == batch["position"].tolist()
    assert found["status"].values.tolist() == ["OK", "OK"]
    figure = batch.plot(tmp_path / "batch.svg")
    assert len(figure.axes) == len(batch.columns) and (tmp_path / "batch.svg").stat().st_size > 1000


def test_measures_of_a_batch_have_a_value_for_each_variant() -> None:
    """The source of truth is the same variant, run alone; a variant that is refused has no numbers."""
    batch = ms.run(problem_a(), PULSE, 12.0, over={"h0": [60.0, 100.0], "A_s": [330.0, 500.0]}, samples=51)
    alone = ms.run(problem_a().with_values({"h0": 60.0, "A_s": 330.0}), PULSE, 12.0, samples=51)
    for name in batch.columns:
        spans = batch.range(name)
        assert spans.shape == (2,) and np.isnan(spans[1])
        assert spans[0] == pytest.approx(alone.range(name), rel=1e-3, abs=1e-9)
    assert batch.stroke[0] == batch.range("position")[0] and batch.range("time").tolist() == [12.0, 12.0]
    part = ms.run(problem_a(), PULSE, 12.0, over={"h0": [60.0]}, outputs=["temperature"], samples=51)
    assert part.summary().data["stroke"] is None


def test_wrong_arguments_are_a_sentence() -> None:
    system = problem_a()
    for what, words in ((system.element, "but is `Wire`"), (3, "but is `int`")):
        with pytest.raises(ms.InputError, match=words):
            ms.run(what)  # type: ignore[arg-type]
    with pytest.raises(ms.InputError, match="under a `drive` for a `duration`"):
        ms.run(system)
    with pytest.raises(ms.InputError, match="no scenario file"):
        ms.run("nothing.toml")
    with pytest.raises(ms.InputError, match="no parameter `h9`"):
        ms.run(system, PULSE, 1.0, over={"h9": [1.0]})
    with pytest.raises(ms.InputError, match="for batches"):
        ms.run(system, PULSE, 1.0, outputs=["position"])
    with pytest.raises(ms.InputError, match="`chain` of `to_control` must be `Chain`, but is `Sc"):
        ms.export.to_control(ms.load(EXAMPLE))  # type: ignore[arg-type]
    with pytest.raises(ms.InputError, match="must be `System`, but is `Scenario`; give its"):
        ms.simulate.compute_sensitivity(ms.load(EXAMPLE), PULSE, 1.0, ["h0"], step=0.1)  # type: ignore[arg-type]
    with pytest.raises(ms.InputError, match="`load` cannot be called so"):
        ms.load()  # type: ignore[call-arg]


@pytest.mark.parametrize("rows", [255, 256])
def test_a_table_that_fills_the_window_of_c_ends(rows: int, c_compiler: str) -> None:
    """C knows 256 segments of a drive at first, and asks for more."""
    times = np.linspace(0.0, 8.0, rows)
    drive = ms.signals.Table(times=tuple(times), values=tuple(2.0 * (times % 1.0 < 0.4)))
    found, same = (ms.run(problem_a(), drive, 8.0, samples=9, runtime=one, budget=20.0) for one in ("c", "floats"))
    assert found["temperature"] == pytest.approx(same["temperature"], abs=0.05)
