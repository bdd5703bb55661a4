"""Sensitivity of sweeps.

Sources of truth: the closed forms of the function of Ishigami and Homma (1990) and of a sum; what
SALib computes from the same numbers; and the heat of a resistor.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sweep_tables import ANGLES, ishigami, ishigami_indices, table, with_status, with_value

from martensite.base.errors import DataError, InputError, UnknownNameError
from martensite.design.sweep.given_data_indices import (
    estimate_delta,
    estimate_first_order,
    estimate_indices,
    fit_slopes,
    rank_columns,
)
from martensite.design.sweep.indices import SensitivityIndices, compute_sensitivity, estimate_block_indices
from martensite.design.sweep.sampling.samples import parse_sampling
from martensite.design.sweep.table import SweepTable

BASE = 2048


@pytest.fixture(scope="module")
def found() -> SweepTable:
    """The function, one that is always the same, and blocks of five runs."""
    return table(f"saltelli:{BASE}", y=ishigami, same=lambda x: 0.1 + 1e-17 * x[:, 0])


def only(found: SweepTable, name: str = "y") -> SensitivityIndices:
    (one,) = compute_sensitivity(found, [name])
    return one


# ---------------------------------------------------------------- design


def test_blocks_are_those_that_salib_expects() -> None:
    made = parse_sampling("saltelli:6", 4)
    x = made.values(ANGLES, 0, made.size(ANGLES)).reshape(6, 5, 3)
    a, b = x[:, 0], x[:, 4]
    for k in range(3):
        assert (x[:, k + 1, k] == b[:, k]).all()
        others = [j for j in range(3) if j != k]
        assert (x[:, k + 1, others] == a[:, others]).all()
    assert (a != b).all()


def test_too_many_runs_are_refused() -> None:
    with pytest.raises(InputError, match="at most"):
        parse_sampling("saltelli:500000000").size(ANGLES)


# ---------------------------------------------------------------- blocks


def test_indices_are_those_of_the_closed_form(found: SweepTable) -> None:
    one, (first, total) = only(found), ishigami_indices()
    assert one.method == "saltelli"
    assert one.indices["first"].values == pytest.approx(first, abs=0.03)
    assert one.indices["total"].values == pytest.approx(total, abs=0.03)
    for index, truth in zip(one.indices.values(), (first, total), strict=True):
        assert (np.abs(index.values - truth) <= 1.5 * index.wide).all()
        assert (index.wide < 0.15).all()
    assert [one.names[k] for k in one.order] == ["part.x1", "part.x2", "part.x3"]


def test_the_same_numbers_give_the_same_intervals(found: SweepTable) -> None:
    once, again = (only(found).indices["total"].wide for _ in range(2))
    assert np.array_equal(once, again)


def test_blocks_with_a_gap_are_left_out_and_counted(found: SweepTable) -> None:
    gaps = with_value(with_status(found, s2=[1, 3], s5=[27], missing=[50]), "y", 60, np.inf)
    one = only(gaps)
    kept = found.measures["y"].values.reshape(-1, 5)
    kept = np.delete(kept, [0, 5, 10, 12], axis=0)
    truth = estimate_block_indices(kept.ravel(), 3)
    assert one.used == kept.size
    assert np.array_equal(one.indices["total"].values, truth["total"].values)
    said = " ".join(one.remarks)
    assert f"4 of {BASE:,} blocks" in said
    assert "3 runs are left out: failed" in said
    assert "1 runs are left out: not made yet" in said
    assert "never happened" in said


def test_too_few_blocks_are_refused(found: SweepTable) -> None:
    with pytest.raises(DataError, match="whole blocks"):
        only(with_status(found, s2=range(0, 5 * BASE, 5)))


def test_what_is_always_the_same_depends_on_nothing(found: SweepTable) -> None:
    one = only(found, "same")
    assert one.deviation == 0.0
    assert np.isnan(one.indices["total"].values).all()
    assert "the same in all runs" in one.remarks[0]


def test_an_unknown_measure_is_refused(found: SweepTable) -> None:
    with pytest.raises(UnknownNameError, match="Did you mean `same`"):
        compute_sensitivity(found, ["sane"])
    with pytest.raises(DataError, match="traces only"):
        compute_sensitivity(replace(found, measures={}))


def test_orders_and_intervals_are_those_of_salib(found: SweepTable) -> None:
    """Intervals come by chance: those of another bootstrap, within what 200 draws tell."""
    from SALib.analyze import sobol

    y = found.measures["y"].values
    problem = {"num_vars": 3, "names": ["x1", "x2", "x3"]}
    known = sobol.analyze(problem, y, calc_second_order=False, num_resamples=200, seed=1)
    made = estimate_block_indices(y, 3)
    for name, key in (("first", "S1"), ("total", "ST")):
        assert made[name].values == pytest.approx(known[key], abs=1e-12)
        assert made[name].wide == pytest.approx(known[f"{key}_conf"], rel=0.35)


# ---------------------------------------------------------------- grid


def grid(count: int) -> SweepTable:
    return table("grid", [replace(one, count=count) for one in ANGLES], y=ishigami)


def test_a_fine_grid_approaches_the_closed_form() -> None:
    one, (first, total) = only(grid(81)), ishigami_indices()
    assert one.method == "grid"
    assert one.indices["first"].values == pytest.approx(first, abs=0.02)
    assert one.indices["total"].values == pytest.approx(total, abs=0.02)


def test_a_grid_with_a_gap_is_a_sample() -> None:
    one = only(with_status(grid(8), s4=[17]))
    assert (one.method, one.used) == ("given data", 511)
    assert "The grid is not whole" in " ".join(one.remarks)


# ---------------------------------------------------------------- samples


def test_slopes_of_a_sum_are_those_of_its_terms() -> None:
    found = table("monte-carlo:400", y=lambda x: 3.0 * x[:, 0] - x[:, 1])
    one = only(found)
    deviations = found.inputs.std(axis=0)
    truth = np.array([3.0, -1.0, 0.0]) * deviations / found.measures["y"].values.std()
    assert one.indices["slope"].values == pytest.approx(truth, abs=1e-12)
    assert one.indices["slope"].wide == pytest.approx(0.0, abs=1e-12)
    assert not one.remarks
    assert one.order[:2] == [0, 1]


def test_ranks_see_what_only_rises() -> None:
    found = table("sobol:256", y=lambda x: np.exp(6.0 * x[:, 0]))
    one = only(found)
    assert one.indices["rank slope"].values == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert one.indices["slope"].values[0] < 0.7
    assert np.array_equal(rank_columns(np.array([5.0, 1.0, 5.0, 2.0])), [3.5, 1.0, 3.5, 2.0])


def test_what_turns_back_is_seen_by_delta_and_first_order_alone() -> None:
    one = only(table("sobol:1024", y=lambda x: x[:, 1] ** 2))
    assert one.indices["first"].values[1] > 0.8
    assert one.indices["delta"].values[1] > 0.5
    assert abs(one.indices["rank slope"].values[1]) < 0.1
    assert np.abs(one.indices["first"].values[[0, 2]]).max() < 0.05
    assert "Slopes explain" in one.remarks[0]


def test_slopes_of_numbers_that_vary_together_have_wide_intervals() -> None:
    rng = np.random.default_rng(0)
    x = rng.random((200, 1)) + np.array([[0.0, 0.0]])
    x[:, 1] += 1e-3 * rng.random(200)
    y = x[:, 0] + rng.normal(size=200)
    assert fit_slopes(x, y)[0].wide.min() > 10.0 * fit_slopes(x[:, :1], y)[0].wide[0]


@pytest.mark.parametrize("count", [50, 333, 2500])
def test_estimates_are_those_of_salib(count: int) -> None:
    from SALib.analyze import delta

    rng = np.random.default_rng(count)
    x = rng.random(count)
    y = x**2 + rng.random(count)
    power = 2.0 / (7.0 + np.tanh((1500.0 - count) / 500.0))
    ends = np.linspace(0, count, round(min(np.ceil(count**power), 48)) + 1)
    known = delta.calc_delta(y, np.linspace(y.min(), y.max(), 100), x, ends)
    assert estimate_delta(x, y) == pytest.approx(known, rel=1e-9)
    assert estimate_first_order(x, y) == pytest.approx(delta.sobol_first(y, x, ends), rel=1e-9)


def test_a_measure_of_two_values_is_moved_by_what_decides_them() -> None:
    x = np.linspace(0.0, 1.0, 401)
    assert estimate_delta(x, np.where(x < 0.5, 0.0, 1.0)) == pytest.approx(0.5, abs=0.1)
    assert estimate_delta(np.random.default_rng(0).permutation(x), np.where(x < 0.5, 0.0, 1.0)) < 0.15


def test_a_number_that_does_not_vary_explains_nothing() -> None:
    x = np.random.default_rng(0).random((100, 2))
    x[:, 1] = 3.0
    found, _ = estimate_indices(x, x[:, 0])
    assert np.isnan(found["delta"].values[1])
    assert found["slope"].values == pytest.approx([1.0, 0.0], abs=1e-12)


def test_too_few_runs_are_refused() -> None:
    with pytest.raises(DataError, match="at least 32"):
        only(table("sobol:16", y=ishigami))
