"""A lever between a wire and a weight: statics, geometry, dead centre, vibration.

Sources of truth: the dead weight at the same stress, closed-form statics, brute-force minima of
the energy of an elastic element, weight and spring, and the pendulum on a spring.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from builders import hanging_wire, problem_a
from elastic import REST, SURROUNDINGS, Elastic
from scipy import optimize

from martensite.actuators.assembly import System
from martensite.actuators.mechanisms.lever import Lever
from martensite.kernels import floats
from martensite.kernels.dual import compute_jacobian
from martensite.physics.electrical.sources import PowerSource, PrescribedTemperature
from martensite.signals.step import Step
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.result import Result

G = 9.80665
SOFT, SHORTER = 2e-4, 1e-3
"""Compliance of an elastic element [m/N] and its shortening per kelvin [m/K]."""
USUAL: dict[str, Any] = {"arm": 0.02, "distance": 0.08, "mass": 0.5, "weight_arm": 0.05, "weight_angle": 0.1}


def lever(**changes: Any) -> Lever:
    return Lever(**(USUAL | changes))


def elastic(mechanism: Lever) -> System:
    """An elastic element on a lever."""
    return System(
        element=Elastic(compliance=SOFT, contraction=SHORTER),
        environment=SURROUNDINGS,
        source=PrescribedTemperature(),
        mechanism=mechanism,
    )


def drawn(mechanism: Lever, millimetres: float, duration: float = 2.0, step: float = 0.02) -> Result:
    """An elastic element that gets shorter within 1 s."""
    ramp = Table(times=(0.0, 1.0, 1e3), values=(REST, REST + millimetres, REST + millimetres))
    return simulate(elastic(mechanism), ramp, duration, step=step, samples=41)


def path(mechanism: Lever, angle: float) -> float:
    """Length of the wire's path [m], by complex numbers."""
    fixed = mechanism.arm - mechanism.distance * np.exp(-1j * mechanism.wire_angle)
    return float(abs(mechanism.arm * np.exp(1j * angle) - fixed))


def energy(mechanism: Lever, angle: float, home: float, shorter: float) -> float:
    """Of element, weight and spring [J]; the element cannot push."""
    stretch = max(home + path(mechanism, angle) - mechanism.distance + shorter, 0.0)
    rise = mechanism.weight_arm * math.sin(mechanism.weight_angle + angle)
    spring = mechanism.torque * angle + 0.5 * mechanism.stiffness * angle * angle
    return 0.5 * stretch * stretch / SOFT + mechanism.mass * G * rise + spring


# ---------------------------------------------------------------- statics


@pytest.mark.parametrize("wire_angle", [0.5, 0.5 * math.pi, 2.2])
def test_it_is_assembled_in_balance(wire_angle: float) -> None:
    mechanism = lever(wire_angle=wire_angle, torque=0.05)
    expected = (0.5 * G * 0.05 * math.cos(0.1) + 0.05) / (0.02 * math.sin(wire_angle))
    assert mechanism.start_forces(floats) == pytest.approx([expected], rel=1e-14)
    result = drawn(mechanism, 0.0)
    assert np.abs(result["angle"]).max() < 1e-12
    assert result["force"] == pytest.approx([expected] * 41, rel=1e-12)


@pytest.mark.parametrize("wire_angle", [0.5, 1.2, 0.5 * math.pi, 2.2])
def test_the_arm_of_the_wire_is_that_of_the_figure(wire_angle: float) -> None:
    """Perpendicular distance of pivot and wire, from the corners of the triangle."""
    mechanism = lever(wire_angle=wire_angle)
    for angle in (-0.4, 0.0, 0.3, 0.7):
        (short,), ((arm,),) = compute_jacobian(floats, mechanism.contraction, [angle])
        tip = 0.02 * np.exp(1j * angle)
        wire = 0.02 - 0.08 * np.exp(-1j * wire_angle) - tip
        assert short == pytest.approx(0.08 - path(mechanism, angle), abs=1e-15)
        assert arm == pytest.approx((np.conj(tip) * wire).imag / abs(wire), rel=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"wire_angle": 1.0},
        {"wire_angle": 2.2, "stiffness": 0.2, "torque": 0.05},
        {"weight_angle": -0.6, "distance": 0.03},
    ],
)
@pytest.mark.parametrize("millimetres", [3.0, 9.0])
def test_it_rests_at_the_least_energy(changes: dict[str, Any], millimetres: float) -> None:
    mechanism = lever(**changes)
    home = SOFT * mechanism.start_forces(floats)[0]
    result = drawn(mechanism, millimetres)
    found: Any = optimize.minimize_scalar(
        lambda q: energy(mechanism, q, home, 1e-3 * millimetres),
        bounds=(-0.5, 0.95),
        method="bounded",
        options={"xatol": 1e-12},
    )
    assert result["angle"][-1] == pytest.approx(found.x, abs=2e-7)
    assert 0.05 < found.x < 0.9
    rise = math.sin(mechanism.weight_angle + found.x) - math.sin(mechanism.weight_angle)
    assert result["lift"][-1] == pytest.approx(0.05 * rise, abs=1e-8)


# ---------------------------------------------------------------- beside a dead weight


