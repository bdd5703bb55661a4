"""Inertia and weight of the top plate: Lagrange's equations of a triangle made of three masses.

Source of truth: a third of the mass at the middle of each side has the mass, centroid and
moments of inertia of a uniform triangle. The positions of the three are turned here about X and
Y; velocities and Lagrange's derivatives are dual numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from grids import over
from platform_cases import GEOMETRIES, PLATES, POSTURES, SIDE

from martensite.actuators.mechanics.platform_kinematics import Plates, locate_corners
from martensite.actuators.mechanisms.parallel_platform import (
    AngleRates,
    TopPlate,
    Torques,
    inertia_forces,
    kinetic_energy,
    thin_plate,
    weight_torques,
)
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope, values_and_slopes

MASS, GRAVITY = 0.075, 9.81
RATES, ACCELERATIONS = AngleRates(1.7, -2.3), AngleRates(-11.0, 6.0)
MOTIONS = [RATES, AngleRates(0.0, 3.0), AngleRates(-2.0, 0.0)]


def compute_accelerations(xp: Any, plate: TopPlate, alpha: Any, rates: AngleRates, applied: Torques) -> AngleRates:
    """Angular accelerations [rad/s²] under applied torques [N m]: the inverse of `inertia_forces`."""
    sine, shifted = xp.sin(alpha), plate.mass * plate.above * plate.above
    least, more = plate.inertia + shifted, plate.inertia - shifted
    own = inertia_forces(xp, plate, alpha, rates, AngleRates(0.0, 0.0))
    return AngleRates((applied.alpha - own.alpha) / least, (applied.beta - own.beta) / (least + more * sine * sine))


def masses(xp: Any, plates: Plates, alpha: Any, beta: Any) -> list[Any]:
    """X, Y and Z of the three masses, seen from the joint."""
    ca, sa, cb, sb = xp.cos(alpha), xp.sin(alpha), xp.cos(beta), xp.sin(beta)
    points: list[Any] = []
    for x, y in locate_corners(plates.side):
        # the middle of the side opposite of a vertex is half as far from the centroid
        x, y, z = -0.5 * x, -0.5 * y, -(plates.height - plates.pivot)
        y, z = ca * y - sa * z, sa * y + ca * z
        points += [cb * x + sb * z, y, cb * z - sb * x]
    return points


def energy(xp: Any, plates: Plates, posture: Any, rates: Any) -> Any:
    """T [J] of the three masses."""
    alpha, beta = posture
    _, over_alpha = values_and_slopes(xp, lambda xp, a: masses(xp, plates, a, beta), alpha)
    _, over_beta = values_and_slopes(xp, lambda xp, b: masses(xp, plates, alpha, b), beta)
    found = 0.0
    for a, b in zip(over_alpha, over_beta, strict=True):
        speed = a * rates[0] + b * rates[1]
        found = found + speed * speed
    return MASS / 6.0 * found


def lagrange(plates: Plates, posture: Any, rates: Any, accelerations: Any) -> list[float]:
    """d/dt ∂T/∂q' - ∂T/∂q for both angles, along a motion with these derivatives at t = 0."""

    def at(t: Any) -> tuple[list[Any], list[Any]]:
        angles = [q + v * t + 0.5 * a * (t * t) for q, v, a in zip(posture, rates, accelerations, strict=True)]
        return angles, [v + a * t for v, a in zip(rates, accelerations, strict=True)]

    def replaced(items: list[Any], k: int, item: Any) -> list[Any]:
        return [*items[:k], item, *items[k + 1 :]]

    def momentum(xp: Any, k: int, t: Any) -> Any:
        angles, speeds = at(t)
        return value_and_slope(xp, lambda xp, v: energy(xp, plates, angles, replaced(speeds, k, v)), speeds[k])[1]

    def pull(k: int) -> float:
        angles, speeds = at(0.0)
        return value_and_slope(floats, lambda xp, q: energy(xp, plates, replaced(angles, k, q), speeds), angles[k])[1]

    return [value_and_slope(floats, lambda xp, t, k=k: momentum(xp, k, t), 0.0)[1] - pull(k) for k in (0, 1)]


