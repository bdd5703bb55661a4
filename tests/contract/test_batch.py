"""Batches: variants equal single runs, whatever varies; bad arguments are one sentence."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from builders import problem_a

import martensite as ms
from martensite.base.errors import InputError, ParameterError, UnknownNameError
from martensite.base.status import Status
from martensite.simulate.batch import simulate_batch

LEVELS = ms.signals.Triangle(high=2.5, frequency=0.1)
PULSE = ms.Step(high=2.5, at=1.0, until=8.0)


def endings(batch: ms.Result) -> Any:
    """How the runs of a batch ended."""
    assert batch.variants is not None
    return batch.variants


@pytest.mark.parametrize(
    "system", [problem_a(), problem_a(mechanism=ms.DeadWeight(mass=0.6))], ids=["spring", "weight"]
)
def test_variants_equal_single_runs(system: ms.System) -> None:
    values = [80.0, 100.0, 120.0]
    batch = simulate_batch(system, LEVELS, 20.0, {"h0": values}, step=0.02, samples=101)
    for row, h0 in zip(batch["position"], values, strict=True):
        single = ms.run(system.with_values({"h0": h0}), LEVELS, 20.0, step=0.02, samples=101)
        assert row.tolist() == pytest.approx(single["position"], abs=1e-12)
    assert endings(batch).status == [Status.OK] * 3


H0 = [60.0, 100.0, 140.0]
JUDGED = ("temperature", "martensite_fraction", "stress", "position")


@pytest.mark.parametrize("runtime", ["c", "floats"])
@pytest.mark.parametrize("wave", [LEVELS, PULSE], ids=["triangle", "pulse"])
def test_rows_are_as_accurate_as_they_say(wave: Any, runtime: str, c_compiler: str) -> None:
    batch = simulate_batch(problem_a(), wave, 20.0, {"h0": H0}, samples=101, outputs=JUDGED, runtime=runtime)
    assert endings(batch).status == [Status.OK] * 3
    assert endings(batch).ended.tolist() == [20.0] * 3
    for run, h0 in enumerate(H0):
        exact = ms.run(problem_a().with_values({"h0": h0}), wave, 20.0, tolerance=2e-7, samples=101)
        assert 0.0 < endings(batch).accuracy[run] <= 1e-4
        for name in JUDGED:
            off = np.abs(batch[name][run] - exact[name]).max()
            assert off <= (endings(batch).accuracy[run] + 2e-7) * exact.range(name)


@pytest.mark.parametrize("more", [{}, {"step": 0.02}, {"step": 0.02, "runtime": "c"}])
def test_a_run_that_leaves_the_envelope_changes_no_other(more: Any, c_compiler: str) -> None:
    """The second has hardly a surface to lose its heat by, and melts."""
    wave, wanted = ms.Step(high=30.0, at=1.0, until=8.0), {"samples": 101, "outputs": JUDGED}
    mixed = simulate_batch(problem_a(), wave, 12.0, {"h0": [6e4, 100.0, 8e4]}, **wanted, **more)
    calm = simulate_batch(problem_a(), wave, 12.0, {"h0": [6e4, 8e4]}, **wanted, **more)
    assert endings(mixed).status[1] is Status.OUT_OF_ENVELOPE
    assert [endings(mixed).status[k] for k in (0, 2)] == endings(calm).status
    assert not any(status.failed for status in endings(calm).status)
    for name in JUDGED:
        assert np.array_equal(mixed[name][[0, 2]], calm[name])
        kept = np.isfinite(mixed[name][1])
        assert kept.tolist() == [time < endings(mixed).ended[1] for time in mixed.times]
    assert 1.2 < endings(mixed).ended[1] < 8.0
    assert np.nanmax(mixed["temperature"][1]) < 1583.15
    if not more:
        assert endings(mixed).accuracy[[0, 2]].tolist() == endings(calm).accuracy.tolist()
        alone = ms.run(problem_a().with_values({"h0": 100.0}), wave, 12.0, samples=101)
        assert alone.status is Status.OUT_OF_ENVELOPE
        assert alone.status_time == pytest.approx(endings(mixed).ended[1], rel=0.1)


def test_tighter_bounds_may_vary(c_compiler: str) -> None:
    stops = [320.0, 335.0, 1500.0]
    over = {"temperature_stop": stops}
    ways: list[dict[str, Any]] = [{}, {"runtime": "floats"}, {"step": 0.02, "runtime": "c"}]
    for more in ways:
        batch = simulate_batch(problem_a(), LEVELS, 20.0, over, samples=101, outputs=("temperature",), **more)
        assert [status.failed for status in endings(batch).status] == [True, True, False]
        highest = np.nanmax(batch["temperature"], axis=1)
        assert (highest < stops).all()
        assert highest[0] < highest[1] < highest[2]


PWM = ms.signals.PulseWidthModulation(high=5.0, frequency=20.0, duty=0.2)


def test_runs_whose_drives_are_too_long_go_one_by_one(monkeypatch: pytest.MonkeyPatch, c_compiler: str) -> None:
    def run() -> ms.Result:
        return simulate_batch(problem_a(), PWM, 10.0, {"h0": H0}, samples=51, outputs=JUDGED)

    together = run()
    native = import_module("martensite.simulate.marching_native")
    monkeypatch.setattr(native, "MOST_SEGMENTS", 100)
    alone = run()
    assert endings(alone).status == endings(together).status == [Status.OK] * 3
    for name in JUDGED:
        off = np.abs(alone[name] - together[name]).max(axis=1)
        assert (off <= 2e-4 * np.ptp(together[name], axis=1)).all()


def test_samples_on_edges_are_behind_them(c_compiler: str) -> None:
    batch = simulate_batch(problem_a(), PWM, 10.0, {"h0": H0}, samples=201, outputs=("drive", "current"))
    single = ms.run(problem_a(), PWM, 10.0, samples=201)
    for row in batch["drive"]:
        assert np.array_equal(row, single["drive"])


@pytest.mark.parametrize("count", [1, 15, 16, 17, 50])
def test_any_number_of_runs_is_made(count: int, c_compiler: str) -> None:
    h0 = np.linspace(60.0, 140.0, 50).tolist()
    whole = simulate_batch(problem_a(), PULSE, 12.0, {"h0": h0}, samples=51)
    some = simulate_batch(problem_a(), PULSE, 12.0, {"h0": h0[-count:]}, samples=51)
    assert np.array_equal(some["position"], whole["position"][-count:])
    assert np.array_equal(endings(some).accuracy, endings(whole).accuracy[-count:])


def test_threads_change_nothing(c_compiler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_module("martensite.simulate.variants"), "TOGETHER", 8)
    h0 = np.linspace(60.0, 140.0, 30).tolist()
    one, two = (simulate_batch(problem_a(), PULSE, 12.0, {"h0": h0}, samples=51, devices=n) for n in (1, 2))
    assert np.array_equal(one["position"], two["position"])


def test_a_hard_run_is_made_again_and_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the first two runs differ too much, a third one follows, for those alone."""
    monkeypatch.setattr(import_module("martensite.simulate.ensembles"), "LOCAL", {5: 30.0})
    batch = simulate_batch(problem_a(), LEVELS, 20.0, {"h0": H0}, tolerance=1e-5, samples=101)
    assert endings(batch).status == [Status.OK] * 3
    assert (endings(batch).accuracy <= 1e-5).all()


