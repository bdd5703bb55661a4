"""Cells in a row: the solution, and what each cell sees of the others.

Source of truth: `numpy.linalg.solve`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from martensite.actuators.elements.network import fold_others, solve_tridiagonal
from martensite.kernels import floats

POSITIVE = st.floats(1e-3, 1e3)
ANY = st.floats(-1e3, 1e3)


class Row(NamedTuple):
    diagonal: list[float]
    right: list[float]
    links: list[float]


@st.composite
def rows(draw: st.DrawFn) -> Row:
    """One to twelve cells; links may be cut."""
    count = draw(st.integers(1, 12))

    def column(numbers: st.SearchStrategy[float], size: int) -> list[float]:
        return draw(st.lists(numbers, min_size=size, max_size=size))

    links = column(POSITIVE | st.just(0.0), count - 1)
    return Row(column(POSITIVE, count), column(ANY, count), links)


def fold(row: Row) -> list[list[float]]:
    """Return what every cell sees of the others: b, then s."""
    return [list(column) for column in fold_others(floats, row.diagonal, row.links, row.right)]


def matrix(row: Row) -> np.ndarray:
    """The matrix of the linear system."""
    found = np.diag(row.diagonal)
    for i, g in enumerate(row.links):
        found[i : i + 2, i : i + 2] += g * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return found


def scale(row: Row) -> float:
    """Size of the solution."""
    return max(np.abs(np.linalg.solve(matrix(row), row.right)).max(), 1e-9)


@given(rows())
def test_the_solution_is_that_of_numpy(row: Row) -> None:
    expected = np.linalg.solve(matrix(row), row.right)
    assert solve_tridiagonal(floats, *row) == pytest.approx(expected, abs=1e-9 * scale(row))


@given(rows())
def test_every_cell_alone_gives_the_solution(row: Row) -> None:
    expected = np.linalg.solve(matrix(row), row.right)
    slope, source = fold(row)
    for i, temperature in enumerate(expected):
        alone = (row.right[i] + source[i]) / (row.diagonal[i] + slope[i])
        assert alone == pytest.approx(temperature, abs=1e-9 * scale(row))


@given(rows(), POSITIVE, ANY)
def test_what_a_cell_sees_does_not_depend_on_itself(row: Row, d: float, r: float) -> None:
    for i in range(len(row.diagonal)):
        diagonal, right = list(row.diagonal), list(row.right)
        diagonal[i], right[i] = d, r
        before, after = fold(row), fold(Row(diagonal, right, row.links))
        assert [column[i] for column in before] == [column[i] for column in after]


@given(rows())
def test_others_are_the_schur_complement(row: Row) -> None:
    """b_i = Σ g - row · (rest)⁻¹ · column, from the whole matrix."""
    whole, (slope, _) = matrix(row), fold(row)
    for i in range(len(row.diagonal)):
        rest = [j for j in range(len(row.diagonal)) if j != i]
        if not rest:
            continue
        inner, column = whole[np.ix_(rest, rest)], whole[rest, i]
        folded = whole[i, i] - column @ np.linalg.solve(inner, column)
        assert row.diagonal[i] + slope[i] == pytest.approx(folded, rel=1e-6)


def test_a_cell_without_neighbours_sees_nothing() -> None:
    assert fold(Row([2.0], [3.0], [])) == [[0.0], [0.0]]
    assert fold(Row([2.0, 5.0], [3.0, 1.0], [0.0])) == [[0.0, 0.0], [0.0, 0.0]]
