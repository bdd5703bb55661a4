"""Free numbers that are counted from others: `A_f-A_s` keeps an order, and its derivatives are those of both."""

from __future__ import annotations

import numpy as np
import pytest
from fit_cases import ISOBARIC, TRUE, isobaric

from martensite.base.errors import ParameterError
from martensite.fit.api import read_problem
from martensite.fit.problem import Problem
from martensite.fit.solve import solve_problem
from martensite.scenario.scenario import read_scenario

FREE = ["A_s", "A_f-A_s=2..60 K@20 K", "M_f-M_s=-60..-2 degC"]


def problem(free: list[str]) -> Problem:
    record = isobaric()
    return read_problem(read_scenario(ISOBARIC, log=record), [record], free, hold_out="none")


def test_difference_moves_with_its_base_and_finds_the_truth() -> None:
    fit = solve_problem(problem(FREE), inputs=False)
    assert fit["A_s"] == pytest.approx(TRUE["A_s"], abs=0.1)
    assert fit["A_s"] + fit["A_f-A_s"] == pytest.approx(TRUE["A_f"], abs=0.1)
    law = fit.system().value_of("element.law.A_f")
    assert law == pytest.approx(fit["A_s"] + fit["A_f-A_s"], abs=1e-9)


def test_derivatives_are_those_of_finite_differences() -> None:
    one = problem(FREE)
    u = np.array([0.55, 0.3, 0.6])
    found = one.evaluate(u.tolist(), slopes=True)
    assert found is not None
    for k in range(3):
        ends = [one.evaluate((u + h * np.eye(3)[k]).tolist()) for h in (1e-6, -1e-6)]
        assert ends[0] is not None and ends[1] is not None
        slope = (ends[0].residuals - ends[1].residuals) / 2e-6
        assert found.jacobian[:, k] == pytest.approx(slope, abs=2e-4 * np.abs(slope).max() + 1e-9)


def test_order_and_units_are_checked() -> None:
    with pytest.raises(ParameterError, match="must come before it"):
        problem(["A_f-A_s=2..60 K", "A_s"])
    with pytest.raises(ParameterError, match="no difference"):
        problem(["A_f-eps_L"])
