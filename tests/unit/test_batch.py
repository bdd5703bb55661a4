"""Batches: variants equal single runs, whatever varies; bad arguments are one sentence."""

from __future__ import annotations

from importlib import import_module

import pytest
from builders import problem_a

import martensite as ms
from martensite.errors import InputError, ParameterError, UnknownNameError
from martensite.status import Status

LEVELS = ms.Triangle(high=2.5, frequency=0.1)
PULSE = ms.Step(high=2.5, at=1.0, until=8.0)


@pytest.mark.parametrize(
    "system", [problem_a(), problem_a(mechanism=ms.DeadWeight(mass=0.6))], ids=["spring", "weight"]
)
def test_variants_equal_single_runs(system: ms.System) -> None:
    values = [80.0, 100.0, 120.0]
    batch = ms.simulate_batch(system, LEVELS, 20.0, {"h0": values}, step=0.02, samples=101)
    for row, h0 in zip(batch.columns["position"], values, strict=True):
        single = ms.simulate(system.with_values({"h0": h0}), LEVELS, 20.0, step=0.02, samples=101)
        assert row.tolist() == pytest.approx(single["position"], abs=1e-12)
    assert batch.status == [Status.OK] * 3


def test_chunks_do_not_change_variants() -> None:
    over = {"A_f": [350.0, 351.0, 352.0, 353.0, 354.0]}
    whole, cut = (
        ms.simulate_batch(problem_a(), LEVELS, 10.0, over, step=0.02, samples=51, chunk=chunk)
        for chunk in (5, 2)
    )
    assert whole.columns["position"] == pytest.approx(cut.columns["position"], abs=1e-14)


def test_bad_arguments_are_refused() -> None:
    def run(**changed: object) -> object:
        usual = {"over": {"h0": [90.0]}, "step": 0.02, "samples": 11}
        return ms.simulate_batch(problem_a(), LEVELS, 1.0, **{**usual, **changed})  # type: ignore[arg-type]

    with pytest.raises(UnknownNameError, match="Did you mean `position`"):
        run(outputs=["positon"])
    with pytest.raises(ParameterError, match="no parameter `hh`"):
        run(over={"hh": [1.0]})
    with pytest.raises(ParameterError, match="must be"):
        run(over={"diameter": [-1.0]})
    with pytest.raises(InputError, match="equally many values"):
        run(over={"h0": [90.0], "A_f": [350.0, 351.0]})
    with pytest.raises(ParameterError, match="`step` must be above 0"):
        run(step=0.0)
    with pytest.raises(InputError, match="float64 or float32"):
        run(precision="float16")


def test_a_stiff_spring_costs_no_million_steps() -> None:
    """The kink where the spring goes slack needs more iterations than are usual."""
    stiff = problem_a().with_values({"stiffness": "20 N/mm", "preload": "4 N"})
    result = ms.simulate(stiff, PULSE, 12.0, samples=121)
    assert result.steps < 20_000
    assert result.accuracy is not None
    assert result.accuracy <= 1e-4


def test_a_tolerance_out_of_reach_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_module("martensite.simulate.accuracy"), "LOCAL", {2: 100.0})
    monkeypatch.setattr(import_module("martensite.simulate.accuracy"), "MOST", 1)
    result = ms.simulate(problem_a(), LEVELS, 20.0, tolerance=1e-6, samples=101)
    assert any("tolerance of 1.0e-06 was not reached" in text for text in result.warnings)
    assert result.accuracy is not None
    assert 1e-6 < result.accuracy < 1e-3
