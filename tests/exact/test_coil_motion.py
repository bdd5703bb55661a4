"""Coil springs that heat and cool: against a weight, a bias spring, and two cold springs.

Sources of truth: force balance and kinetics in closed form, the energy of the rod at large
deflection, and the geometry of the platform with three springs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from builders import ZERO, example, problem_a
from coil_cases import (
    CLOSED,
    COIL,
    COLD,
    G_A,
    NUMBERS,
    TURNS,
    WIRE,
    elongation,
    force_at,
    platform_law,
    platform_spring,
    tangent,
)

from martensite.actuators.assembly import System
from martensite.actuators.elements.coil_spring import CoilSpring
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.physics.electrical.sources import CurrentSource
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.constant import Constant
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

PULSE = Step(low=0.0, high=2.5, at=1.0, until=45.0)
RATE = 100.0
"""Of the bias spring [N/m]."""
LOADS: dict[str, Any] = {"weight": DeadWeight(mass=0.3), "bias": BiasSpring(stiffness=RATE, preload=3.0)}


def system(load: str, **changes: Any) -> System:
    return System(
        element=platform_spring(**changes),
        environment=Environment(temperature=25 + ZERO, cooling=ConstantCooling(h=35.0)),
        source=CurrentSource(),
        mechanism=LOADS[load],
    )


def run(load: str, runtime: str = "floats", **changes: Any) -> Result:
    return simulate(system(load, **changes), PULSE, 160.0, step=0.1, samples=321, runtime=runtime)


def points(result: Result) -> Iterator[tuple[float, float, float, float]]:
    """Fraction, force [N], position [m] and temperature [K] of all samples."""
    names = ("martensite_fraction", "force", "position", "temperature")
    return zip(*(list(result[name]) for name in names), strict=True)


@pytest.fixture(scope="module", params=LOADS)
def load(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module", params=["small", "large"])
def deflection(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def result(load: str, deflection: str) -> Result:
    return run(load, deflection=deflection)


def test_the_spring_contracts_and_comes_back(result: Result) -> None:
    fractions = result["martensite_fraction"]
    assert not result.status.failed
    assert (fractions[0], min(fractions), fractions[-1]) == (1.0, 0.0, 1.0)
    assert result["position"][-1] == pytest.approx(0.0, abs=1e-9)
    assert result.stroke > 0.02


def test_spring_and_load_carry_the_same_force(result: Result) -> None:
    """At every sample the force belongs to the length, on the curve of the spring."""
    spring = result.system.element
    assert isinstance(spring, CoilSpring)
    start = result["force"][0]
    assembled = elongation(spring, 1.0, start)
    rate = RATE if isinstance(result.system.mechanism, BiasSpring) else 0.0
    for fraction, force, position, _ in points(result):
        expected = elongation(spring, fraction, force)
        assert assembled - position == pytest.approx(expected, abs=1e-11)
        assert force == pytest.approx(start + rate * position, rel=1e-11)


def test_stroke_of_a_weight_is_the_difference_of_two_rates() -> None:
    weight = 0.3 * 9.80665
    free = NUMBERS["eps_L"] * math.sqrt(3.0) * math.pi * TURNS * COIL**2 / WIRE
    rates = (g * WIRE**4 / (8 * TURNS * COIL**3) for g in (G_A, 17e9))
    hot, cold = (weight / rate for rate in rates)
    assert run("weight").stroke == pytest.approx(free + cold - hot, rel=1e-9)


def test_curvature_makes_the_spring_transform_hotter() -> None:
    plain, peak = run("weight"), run("weight", stress_factor="bergstraesser")
    assert peak["stress"][0] == pytest.approx(1.2 * plain["stress"][0], rel=1e-12)
    finish = [next(t for x, _, _, t in points(r) if x == 0.0) for r in (plain, peak)]
    assert finish[1] > finish[0] + 0.15 * plain["stress"][0] / NUMBERS["C_A"]
    assert peak.stroke == pytest.approx(plain.stroke, rel=1e-9)


def test_the_form_between_the_phases_matters() -> None:
    """Half transformed, a transformation stress leaves less strain than half of all."""
    stress, strain = (run("weight", law=platform_law(transformation=word)) for word in ("stress", "strain"))
    assert stress.stroke == pytest.approx(strain.stroke, rel=1e-9)
    half = [min(points(r), key=lambda p: (abs(p[0] - 0.5), p[3])) for r in (stress, strain)]
    assert half[0][0] == pytest.approx(half[1][0], abs=1e-6)
    assert half[0][2] > half[1][2] + 2e-3


# ---------------------------------------------------------------- three springs, one of them hot

SIDE, HEIGHT = 0.1, COLD
FAR, NEAR = SIDE / math.sqrt(3.0), -0.5 * SIDE / math.sqrt(3.0)
"""Of the heated spring and of the other two from the axis of rotation [m]."""


def length(angle: float, radius: float) -> tuple[float, float]:
    """Length [m] of a spring of the platform turned about X, and its slope [m/rad]."""
    sine, cosine = math.sin(angle), math.cos(angle)
    square = 2 * radius**2 * (1 - cosine) - 2 * HEIGHT * radius * sine + HEIGHT**2
    found = math.sqrt(square)
    return found, (radius**2 * sine - HEIGHT * radius * cosine) / found


def turned(spring: CoilSpring) -> tuple[float, float]:
    """Contraction [m] and angle [rad] at which a hot spring balances two cold ones."""

    def moment(angle: float) -> float:
        total = 0.0
        for radius, fraction, count in ((FAR, 0.0, 1), (NEAR, 1.0, 2)):
            drawn, slope = length(angle, radius)
            total -= count * force_at(spring, fraction, drawn) * slope
        return total

    low, high = 0.0, 1.0
    assert moment(low) > 0.0 > moment(high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if moment(middle) > 0.0 else (low, middle)
    return HEIGHT - length(low, FAR)[0], low


def test_one_hot_spring_against_two_cold_ones() -> None:
    """The platform's paper reports a complete contraction of 3 cm."""
    contraction, angle = turned(platform_spring())
    assert 1e3 * contraction == pytest.approx(30.38, abs=0.01)
    assert math.degrees(angle) == pytest.approx(33.68, abs=0.01)


def test_the_balance_at_home_is_that_of_equal_springs() -> None:
    cold = platform_spring()
    lengths = [length(0.0, radius) for radius in (FAR, NEAR)]
    assert [found for found, _ in lengths] == pytest.approx([COLD, COLD], rel=1e-15)
    assert abs(force_at(cold, 1.0, COLD)) < 2e-3
    assert tangent(cold, 1.0).free == pytest.approx(COLD - CLOSED, abs=1e-5)


# ---------------------------------------------------------------- heat


@pytest.mark.parametrize("factor", ["none", "wahl"])
def test_a_step_heats_by_the_resistance_that_is_seen(factor: str) -> None:
    """The strain of a resistance is that of the elongation, whatever stress drives the law."""
    coil = example(CoilSpring, stress_factor=factor, coil_measure="mean")
    run = simulate(problem_a(element=coil), Constant(level=2.0), 1e-4, step=1e-4, samples=2)
    warmed = coil.heat_capacity_total() * run.range("temperature")
    assert warmed > 0.0
    assert warmed == pytest.approx(0.5e-4 * sum(run["power"]), rel=1e-4)
