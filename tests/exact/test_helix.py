"""Springs at large deflection: force and stiffness are derivatives of the energy of the rod.

Source of truth: the energy of a helical rod in curvature and twist, written out here as in the
textbooks, and differences of it of sixth order.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from coil_cases import CLOSED, COIL, G_A, G_M, ROOT3, TURNS, WIRE, force_at, platform_spring

from martensite.actuators.elements import helix
from martensite.kernels import floats
from martensite.physics.laws.base import Fractions

NU = 0.33
LENGTHS = (0.02, 0.06, 0.09, 0.15, 0.25)


def rod(pitch_length: float = CLOSED, strain: float = 0.0, shear: float = G_A) -> helix.Helix:
    """A spring of the platform, of an unloaded length [m] and a transformation strain [-]."""
    length = math.hypot(math.pi * TURNS * COIL, pitch_length)
    return helix.Helix(
        length=length,
        angle=2 * math.pi * TURNS / length,
        sine=pitch_length / length,
        bending=2 * shear * (1 + NU) * math.pi * WIRE**4 / 64,
        poisson=NU,
        twist=2 * ROOT3 * strain / WIRE,
    )


def energy(spring: helix.Helix, height: float) -> float:
    """U = (l/2) (E I dk² + G J (dt - dt_tr)²) [J]; radius and pitch angle follow the length."""
    pitch, pitch0 = (math.asin(s) for s in (height / spring.length, spring.sine))
    radius0 = math.cos(pitch0) / spring.angle
    radius = radius0 * math.cos(pitch) / math.cos(pitch0)
    curvature = math.cos(pitch) ** 2 / radius - math.cos(pitch0) ** 2 / radius0
    twist = math.sin(pitch) * math.cos(pitch) / radius
    twist -= math.sin(pitch0) * math.cos(pitch0) / radius0 + spring.twist
    torsion = spring.bending / (1 + NU)
    return 0.5 * spring.length * (spring.bending * curvature**2 + torsion * twist**2)


def slope(function: Callable[[float], float], x: float, step: float) -> float:
    """Sixth-order central difference."""
    terms = (45.0, -9.0, 1.0)
    found = sum(weight * (function(x + k * step) - function(x - k * step)) for k, weight in enumerate(terms, start=1))
    return found / (60.0 * step)


CASES = [rod(), rod(30e-3), rod(CLOSED, 0.011, G_M), rod(60e-3, 0.03)]


@pytest.mark.parametrize("spring", CASES)
@pytest.mark.parametrize("height", LENGTHS)
def test_force_is_the_derivative_of_the_energy(spring: helix.Helix, height: float) -> None:
    force = helix.at_length(floats, spring, height).force
    found = slope(lambda h: energy(spring, h), height, 1e-3 * height)
    scale = max(abs(force), 1.0)
    assert found == pytest.approx(force, abs=1e-10 * scale)


@pytest.mark.parametrize("spring", CASES)
@pytest.mark.parametrize("height", LENGTHS)
def test_tangent_is_the_derivative_of_the_force(spring: helix.Helix, height: float) -> None:
    point = helix.at_length(floats, spring, height)
    found = slope(lambda h: helix.at_length(floats, spring, h).force, height, 1e-3 * height)
    assert found * point.compliance == pytest.approx(1.0, abs=1e-10)


@pytest.mark.parametrize("spring", CASES)
def test_force_finds_its_length_from_pressed_to_straight(spring: helix.Helix) -> None:
    for share in (-0.2, 0.0, 0.05, 0.2, 0.5, 0.9, 0.99):
        point = helix.at_length(floats, spring, share * spring.length)
        found = helix.at_force(floats, spring, point.force)
        assert found.length == pytest.approx(point.length, abs=1e-13)
        assert found.force == pytest.approx(point.force, abs=1e-10 * max(1.0, abs(point.force)))


def test_flat_springs_are_linear_at_small_deflection() -> None:
    """The deviation falls with the square of the deflection."""
    flat = rod(0.0)
    rate = G_A * WIRE**4 / (8 * TURNS * COIL**3)
    off = [helix.at_length(floats, flat, y).force / (rate * y) - 1.0 for y in (4e-3, 2e-3, 1e-3)]
    assert 0.0 < off[2] < 1e-5
    assert [off[0] / off[1], off[1] / off[2]] == pytest.approx([4.0, 4.0], rel=1e-3)
    twisted = rod(0.0, 1e-6)
    free = helix.at_force(floats, twisted, 0.0).length
    small = ROOT3 * 1e-6 * math.pi * TURNS * COIL**2 / WIRE
    assert free == pytest.approx(small, rel=1e-6)


def test_how_far_the_linear_spring_falls_short() -> None:
    """2.5, 4.0 and 5.8 % at 60, 75 and 90 mm, hot and cold alike."""
    spring, rate = platform_spring(deflection="large"), G_A * WIRE**4 / (8 * TURNS * COIL**3)
    for length, percent in ((60e-3, 2.5), (75e-3, 4.0), (90e-3, 5.8)):
        excess = force_at(spring, 0.0, length) / (rate * (length - CLOSED)) - 1.0
        assert 100.0 * excess == pytest.approx(percent, abs=0.05)
        alike = helix.at_length(floats, rod(shear=G_M), length).force * G_A / G_M
        assert alike == pytest.approx(helix.at_length(floats, rod(), length).force, rel=1e-12)


def test_element_and_rod_are_one() -> None:
    """The element's tangent is that of the rod with the strain and the modulus of its law."""
    spring = platform_spring(deflection="large", poisson=NU)
    for fraction in (0.0, 0.4, 1.0):
        law, phases = spring.law, Fractions(fraction, fraction)
        strain = law.free_strain(floats, phases, 300.0)
        shear = 1.0 / (3.0 * law.compliance(floats, phases))
        for height in (0.02, 0.05, 0.1, 0.2):
            point = helix.at_length(floats, rod(CLOSED, strain, shear), height)
            if point.force < 0.0:
                continue
            found = spring.spring(floats, phases, 300.0, point.force)
            assert found.compliance == pytest.approx(point.compliance, rel=1e-10)
            y = found.free + found.compliance * point.force
            assert y == pytest.approx(height - CLOSED, abs=1e-12)


def test_root_without_a_namespace_is_exact() -> None:
    for t in (0.0, 0.045, 0.3, 1.0):
        assert helix.compute_secant(t) == pytest.approx(math.hypot(1.0, t), rel=1e-15)
