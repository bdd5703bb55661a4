"""Searches keep the order that a law declares, and leave starts at which nothing transforms.

Sources of truth: the declared orders themselves; differences of the transform; numbers that were put in.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from condition_cases import make_coil
from hypothesis import given, settings
from hypothesis import strategies as st

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.fit.fit_verdicts import list_fit_warnings
from martensite.fit.ordered_numbers import NumberOrder, OrderedNumbers, list_orders
from martensite.fit.problem import Problem, build_problem
from martensite.fit.solve import solve_problem
from martensite.fit.start_checks import check_start
from martensite.search.free_numbers import FreeNumber, SearchRange
from martensite.signals.records import Record

FREE = [
    FreeNumber(name, name, "K", 350.0, low, low + 100.0) for name, low in zip("abcd", (300, 310, 320, 290), strict=True)
]
LATTICE = [NumberOrder(0, 1), NumberOrder(0, 2), NumberOrder(1, 3), NumberOrder(2, 3), NumberOrder(305.0, 2)]
"""M_f below M_s and A_s, both below A_f, as of a law of surfaces; and something that is not free."""
PLACES = st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4)


def values(shares: Any) -> list[float]:
    return [free.value(float(u)) for free, u in zip(FREE, shares, strict=True)]


@settings(max_examples=60, deadline=None)
@given(PLACES)
def test_every_place_is_in_order(places: list[float]):
    order = OrderedNumbers(FREE, LATTICE)
    shares = order.find_shares(places)
    a, b, c, d = values(shares)
    assert a < b < d
    assert max(a, 305.0) < c < d
    assert ((shares >= 0.0) & (shares <= 1.0)).all()
    again = order.find_shares(order.find_places(shares))
    assert again == pytest.approx(shares, abs=1e-9)


def test_slopes_are_those_of_the_transform():
    order, rng = OrderedNumbers(FREE, LATTICE), np.random.default_rng(1)
    for _ in range(20):
        at = rng.uniform(0.05, 0.95, 4)
        steps = 1e-7 * np.eye(4)
        meant = np.stack([(order.find_shares(at + s) - order.find_shares(at - s)) / 2e-7 for s in steps], axis=1)
        assert order.find_slopes(at) == pytest.approx(meant, abs=1e-6)


def test_bounds_without_room_are_refused():
    low = [replace(FREE[0], low=400.0, high=450.0), replace(FREE[1], low=300.0, high=390.0)]
    with pytest.raises(ParameterError, match="leave no room for `a`: it must be below"):
        OrderedNumbers(low, [NumberOrder(0, 1)])


def make_problem(*ranges: SearchRange) -> Problem:
    """The coil under its pulse, as its own runs say, with A_s of 62 and A_f of 74 °C."""
    scenario = make_coil(drive__waveform__high="3 A")
    system = scenario.system.with_values({"element.law.A_s": 335.15, "element.law.A_f": 347.15})
    times = np.linspace(0.0, 6.0, 61).tolist()
    blank = {"time": times, "position": [0.0, *[1.0] * 60]}
    units = {"time": "s", "position": "m"}
    one = Experiment("run", system, scenario.waveform, Record("run", blank, units), {"position": "position"}, step=0.05)
    runner = one.runner()
    found = runner.run_one(runner.base)
    assert found is not None
    made = replace(one, record=Record("run", {"time": times, "position": found[:, 0].tolist()}, units))
    return build_problem([made], ranges)


def test_orders_are_those_of_the_law():
    problem = make_problem(SearchRange("A_s", 300.0, 400.0), SearchRange("A_f", 310.0, 410.0))
    assert set(list_orders(problem.free, problem.experiments)) == {NumberOrder(0, 1)}
    alone = make_problem(SearchRange("A_f", 310.0, 410.0))
    assert list_orders(alone.free, alone.experiments) == [NumberOrder(pytest.approx(335.15), 0)]  # type: ignore[arg-type]
    assert alone.free[0].value(float(alone.order.find_shares([0.0])[0])) > 335.15


def test_a_start_out_of_order_is_moved_and_the_truth_found():
    problem = make_problem(SearchRange("A_s", 300.0, 400.0, 380.0), SearchRange("A_f", 310.0, 410.0, 330.0))
    assert any("`A_f` starts at 109.9" in one and "does not allow" in one for one in check_start(problem))
    fit = solve_problem(problem)
    assert fit.reason == "converged"
    assert [fit["A_s"], fit["A_f"]] == pytest.approx([335.15, 347.15], abs=0.01)


def test_a_start_at_which_nothing_transforms_is_left():
    problem = make_problem(SearchRange("A_s", 300.0, 600.0, 590.0), SearchRange("A_f", 310.0, 610.0, 600.0))
    fit = solve_problem(problem)
    assert fit.reason == "converged"
    assert [fit["A_s"], fit["A_f"]] == pytest.approx([335.15, 347.15], abs=0.05)


def test_where_nothing_transforms_at_all_the_fit_says_so():
    problem = make_problem(SearchRange("A_s", 560.0, 600.0, 590.0), SearchRange("A_f", 570.0, 610.0, 600.0))
    fit = solve_problem(problem)
    assert fit.reason == "nothing transforms at A_s = 316.9 degC and A_f = 326.9 degC; the fit did not move"
    assert "did not converge: nothing transforms" in list_fit_warnings(fit)[0]