def test_bad_arguments_are_refused() -> None:
    def run(**changed: object) -> object:
        usual = {"over": {"h0": [90.0]}, "step": 0.02, "samples": 11}
        return simulate_batch(problem_a(), LEVELS, 1.0, **{**usual, **changed})  # type: ignore[arg-type]

    with pytest.raises(UnknownNameError, match="Did you mean `position`"):
        run(outputs=["positon"])
    with pytest.raises(ParameterError, match="no parameter `hh`"):
        run(over={"hh": [1.0]})
    with pytest.raises(ParameterError, match="must be"):
        run(over={"diameter": [-1.0]})
    with pytest.raises(InputError, match="equal numbers of values"):
        run(over={"h0": [90.0], "A_f": [350.0, 351.0]})
    with pytest.raises(ParameterError, match="`step` must be above 0"):
        run(step=0.0)
    with pytest.raises(InputError, match="float64 or float32"):
        run(precision="float16")
    with pytest.raises(InputError, match="float32 on CUDA only"):
        run(precision="float32", step=None)
    with pytest.raises(InputError, match="give the longest one as `step`"):
        run(runtime="cuda", precision="float32", step=None)
    with pytest.raises(InputError, match="Did you mean `floats`"):
        run(runtime="floats2")
    with pytest.raises(ParameterError, match="`devices` must be at least 1"):
        run(devices=0)
    with pytest.raises(ParameterError, match="`tolerance` must be above 0"):
        run(tolerance=0.0, step=None)


def test_a_stiff_spring_costs_no_million_steps() -> None:
    """The kink where the spring goes slack needs more iterations than are usual."""
    stiff = problem_a().with_values({"stiffness": "20 N/mm", "preload": "4 N"})
    result = ms.run(stiff, PULSE, 12.0, samples=121)
    assert result.steps < 20_000
    assert result.accuracy is not None
    assert result.accuracy <= 1e-4


def test_a_tolerance_out_of_reach_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_module("martensite.simulate.accuracy"), "LOCAL", {5: 100.0})
    monkeypatch.setattr(import_module("martensite.simulate.accuracy"), "MOST_PASSES", 1)
    result = ms.run(problem_a(), LEVELS, 20.0, tolerance=1e-6, samples=101)
    assert any("tolerance of 1.0e-06 was not reached" in text for text in result.warnings)
    assert result.accuracy is not None
    assert 1e-6 < result.accuracy < 1e-3
