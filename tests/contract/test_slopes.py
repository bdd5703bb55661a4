"""Exact derivatives of whole runs in C, for every registered law, element, mechanism and drive.

Sources of truth: central differences of the same run in C without derivatives. All
parameters of a case take part. Kernels are compiled without optimisation, and for one direction at a time: vectors
take most of a compiler's time. One case holds them to the directions one by one.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from builders import law_a
from slope_cases import Case, cases, under_weight

from martensite.kernels import compiler
from martensite.simulate import native_slopes

TOLERANCE = 1e-5
GOOD = 0.99
"""Share of places at which differences must be good."""


@pytest.fixture
def unoptimised(c_compiler, monkeypatch):
    """Compile quickly."""
    quick = tuple("-O0" if flag == "-O3" else flag for flag in compiler.FLAGS)
    monkeypatch.setattr(compiler, "FLAGS", quick)


@pytest.fixture
def one_by_one(unoptimised, monkeypatch):
    """Compute one direction at a time."""
    monkeypatch.setattr(native_slopes, "choose_width", lambda count: 1)


def listed(name: str, make: Callable[[], Case], usual: bool):
    return pytest.param(make, id=name, marks=[] if usual else [pytest.mark.slow])


@pytest.mark.parametrize("make", [listed(*row) for row in cases()])
def test_slopes_are_those_of_differences(make: Callable[[], Case], one_by_one):
    case = make()
    error, good = case.apart()
    assert good >= GOOD
    assert error <= TOLERANCE
    found = case.slopes(case.directions)
    assert (found.rows == case.run(case.values)).all()
    assert np.ptp(found.rows, axis=0).max() > 0.0


def test_many_directions_are_those_one_by_one(unoptimised, monkeypatch):
    """Forty directions, in chunks of vectors; a row of zeros moves nothing."""
    monkeypatch.setenv("MARTENSITE_QUICK_C", "off")
    case = under_weight(law_a())
    seeds = case.directions[:, np.arange(40) % 4] * np.linspace(1.0, 2.0, 40)
    seeds[:, 17] = 0.0
    many = case.slopes(seeds).slopes
    assert many.shape[2] == 40
    assert (many[:, :, 17] == 0.0).all()
    for k in (0, 15, 16, 39):
        assert (many[:, :, k] == case.slopes(seeds[:, [k]]).slopes[:, :, 0]).all()
    monkeypatch.setattr(native_slopes, "choose_width", lambda count: 1)
    assert many == pytest.approx(case.slopes(seeds).slopes, rel=1e-9, abs=1e-12 * np.abs(many).max())


def test_a_seed_in_a_wrong_parameter_is_noticed(one_by_one):
    case = under_weight(law_a())
    place, other = (case.compiled.paths.index(f"element.law.{n}") for n in ("C_A", "C_M"))
    wrong = case.directions.copy()
    wrong[[place, other]] = wrong[[other, place]]
    assert case.apart(wrong)[0] > 1e-2
    slightly = case.directions.copy()
    slightly[place] *= 1.0 + 1e-3
    assert case.apart(slightly)[0] > TOLERANCE
