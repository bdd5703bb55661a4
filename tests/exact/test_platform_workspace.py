"""Where the platform can go: the set on its grid, its extents, and curves of single legs.

Source of truth: components of the allowed set labelled by SciPy, the closed form of a rotation
about X, and the balance of three springs solved by SciPy.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from platform_cases import GEOMETRIES, HEIGHT, PLATES, RADIUS, SIDE, about_x, about_y, by_matrices
from scipy.ndimage import label
from scipy.optimize import brentq, fsolve

from martensite.actuators.mechanics.platform_kinematics import Plates, compute_length_slopes, compute_lengths
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.studies.platform.workspace import (
    Legs,
    Workspace,
    compute_crosswise,
    find_balanced,
    reachable_angles,
    trace_ray,
)

SHORTEST, LONGEST = 0.030, 0.090
STEP = math.radians(0.5)


@cache
def workspace() -> Workspace:
    return reachable_angles(PLATES, SHORTEST, LONGEST)


def allowed(plates: Plates, alphas: Any, betas: Any) -> Any:
    """Whether all legs keep within the limits, on a grid, by matrices."""
    found = [[by_matrices(plates, about_y(beta) @ about_x(alpha)) for beta in betas] for alpha in alphas]
    within = (np.array(found) >= SHORTEST) & (np.array(found) <= LONGEST)
    return within.all(axis=-1)


def test_extents_along_the_axes() -> None:
    """+33.06/-30.87° about X, ±36.14° about Y."""
    found = workspace()
    degrees = [math.degrees(x) for x in (*found.alpha_extent, *found.beta_extent)]
    assert degrees == pytest.approx([-30.87, 33.06, -36.14, 36.14], abs=6e-3)

    def left(alpha: float, limit: float) -> float:
        square = 2 * RADIUS**2 * (1 - math.cos(alpha)) - 2 * HEIGHT * RADIUS * math.sin(alpha)
        return math.sqrt(square + HEIGHT**2) - limit

    low, high = brentq(left, -1.0, 0.0, (LONGEST,)), brentq(left, 0.0, 0.8, (SHORTEST,))
    assert found.alpha_extent == pytest.approx((low, high), abs=1e-11)
    for beta in found.beta_extent:
        assert max(compute_lengths(floats, PLATES, 0.0, beta)) == pytest.approx(LONGEST, abs=1e-13)


def test_the_set_is_the_component_of_home() -> None:
    """On a grid of 2°: six components, in one of them home; the others lie in the corners."""
    step = math.radians(2.0)
    found = reachable_angles(PLATES, SHORTEST, LONGEST, step)
    grid = np.arange(-44, 45) * step
    labelled: Any = label(allowed(PLATES, grid, grid))
    parts, count = labelled
    middle = len(grid) // 2
    expected = {(int(i) - 44, int(j) - 44) for i, j in np.argwhere(parts == parts[middle, middle])}
    points = {(round(a / step), round(b / step)) for a, b in found.points()}
    assert points == expected
    assert count > 3
    assert (parts > 0).sum() > len(expected)


def test_the_set_is_wider_than_along_the_axes() -> None:
    (low, high), (least, most) = workspace().bounds
    assert [math.degrees(x) for x in (low, high, least, most)] == pytest.approx([-32.0, 37.0, -38.0, 38.0], abs=0.01)
    assert high > workspace().alpha_extent[1]
    assert most > workspace().beta_extent[1]


def test_the_grid_is_one_line_wider_than_the_set() -> None:
    flags = np.array(workspace().reached)
    assert flags.shape == (len(workspace().alphas), len(workspace().betas))
    assert not (flags[0].any() or flags[-1].any() or flags[:, 0].any() or flags[:, -1].any())
    assert flags[1].any() and flags[-2].any() and flags[:, 1].any() and flags[:, -2].any()
    np.testing.assert_allclose(np.diff(workspace().alphas), STEP, rtol=1e-12)
    assert flags.sum() == len(workspace().points())


def test_islands_are_allowed_but_not_reached() -> None:
    legs = workspace().legs
    for degrees in ((65.0, 0.0), (-30.0, 50.0), (-30.0, -50.0)):
        alpha, beta = (math.radians(x) for x in degrees)
        assert legs.allow(alpha, beta)
        assert all(math.hypot(a - alpha, b - beta) > 0.1 for a, b in workspace().points())


def test_wide_limits_end_at_ninety_degrees() -> None:
    found = reachable_angles(PLATES, 1e-3, 1.0, math.radians(5.0))
    assert [math.degrees(x) for x in found.alpha_extent] == pytest.approx([-90.0, 90.0])
    assert math.degrees(found.bounds[1][1]) == pytest.approx(85.0)


# ---------------------------------------------------------------- one leg alone


def test_leg_0_alone_turns_about_x_only() -> None:
    alphas, betas = zip(*workspace().rays[0], strict=True)
    assert max(abs(beta) for beta in betas) < 1e-12
    assert alphas[-1] == pytest.approx(workspace().alpha_extent[1], abs=1e-11)
    assert np.diff(alphas)[:-1] == pytest.approx(STEP, rel=1e-12)


@pytest.mark.parametrize("plates", GEOMETRIES)
def test_legs_leave_home_at_120_degrees(plates: Plates) -> None:
    legs = Legs(plates, 0.98 * plates.height, 1.02 * plates.height)
    rays = [trace_ray(plates, leg, math.radians(0.1), legs.allow) for leg in range(3)]
    headings = [math.degrees(math.atan2(*reversed(points[1]))) for points in rays]
    assert headings == pytest.approx([0.0, 120.0, -120.0], abs=0.1)


def balance(leg: int, rate: float) -> Any:
    """Where a hot spring of 15 mm unloaded length holds two cold ones of 232.3 N/m: (α, β)."""

    def torque(posture: Any) -> Any:
        found, over_alpha, over_beta = compute_length_slopes(floats, PLATES, *posture)
        pulls = [232.3 * (length - HEIGHT) for length in found]
        pulls[leg] = rate * (found[leg] - 0.015)
        return np.dot(over_alpha, pulls), np.dot(over_beta, pulls)

    heading = leg * math.tau / 3.0
    posture: Any = fsolve(torque, (0.4 * math.cos(heading), 0.4 * math.sin(heading)), xtol=1e-11)
    assert np.abs(torque(posture)).max() < 1e-9
    return posture


@pytest.mark.parametrize(("leg", "rate"), [(0, 367.6), (1, 50.0), (2, 150.0)])
def test_a_spring_of_any_rate_pulls_along_its_ray(leg: int, rate: float) -> None:
    alpha, beta = balance(leg, rate)
    assert compute_crosswise(floats, PLATES, leg, alpha, beta) == pytest.approx(0.0, abs=1e-14)
    heading = math.atan2(beta, alpha)
    found = find_balanced(PLATES, leg, math.hypot(alpha, beta), heading + 0.01)
    assert found == pytest.approx((alpha, beta), abs=1e-10)
    points = np.array(trace_ray(PLATES, leg, STEP, Legs(PLATES, 0.028, 0.100).allow))
    assert np.hypot(*(points - found).T).min() <= 0.5001 * STEP


def test_where_hot_springs_go() -> None:
    found = [np.degrees(balance(leg, 367.6)) for leg in range(3)]
    expected = [(33.68, 0.0), (-17.77, 28.13), (-17.77, -28.13)]
    np.testing.assert_allclose(found, expected, atol=6e-3)


@pytest.mark.parametrize("leg", [1, 2])
def test_every_point_of_a_ray_is_balanced_and_the_end_is_at_a_limit(leg: int) -> None:
    points = workspace().rays[leg]
    assert max(abs(compute_crosswise(floats, PLATES, leg, *point)) for point in points) < 1e-9 * SIDE**3
    assert np.hypot(*np.diff(points, axis=0).T)[:-1] == pytest.approx(STEP, rel=0.05)
    assert compute_lengths(floats, PLATES, *points[-1])[leg] == pytest.approx(SHORTEST, abs=1e-12)


def test_a_ray_ends_where_its_leg_gets_no_shorter() -> None:
    found = reachable_angles(PLATES, 0.020, 0.200, math.radians(1.0))
    for leg, points in enumerate(found.rays):
        least = compute_lengths(floats, PLATES, *points[-1])[leg]
        assert least == pytest.approx(math.hypot(RADIUS, HEIGHT) - RADIUS, abs=1e-9)
    assert math.degrees(found.rays[0][-1][0]) == pytest.approx(46.10, abs=5e-3)


# ---------------------------------------------------------------- what is refused


def test_limits_at_home_leave_nothing_else() -> None:
    found = reachable_angles(PLATES, HEIGHT, LONGEST)
    assert found.points() == [(0.0, 0.0)]
    assert found.rays == [[(0.0, 0.0)]] * 3
    assert found.alpha_extent == (0.0, 0.0)


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ((0.07, 0.09, STEP), "60 mm, which is not within 70, 90 mm"),
        ((0.03, 0.05, STEP), "60 mm, which is not within 30, 50 mm"),
        ((0.03, math.inf, STEP), "`longest` must be finite"),
        ((0.03, 0.09, 0.0), "0.05 to 5 degrees, but is 0 rad"),
        ((0.03, 0.09, math.nan), "0.05 to 5 degrees"),
    ],
)
def test_what_cannot_be_is_refused(numbers: tuple[float, float, float], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        reachable_angles(PLATES, *numbers)


# ---------------------------------------------------------------- the check can fail