def test_for_small_angles_it_is_a_dead_weight_with_the_ratio_of_the_arms() -> None:
    """Arms of 2 m and 5 m, a wire of 0.25 m: angles below 5 mrad."""
    ratio = 2.5
    mechanism = Lever(arm=2.0, distance=100.0, mass=0.4, weight_arm=5.0)
    by_lever = problem_a(
        element=hanging_wire().element,
        environment=hanging_wire().environment,
        source=PowerSource(),
        mechanism=mechanism,
    )
    straight = hanging_wire(mass=0.4 * ratio)
    pulse = Step(low=0.0, high=5.0, at=1.0, until=8.0)
    one, other = (simulate(system, pulse, 20.0, step=0.02, samples=201) for system in (by_lever, straight))
    assert min(one["martensite_fraction"]) == 0.0
    for name in ("temperature", "martensite_fraction", "stress"):
        assert one[name] == pytest.approx(other[name], rel=1e-4, abs=1e-4), name
    assert np.array(one["lift"]) == pytest.approx(ratio * np.array(other["position"]), abs=2e-6)
    assert max(one["lift"]) > 0.02
    assert max(one["angle"]) < 5.5e-3


# ---------------------------------------------------------------- dead centre and stops


@pytest.mark.parametrize("changes", [{}, {"wire_angle": 0.4}, {"wire_angle": 2.5}, {"distance": 0.01}])
def test_the_dead_centre_is_where_the_path_is_shortest(changes: dict[str, float]) -> None:
    mechanism = lever(**changes)
    found: Any = optimize.minimize_scalar(lambda q: path(mechanism, q), bounds=(0.0, 3.1), method="bounded")
    assert mechanism.dead_centre() == pytest.approx(found.x, abs=1e-5)


def test_a_dead_centre_within_the_stops_is_a_caution() -> None:
    assert lever().cautions() == []
    (caution,) = lever(highest=1.5).cautions()
    assert "dead centre at 1.326 rad" in caution


def test_a_wire_cannot_pull_it_over_the_dead_centre() -> None:
    """It comes to rest before it, where all tension is across the pivot, and the step is solved."""
    mechanism = lever(highest=3.0, mass=0.02, weight_angle=0.0)
    result = drawn(mechanism, 40.0, step=0.005)
    end = result["angle"][-1]
    assert not result.status.failed
    assert 0.98 * mechanism.dead_centre() < end < mechanism.dead_centre()
    home = SOFT * mechanism.start_forces(floats)[0]
    stretch = home + path(mechanism, end) - mechanism.distance + 0.04
    assert result["force"][-1] == pytest.approx(stretch / SOFT, rel=1e-9)


def test_the_upper_stop_takes_what_the_weight_does_not() -> None:
    mechanism = lever(highest=0.3, stop=500.0)
    result = drawn(mechanism, 15.0)
    angle, force = result["angle"][-1], result["force"][-1]
    (_,), ((arm,),) = compute_jacobian(floats, mechanism.contraction, [angle])
    weight = 0.5 * G * 0.05 * math.cos(0.1 + angle)
    assert 0.3 < angle < 0.32
    assert 500.0 * (angle - 0.3) == pytest.approx(force * arm - weight, rel=1e-9)


def test_the_lower_stop_carries_the_weight_when_the_wire_is_slack() -> None:
    mechanism = lever(lowest=-0.2, stop=500.0)
    result = drawn(mechanism, -20.0)
    angle = result["angle"][-1]
    assert result["force"][-1] == 0.0
    weight = 0.5 * G * 0.05 * math.cos(0.1 + angle)
    assert 500.0 * (-0.2 - angle) == pytest.approx(weight, rel=1e-10)


# ---------------------------------------------------------------- vibration


def test_it_vibrates_as_a_pendulum_on_a_spring() -> None:
    """ω² = V''/(J + m b²) with the energy V of element, weight and spring where it rests."""
    mechanism = lever(motion="dynamic", rho_inf=0.95, stiffness=0.3, inertia=2e-4)
    system = elastic(mechanism)
    kick = Step(low=REST, high=REST + 0.05, at=0.05)
    result = simulate(system, kick, 1.05, step=5e-4, samples=2101)
    angle, rate = np.array(result["angle"]), np.array(result["angle_rate"])
    tops = np.flatnonzero((rate[:-1] > 0.0) & (rate[1:] <= 0.0))
    times = np.array(result.times)
    when = times[tops] + rate[tops] / (rate[tops] - rate[tops + 1]) * 5e-4
    omega = 2.0 * math.pi / np.diff(when).mean()
    still = 0.5 * (angle[tops[0]] + angle[times > 0.05].min())
    home = SOFT * mechanism.start_forces(floats)[0]
    h = 1e-4
    bent = [energy(mechanism, still + k * h, home, 0.05e-3) for k in (-1, 0, 1)]
    rigid = (bent[0] - 2.0 * bent[1] + bent[2]) / (h * h)
    assert len(tops) > 5
    assert omega == pytest.approx(math.sqrt(rigid / (2e-4 + 0.5 * 0.05**2)), rel=2e-3)
    assert angle[-400:].max() - still == pytest.approx(angle[tops[0]] - still, rel=0.03)