class TestLagrange:
    @over("plates", GEOMETRIES)
    @over("posture", POSTURES)
    @over("rates", MOTIONS)
    def test_energy(self, plates: Plates, posture: Any, rates: AngleRates) -> None:
        found = kinetic_energy(floats, thin_plate(plates, MASS), posture[0], rates)
        assert found == pytest.approx(energy(floats, plates, posture, rates), rel=1e-13)

    @over("plates", GEOMETRIES)
    @over("posture", POSTURES)
    @over("rates", MOTIONS)
    def test_inertia_forces(self, plates: Plates, posture: Any, rates: AngleRates) -> None:
        plate = thin_plate(plates, MASS)
        found = inertia_forces(floats, plate, posture[0], rates, ACCELERATIONS)
        expected = lagrange(plates, posture, rates, ACCELERATIONS)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-17)

    @over("plates", GEOMETRIES)
    @over("posture", POSTURES)
    @over("rates", MOTIONS)
    def test_accelerations(self, plates: Plates, posture: Any, rates: AngleRates) -> None:
        plate = thin_plate(plates, MASS)
        forces = inertia_forces(floats, plate, posture[0], rates, ACCELERATIONS)
        found = compute_accelerations(floats, plate, posture[0], rates, forces)
        assert found == pytest.approx(ACCELERATIONS, rel=1e-13)


@over("plates", GEOMETRIES)
@over("posture", POSTURES)
def test_weight_pulls_down_the_slope_of_its_height(plates: Plates, posture: Any) -> None:
    """Z points down: V = -M g z of the centroid."""

    def potential(xp: Any, alpha: Any, beta: Any) -> Any:
        down = masses(xp, plates, alpha, beta)[2::3]
        return -MASS * GRAVITY * (down[0] + down[1] + down[2]) / 3.0

    alpha, beta = posture
    found = weight_torques(floats, thin_plate(plates, MASS), GRAVITY, alpha, beta)
    over_alpha = value_and_slope(floats, lambda xp, a: potential(xp, a, beta), alpha)[1]
    over_beta = value_and_slope(floats, lambda xp, b: potential(xp, alpha, b), beta)[1]
    assert found == pytest.approx((-over_alpha, -over_beta), abs=1e-16)


def test_weight_turns_a_plate_above_its_joint_further_and_one_below_it_back() -> None:
    for pivot, sign in ((0.04, 1.0), (0.06, 0.0), (0.08, -1.0)):
        plate = thin_plate(Plates(SIDE, 0.06, pivot), MASS)
        for torque in weight_torques(floats, plate, GRAVITY, 0.2, 0.2):
            assert torque * sign > 0.0 or torque == sign == 0.0
        hanging = weight_torques(floats, plate, -GRAVITY, 0.2, 0.2)
        assert hanging == pytest.approx(
            [-torque for torque in weight_torques(floats, plate, GRAVITY, 0.2, 0.2)], abs=0.0
        )


def test_moments_of_a_uniform_triangle() -> None:
    """M s²/24 in its plane, twice that across it; by an even grid of points as a second source."""
    plate = thin_plate(PLATES, MASS)
    assert plate.inertia == pytest.approx(3.125e-5, rel=1e-12)
    count = 400
    i, j = np.meshgrid(np.arange(count), np.arange(count))
    below = i + j < count
    # centroids of the small upright triangles and, one fewer a row, of those turned over
    thirds = [(i[below] + 1 / 3, j[below] + 1 / 3)]
    below = i + j < count - 1
    thirds.append((i[below] + 2 / 3, j[below] + 2 / 3))
    u, v = (np.concatenate([t[k] for t in thirds]) / count for k in (0, 1))
    (x0, y0), (x1, y1), (x2, y2) = locate_corners(SIDE)
    x, y = x0 + u * (x1 - x0) + v * (x2 - x0), y0 + u * (y1 - y0) + v * (y2 - y0)
    about_x, about_y, about_z = (MASS * np.mean(q) for q in (y**2, x**2, x**2 + y**2))
    assert [about_x, about_y] == pytest.approx([plate.inertia] * 2, rel=1e-5)
    assert about_z == pytest.approx(2.0 * plate.inertia, rel=1e-5)


# ---------------------------------------------------------------- the check can fail
