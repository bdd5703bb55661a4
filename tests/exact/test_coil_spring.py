"""Coil spring: mapping to torsion, published numbers, curvature, refusals.

Sources of truth: the formulas of Wahl and of the platform's paper written out here, numbers
recomputed from its Table 1.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from builders import ZERO
from coil_cases import (
    CLOSED,
    COIL,
    COLD,
    G_A,
    G_M,
    NUMBERS,
    ROOT3,
    TURNS,
    WIRE,
    elongation,
    platform_law,
    platform_spring,
    tangent,
)

from martensite.actuators.elements import coil_theory
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.brinson import Brinson

RATE_A, RATE_M = (g * WIRE**4 / (8 * TURNS * COIL**3) for g in (G_A, G_M))
STATES = (0.0, 0.3, 0.7, 1.0)


def exact(value: float) -> Any:
    return pytest.approx(value, rel=1e-12, abs=1e-12 * abs(value))


# ---------------------------------------------------------------- the published spring


def test_rates_of_the_two_readings_of_the_coil_diameter() -> None:
    outer, mean = platform_spring(), platform_spring(coil_measure="mean")
    rates = [1.0 / tangent(spring, x).compliance for spring in (outer, mean) for x in (0.0, 1.0)]
    assert rates[:3] == pytest.approx([367.6, 232.3, 246.3], abs=0.05)
    assert rates[0] == exact(RATE_A)
    assert rates[0] / rates[2] == pytest.approx(1.49, abs=0.005)
    assert outer.mean_diameter() == exact(COIL)


def test_mass_length_surface_and_resistance() -> None:
    outer, mean = platform_spring(), platform_spring(coil_measure="mean")
    assert outer.mass() == pytest.approx(0.940e-3, abs=5e-7)
    assert mean.mass() == pytest.approx(1.074e-3, abs=5e-7)
    assert (outer.wire_length(), mean.wire_length()) == pytest.approx((0.330, 0.377), abs=5e-4)
    assert (outer.surface(), mean.surface()) == pytest.approx((7.77e-4, 8.88e-4), abs=5e-7)
    assert outer.solid_length() == exact(CLOSED)
    ohms = [outer.ohms(floats, x, 0.0, 300.0) for x in (0.0, 1.0)]
    assert ohms == pytest.approx([0.7246, 0.8197], abs=5e-4)


def test_large_deflection_counts_the_pitch_in_the_wire() -> None:
    spring = platform_spring(deflection="large", free_length=40e-3)
    assert spring.wire_length() == exact(math.hypot(math.pi * TURNS * COIL, 40e-3))
    assert spring.mass() / spring.wire_length() == exact(spring.density * spring.section())


def test_transformation_modulus_follows_from_the_two_free_lengths() -> None:
    force = -RATE_M * (COLD - CLOSED)
    omega = force * 8 * ROOT3 * COIL / (math.pi * WIRE**3)
    assert omega == pytest.approx(-574e6, abs=0.5e6)
    assert -NUMBERS["eps_L"] * NUMBERS["E_M"] == pytest.approx(omega, rel=1e-3)
    cold = tangent(platform_spring(), 1.0).free
    assert cold == pytest.approx(COLD - CLOSED, rel=1e-3)


@pytest.mark.parametrize("fraction", STATES)
def test_published_force_is_the_transformation_stress_form(fraction: float) -> None:
    """F = G(ξ) d⁴ y/(8 N D³) + π d³ Ω ξ/(8 √3 D), with a constant Ω."""
    spring = platform_spring()
    omega = -NUMBERS["eps_L"] * NUMBERS["E_M"]
    shear = G_A + fraction * (G_M - G_A)
    for force in (0.0, 2.0, 9.0):
        y = elongation(spring, fraction, force)
        drawn = shear * WIRE**4 / (8 * TURNS * COIL**3) * y
        assert drawn + math.pi * WIRE**3 * omega * fraction / (8 * ROOT3 * COIL) == pytest.approx(
            force, rel=1e-12, abs=1e-12
        )


def test_the_two_forms_agree_in_both_phases_only() -> None:
    stress, strain = (platform_spring(law=platform_law(transformation=word)) for word in ("stress", "strain"))
    for fraction in (0.0, 1.0):
        assert tangent(stress, fraction) == pytest.approx(tangent(strain, fraction), rel=1e-14)
    middle = tangent(strain, 0.5).free
    assert middle == exact(0.5 * tangent(strain, 1.0).free)
    assert tangent(stress, 0.5).free == exact(middle * G_M / (0.5 * (G_A + G_M)))


def test_a_constant_modulus_knows_one_form_only() -> None:
    stress, strain = (
        platform_spring(law=platform_law(modulus="martensite", transformation=word)) for word in ("stress", "strain")
    )
    assert tangent(stress, 0.4) == pytest.approx(tangent(strain, 0.4), rel=1e-14)


# ---------------------------------------------------------------- the mapping


@pytest.mark.parametrize("measure", ["mean", "outer"])
def test_work_of_the_force_is_that_of_the_shear(measure: str) -> None:
    """F y = τ γ Vol/2: torsion uses half of the wire."""
    spring = platform_spring(coil_measure=measure)
    force, y = 7.0, 0.02
    shear_stress = spring.stress(floats, force) / ROOT3
    shear = spring.strain(floats, y) * ROOT3
    volume = spring.section() * spring.wire_length()
    assert force * y == exact(0.5 * shear_stress * shear * volume)
    D = spring.mean_diameter()
    assert shear_stress == exact(8 * force * D / (math.pi * WIRE**3))
    assert shear == exact(WIRE * y / (math.pi * TURNS * D**2))
    assert shear_stress == exact(coil_theory.shear_stress(force, WIRE, D))


@pytest.mark.parametrize("fraction", STATES)
def test_law_and_spring_agree_on_the_strain(fraction: float) -> None:
    spring = platform_spring()
    for force in (0.0, 3.0, 12.0):
        stress = spring.stress(floats, force)
        strain = spring.law.strain(floats, Fractions(fraction, fraction), stress, 300.0)
        found = spring.strain(floats, elongation(spring, fraction, force))
        assert found == pytest.approx(strain, rel=1e-12, abs=1e-16)


# ---------------------------------------------------------------- curvature


def test_factors_of_the_platform_spring() -> None:
    index = platform_spring().index()
    assert index == exact(7.0)
    found = [
        f(index)
        for f in (
            coil_theory.exact_stiffness,
            coil_theory.ancker_goodier,
            coil_theory.exact_stress,
            coil_theory.compute_bergstraesser_factor,
            coil_theory.compute_wahl_factor,
        )
    ]
    assert found[:2] == pytest.approx([1.003899, 1.003841], abs=5e-7)
    assert found[2:] == pytest.approx([1.19900, 1.2000, 1.2129], abs=5e-5)
    assert 1.0 / (1.0 + 1.0 / (2 * index**2)) < 1.0 < found[0]  # the handbooks' wrong sign


def test_factors_of_thin_coils_approach_one() -> None:
    for f in (*stress_factors(), coil_theory.ancker_goodier, coil_theory.exact_stiffness):
        assert f(1e6) == pytest.approx(1.0, abs=2e-6)
        assert f(20.0) > f(40.0) > 1.0


def stress_factors() -> tuple[Any, ...]:
    return (coil_theory.compute_bergstraesser_factor, coil_theory.compute_wahl_factor, coil_theory.exact_stress)


@pytest.mark.parametrize(
    ("word", "factor"), [("bergstraesser", 1.2), ("wahl", 27 / 24 + 0.615 / 7), ("exact", 1.19900)]
)
def test_stress_factor_acts_on_the_stress_alone(word: str, factor: float) -> None:
    plain, chosen = platform_spring(), platform_spring(stress_factor=word)
    assert chosen.stress(floats, 3.0) / plain.stress(floats, 3.0) == pytest.approx(factor, rel=1e-5)
    assert tangent(chosen, 0.4) == tangent(plain, 0.4)


@pytest.mark.parametrize("deflection", ["small", "large"])
@pytest.mark.parametrize(("word", "factor"), [("ancker-goodier", 1.003841), ("exact", 1.003899)])
def test_stiffness_factor_acts_on_the_rate_alone(word: str, factor: float, deflection: str) -> None:
    plain = platform_spring(deflection=deflection)
    chosen = platform_spring(deflection=deflection, stiffness_factor=word)
    assert chosen.stress(floats, 3.0) == plain.stress(floats, 3.0)
    for fraction in STATES:
        y = elongation(plain, fraction, 4.0)
        assert elongation(chosen, fraction, 4.0 * factor) == pytest.approx(y, rel=1e-6)


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"coil_diameter": "1 mm"}, ["spring index", "above 1", "0.3333"]),
        ({"coil_diameter": "2 mm", "stress_factor": "exact"}, ["at least 3", "1.667"]),
        ({"coil_diameter": "2 mm", "stiffness_factor": "exact"}, ["at least 3", "1.667"]),
        ({"free_length": "14 mm"}, ["`free_length`", "at least the solid length", "15 mm", "14"]),
        ({"free_length": "400 mm"}, ["`free_length`", "at most", "45 deg"]),
        ({"initial_oriented": 0.5}, ["`initial_oriented` of `coil-spring`", "try law `brinson`"]),
        ({"coil_measure": "inner"}, ["`coil_measure`", "`mean`"]),
    ],
)
def test_impossible_springs_are_refused(changes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ParameterError) as caught:
        platform_spring(**changes)
    for word in words:
        assert word in str(caught.value)


def test_steep_coils_are_cautioned_against() -> None:
    steep = {"free_length": 100e-3}
    assert "large" in " ".join(platform_spring(**steep).cautions())
    assert platform_spring(**steep, deflection="large").cautions() == []
    assert platform_spring().cautions() == []


def test_twinned_martensite_may_be_wound() -> None:
    known: dict[str, Any] = {n: v for n, v in NUMBERS.items() if n in Brinson.declarations}
    law = Brinson(**known, sigma_s=20e6, sigma_f=60e6)
    spring = platform_spring(law=law, initial_oriented=0.0)
    assert spring.spring(floats, spring.initial_fractions(floats, 0.0), 25 + ZERO, 0.0).free == 0.0


# ---------------------------------------------------------------- the checks can fail
