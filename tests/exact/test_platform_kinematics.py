"""Lengths, slopes and angles of the platform.

Source of truth: rotation matrices multiplied by numpy, the closed form of a rotation about X,
and the derivatives of a leg's vector written out by hand.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from grids import over
from hypothesis import given
from hypothesis import strategies as st
from platform_cases import GEOMETRIES, HEIGHT, PLATES, POSTURES, RADIUS, SIDE, about_x, about_y, by_matrices

from martensite.actuators.mechanics.platform_kinematics import (
    Plates,
    compute_length_slopes,
    compute_lengths,
    correct_angles,
    platform_angles,
    platform_lengths,
)
from martensite.base.errors import ParameterError, SolveError
from martensite.kernels import floats
from martensite.kernels.dual import values_and_slopes
from martensite.kernels.nested import sum_column

MIDDLE, BASE = GEOMETRIES[1:3]


def compute_torques(xp: Any, plates: Plates, alpha: Any, beta: Any, pulls: Any) -> tuple[Any, Any]:
    """Generalised torques Q = -Jᵀ F [N m] of the legs' pulls [N]."""
    _, over_alpha, over_beta = compute_length_slopes(xp, plates, alpha, beta)
    first, second = (-sum_column([x * f for x, f in zip(c, pulls, strict=True)]) for c in (over_alpha, over_beta))
    return first, second


# ---------------------------------------------------------------- lengths


@over("plates", GEOMETRIES)
@over("posture", POSTURES)
def test_lengths_are_those_of_matrices(plates: Plates, posture: tuple[float, float]) -> None:
    alpha, beta = posture
    expected = by_matrices(plates, about_y(beta) @ about_x(alpha))
    assert compute_lengths(floats, plates, alpha, beta) == pytest.approx(expected, abs=1e-15)


@over("plates", GEOMETRIES)
def test_legs_are_as_long_as_the_plates_are_apart_at_home(plates: Plates) -> None:
    assert compute_lengths(floats, plates, 0.0, 0.0) == pytest.approx([plates.height] * 3, abs=1e-16)


# ---------------------------------------------------------------- slopes and torques


@over("plates", GEOMETRIES)
@over("posture", POSTURES)
def test_slopes_are_those_of_dual_numbers(plates: Plates, posture: tuple[float, float]) -> None:
    alpha, beta = posture
    _, over_alpha, over_beta = compute_length_slopes(floats, plates, alpha, beta)
    _, a = values_and_slopes(floats, lambda xp, a: compute_lengths(xp, plates, a, beta), alpha)
    _, b = values_and_slopes(floats, lambda xp, b: compute_lengths(xp, plates, alpha, b), beta)
    assert over_alpha == pytest.approx(a, abs=1e-15)
    assert over_beta == pytest.approx(b, abs=1e-15)


@over("plates", GEOMETRIES)
@over("posture", POSTURES)
def test_torques_do_the_work_of_the_legs(plates: Plates, posture: tuple[float, float]) -> None:
    """Q dq = -Σ F dL, by differences of the lengths."""
    pulls, step = [3.0, 5.0, 7.0], 1e-5
    found = compute_torques(floats, plates, *posture, pulls)
    for torque, way in zip(found, ((step, 0.0), (0.0, step)), strict=True):
        ends = [
            np.dot(pulls, compute_lengths(floats, plates, posture[0] + s * way[0], posture[1] + s * way[1]))
            for s in (1.0, -1.0)
        ]
        assert torque == pytest.approx((ends[1] - ends[0]) / (2 * step), abs=1e-9)


def test_three_springs_are_one_isotropic_spring_at_home() -> None:
    """k s²/2 about every axis, 1.162 N m/rad at 232.3 N/m."""
    rate, tilt = 232.3, 1e-6
    for way in ((1.0, 0.0), (0.0, 1.0), (0.6, -0.8)):
        alpha, beta = tilt * way[0], tilt * way[1]
        pulls = [rate * (length - HEIGHT) for length in compute_lengths(floats, PLATES, alpha, beta)]
        stiffness = [-torque / tilt for torque in compute_torques(floats, PLATES, alpha, beta, pulls)]
        assert stiffness == pytest.approx([rate * SIDE**2 / 2 * w for w in way], abs=1e-6)
    assert rate * SIDE**2 / 2 == pytest.approx(1.162, abs=5e-4)


def test_a_hot_spring_against_two_cold_ones_contracts_by_30_mm() -> None:
    """The pulls balance at 33.68°: a check without a free constant."""
    hot, cold, solid = 367.6, 232.3, 0.015

    def torque(alpha: float) -> float:
        first, second, third = compute_lengths(floats, PLATES, alpha, 0.0)
        pulls = [hot * (first - solid), cold * (second - HEIGHT), cold * (third - HEIGHT)]
        return compute_torques(floats, PLATES, alpha, 0.0, pulls)[0]

    low, high = 0.0, 0.7
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if torque(middle) > 0.0 else (low, middle)
    assert math.degrees(low) == pytest.approx(33.68, abs=0.01)
    short = 1e3 * (HEIGHT - compute_lengths(floats, PLATES, low, 0.0)[0])
    assert short == pytest.approx(30.38, abs=0.01)


