"""Curvature factors of coils against two solutions of the elastic torus sector."""

from __future__ import annotations

import pytest
from torus_reference import collocated, ritz, stiffness_terms, stress_terms

from martensite.actuators.elements import coil_theory

INDICES = (3.0, 3.3, 4.0, 5.0, 7.0, 11.0, 20.0)


@pytest.mark.parametrize("index", [n if n in (3.0, 7.0) else pytest.param(n, marks=pytest.mark.slow) for n in INDICES])
def test_the_two_solutions_agree(index: float) -> None:
    energy, points = ritz(index, 26 if index < 4.0 else 22), collocated(index)
    assert energy.stiffness == pytest.approx(points.stiffness, abs=1e-11)
    assert energy.peak_stress == pytest.approx(points.peak_stress, abs=1e-8)


def test_each_solution_converges_on_its_own() -> None:
    assert ritz(7.0, 14).stiffness == pytest.approx(ritz(7.0, 22).stiffness, abs=1e-12)
    assert collocated(7.0, 21, 30) == pytest.approx(collocated(7.0), abs=1e-10)
    assert ritz(7.0, 6).peak_stress != pytest.approx(ritz(7.0).peak_stress, abs=1e-8)


@pytest.mark.parametrize("index", [*INDICES, 50.0])
def test_the_package_is_within_a_millionth(index: float) -> None:
    found = collocated(index)
    assert coil_theory.exact_stiffness(index) == pytest.approx(found.stiffness, abs=1e-7)
    assert coil_theory.exact_stress(index) == pytest.approx(found.peak_stress, abs=1e-7)


def test_coefficients_of_the_package_come_from_here() -> None:
    assert coil_theory.STIFFNESS_TERMS == pytest.approx(stiffness_terms(), abs=1e-8)
    assert coil_theory.STRESS_TERMS == pytest.approx(stress_terms(), abs=1e-6)


def test_leading_terms_are_those_of_the_expansion_in_the_curvature() -> None:
    """1 + 3/(16 C²) + … of the stiffness, 1 + 5/(4C) + 7/(8C²) + … of the stress."""
    found = collocated(200.0)
    assert (found.stiffness - 1.0) * 200.0**2 == pytest.approx(3.0 / 16.0, abs=1e-4)
    stress = (found.peak_stress - 1.0 - 1.25 / 200.0) * 200.0**2
    assert stress == pytest.approx(7.0 / 8.0, abs=1e-2)
