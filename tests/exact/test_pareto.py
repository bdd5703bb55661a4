"""Pareto fronts: which runs no other beats.

Source of truth: the definition, by comparing every run with every other.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sweep_tables import table, with_status, with_value

from martensite.base.errors import DataError, ParameterError, UnknownNameError
from martensite.design.sweep.pareto import BLOCK, find_pareto_front, find_unbeaten
from martensite.design.sweep.table import SweepTable


def by_definition(values: np.ndarray) -> list[int]:
    """Rows for which no other is as good in all and better in one."""
    as_good = (values[None] <= values[:, None]).all(axis=2)
    better = (values[None] < values[:, None]).any(axis=2)
    beaten = np.any(np.logical_and(as_good, better), axis=1)
    return np.flatnonzero(~beaten).tolist()


@st.composite
def rows(draw: st.DrawFn) -> np.ndarray:
    """Rows of 1 to 4 goals, often equal ones."""
    width = draw(st.integers(1, 4))
    number = st.one_of(st.integers(-3, 3).map(float), st.floats(-1e300, 1e300))
    return np.array(draw(st.lists(st.tuples(*[number] * width), min_size=1, max_size=40)))


@given(rows())
def test_it_is_what_the_definition_says(values: np.ndarray) -> None:
    assert find_unbeaten(values).tolist() == by_definition(values)


@pytest.mark.parametrize("width", [2, 3, 5])
def test_it_is_so_over_many_blocks(width: int) -> None:
    rng = np.random.default_rng(width)
    even = rng.random((3 * BLOCK, width))
    sphere = rng.normal(size=(2 * BLOCK, width))
    sphere = -np.abs(sphere / np.linalg.norm(sphere, axis=1, keepdims=True))
    for values in (even, sphere, np.round(5.0 * even)):
        assert find_unbeaten(values).tolist() == by_definition(values)
    assert len(find_unbeaten(sphere)) == len(sphere)


@pytest.fixture(scope="module")
def found() -> SweepTable:
    return table("sobol:128", low=lambda x: x[:, 0] ** 2, high=lambda x: x[:, 0] + 0.1 * x[:, 1])


def test_small_and_large_are_sought(found: SweepTable) -> None:
    front = find_pareto_front(found, minimise=["low"], maximise=["high"])
    values = np.stack([found.measures["low"].values, -found.measures["high"].values], axis=1)
    assert sorted(front.runs.tolist()) == by_definition(values)
    assert (np.diff(values[front.runs, 0]) > 0.0).all()
    assert (front.most, front.compared) == ((False, True), 128)


def test_a_varied_number_is_a_goal_too(found: SweepTable) -> None:
    front = find_pareto_front(found, minimise=["x1"])
    assert front.runs.tolist() == [int(np.argmin(found.varied["part.x1"].values))]
    assert list(front.columns(found)) == list(found.varied)


def test_runs_without_a_number_do_not_count(found: SweepTable) -> None:
    best = int(find_pareto_front(found, maximise=["high"]).runs[0])
    for changed in (
        with_status(found, s2=[best]),
        with_status(found, missing=[best]),
        with_value(found, "high", best, np.inf),
    ):
        front = find_pareto_front(changed, maximise=["high"])
        assert front.compared == 127
        assert best not in front.runs
    with pytest.raises(DataError, match="no run"):
        find_pareto_front(with_status(found, s3=range(128)), maximise=["high"])


def test_it_refuses(found: SweepTable) -> None:
    with pytest.raises(ParameterError, match="--minimise"):
        find_pareto_front(found)
    with pytest.raises(ParameterError, match="twice"):
        find_pareto_front(found, ["low"], ["low"])
    with pytest.raises(UnknownNameError, match="Did you mean `high`"):
        find_pareto_front(found, ["hihg"])