# ---------------------------------------------------------------- from lengths to angles

ANGLES = st.floats(-math.radians(45.0), math.radians(45.0))


@given(ANGLES, ANGLES, st.sampled_from([PLATES, Plates(0.05, 0.12, 0.12), Plates(0.2, 0.3, 0.25)]))
def test_angles_are_found_again(alpha: float, beta: float, plates: Plates) -> None:
    found = platform_angles(plates, platform_lengths(plates, alpha, beta))
    assert (found.alpha, found.beta) == pytest.approx((alpha, beta), abs=1e-10)
    assert found.residual < 1e-12


@given(ANGLES, ANGLES, st.lists(st.floats(-2e-4, 2e-4), min_size=3, max_size=3))
def test_disturbed_lengths_give_the_best_angles(alpha: float, beta: float, noise: list[float]) -> None:
    """What is left over is perpendicular to both slopes, and no larger than the noise."""
    wanted = [x + e for x, e in zip(compute_lengths(floats, PLATES, alpha, beta), noise, strict=True)]
    found = platform_angles(PLATES, wanted)
    at, over_alpha, over_beta = compute_length_slopes(floats, PLATES, found.alpha, found.beta)
    left = np.subtract(at, wanted)
    assert found.residual == pytest.approx(float(np.linalg.norm(left)), abs=1e-15)
    assert found.residual <= np.linalg.norm(noise) + 1e-12
    assert left @ over_alpha == pytest.approx(0.0, abs=1e-13)
    assert left @ over_beta == pytest.approx(0.0, abs=1e-13)


def test_corrections_square_the_error() -> None:
    wanted, alpha, beta = compute_lengths(floats, PLATES, 0.4, -0.3), 0.0, 0.0
    errors: list[float] = []
    for _ in range(5):
        more = correct_angles(floats, PLATES, wanted, alpha, beta)
        alpha, beta = alpha + more[0], beta + more[1]
        errors.append(math.hypot(alpha - 0.4, beta + 0.3))
    assert errors[2] < 2.0 * errors[1] ** 2 < errors[1]
    assert errors[4] < 1e-12


def test_three_equal_contractions_belong_to_no_posture() -> None:
    with pytest.raises(ParameterError, match=r"50, 50, 50 mm belong to no posture.*17\.3 mm"):
        platform_angles(PLATES, [0.050] * 3)
    best = platform_angles(PLATES, [0.050] * 3, allowed=math.inf)
    assert (best.alpha, best.beta) == pytest.approx((0.0, 0.0), abs=1e-15)
    assert best.residual == pytest.approx(math.sqrt(3.0) * 10e-3, rel=1e-12)


def test_the_allowed_residual_decides() -> None:
    wanted = [0.0605, 0.0605, 0.0605]
    left = platform_angles(PLATES, wanted, allowed=1e-3).residual
    assert left == pytest.approx(math.sqrt(3.0) * 0.5e-3, rel=1e-9)
    with pytest.raises(ParameterError, match=r"0\.866 mm, where 0\.6 mm are allowed"):
        platform_angles(PLATES, wanted)


def test_lengths_far_from_every_posture_do_not_settle() -> None:
    with pytest.raises(SolveError, match="200, 50, 50 mm: 40 corrections did not settle"):
        platform_angles(PLATES, [0.2, 0.05, 0.05])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: platform_lengths(Plates(0.0, 0.06, 0.06), 0.0, 0.0), "`side` of the plates"),
        (lambda: platform_lengths(Plates(0.1, -0.06, 0.06), 0.0, 0.0), "`height`.*above 0"),
        (lambda: platform_lengths(Plates(0.1, 0.06, math.inf), 0.0, 0.0), "`pivot`.*is inf"),
        (lambda: platform_lengths(PLATES, math.nan, 0.0), "`alpha` must be finite, but is nan"),
        (lambda: platform_angles(PLATES, [0.06, 0.06]), "three legs, but 2 lengths"),
        (lambda: platform_angles(PLATES, [0.06, 0.06, 0.0]), "leg 2 must be finite and above 0"),
    ],
)
def test_what_cannot_be_is_refused(call: Any, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        call()


# ---------------------------------------------------------------- runtimes


def test_a_leg_of_no_length_has_no_slope_and_no_error() -> None:
    """Vertex 0 meets its base at α = 2 atan(h/2r) if the joint is half-way up."""
    length, *found = compute_length_slopes(floats, MIDDLE, 2.0 * math.atan(0.5 * HEIGHT / RADIUS), 0.0)
    assert length[0] < 1e-15
    assert max(abs(column[0]) for column in found) < 1e-6


# ---------------------------------------------------------------- the check can fail
