"""Order and damping of the motion of a mechanism over a step, on an oscillator."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from martensite.actuators.mechanics.motion import MotionHistory, move_dynamically, predict_position, quasi_static
from martensite.kernels import floats

OMEGA, ZETA = 2.0 * math.pi, 0.05


def march(dt: float, end: float, rho: float, omega: float = OMEGA, zeta: float = ZETA) -> MotionHistory:
    """An oscillator released at 1: each step is linear in the offset of the position at its end."""
    return follow(MotionHistory((1.0,), (0.0,), (-omega * omega,), (-omega * omega,)), dt, end, rho, omega, zeta)


def follow(
    course: MotionHistory, dt: float, end: float, rho: float, omega: float, zeta: float, rest: float = 0.0
) -> MotionHistory:
    """The oscillator about `rest`."""
    for _ in range(round(end / dt)):
        after = move_dynamically(floats, course, dt, rho)

        def residual(offset: float, after=after) -> float:
            (x,), (v,), (a,) = after((offset,)).motion()
            return a + 2.0 * zeta * omega * v + omega * omega * (x - rest)

        first = residual(0.0)
        course = after((-first / (residual(1.0) - first),))
    return course


def exact(time: float) -> float:
    damped = OMEGA * math.sqrt(1.0 - ZETA * ZETA)
    decay = math.exp(-ZETA * OMEGA * time)
    return decay * (math.cos(damped * time) + ZETA * OMEGA / damped * math.sin(damped * time))


@pytest.mark.parametrize("rho", [1.0, 0.8, 0.5, 0.0])
def test_second_order_for_every_damping(rho):
    errors = [abs(march(dt, 2.3, rho).position[0] - exact(2.3)) for dt in (0.02, 0.01, 0.005)]
    orders = [math.log2(a / b) for a, b in pairwise(errors)]
    assert orders == pytest.approx([2.0, 2.0], abs=0.15)


@pytest.mark.parametrize("rho", [1.0, 0.8, 0.5])
def test_the_fastest_oscillation_loses_its_share(rho):
    """At an endless frequency every step keeps the share ρ of the amplitude."""
    dt, omega = 1.0, 1e6
    sizes = [abs(march(dt, n * dt, rho, omega, 0.0).velocity[0]) for n in (40, 60)]
    assert (sizes[1] / sizes[0]) ** (1.0 / 20.0) == pytest.approx(rho, abs=0.06)


def test_without_damping_energy_stays():
    course = march(0.01, 5.0, 1.0, OMEGA, 0.0)
    (x,), (v,), _ = course.motion()
    assert 0.5 * v * v + 0.5 * OMEGA**2 * x * x == pytest.approx(0.5 * OMEGA**2, rel=1e-9)


def test_rounding_of_a_far_position_does_not_reach_the_speed():
    """Steps of 1 us at 10⁵ m: as a difference of positions over a step, the speed would be off by 1e-5 m/s in each."""
    far, size, dt = 1e5, 1e-2, 1e-6
    start = MotionHistory((far + size,), (0.0,), (-size * OMEGA**2,), (-size * OMEGA**2,))
    (x,), (v,), _ = follow(start, dt, 0.01, 1.0, OMEGA, 0.0, rest=far).motion()
    angle = OMEGA * 0.01
    assert x - far == pytest.approx(size * math.cos(angle), abs=1e-9)
    assert v == pytest.approx(-size * OMEGA * math.sin(angle), abs=1e-10)


def test_a_quasi_static_motion_has_the_velocity_of_its_step():
    course = quasi_static(floats, MotionHistory((1.0, 2.0), (0.0, 0.0)), 0.5)((1.0, -1.0))
    assert course.motion() == ((2.0, 1.0), (2.0, -2.0), (0.0, 0.0))
    assert predict_position(course, 0.1) == (2.0, 1.0)
