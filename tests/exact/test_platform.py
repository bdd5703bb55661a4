"""The platform with three springs: geometry, stiffness, vibration, heating, weight.

Sources of truth: closed forms of a plate on cold springs, an energy and its second derivatives by
matrices, and a root and an integral for one hot spring (`platform_reference`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import ZERO
from coil_cases import CLOSED, COIL, COLD, TURNS, WIRE, platform_law, platform_spring
from platform_cases import HEIGHT, PLATES, SIDE, about_x, about_y, by_matrices
from platform_reference import Platform

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.elements.coil_spring import CoilSpring
from martensite.actuators.mechanics.platform_kinematics import Plates, compute_length_slopes
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.base.errors import ParameterError, SolveError
from martensite.base.parameters import param
from martensite.kernels import floats
from martensite.physics.electrical.resistances import MixtureResistance
from martensite.physics.electrical.sources import VoltageSource
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.platform.workspace import compute_crosswise

MASS, GRAVITY = 0.075, 9.81
RATE = 17e9 * WIRE**4 / (8 * TURNS * COIL**3)
"""Of a cold spring [N/m]."""
INERTIA = MASS * SIDE**2 / 24
TILT = RATE * SIDE**2 / 2
"""Stiffness of the platform on three cold springs [N m/rad]."""
PORTS = ("first", "second", "third")
HOT = Constant(level=5.0)


@cache
def spring() -> CoilSpring:
    """The spring of the paper: 1 g, unloaded 15 mm hot and 60 mm cold, its resistances."""
    plain = platform_spring()
    shape = plain.wire_length() / plain.section()
    law = platform_law(eps_L=WIRE * (COLD - CLOSED) / (math.sqrt(3) * math.pi * TURNS * COIL**2))
    return platform_spring(
        density=1e-3 / (plain.section() * plain.wire_length()),
        law=law,
        resistance=MixtureResistance(rho_A=0.7246 / shape, rho_M=0.8197 / shape),
    )


def platform(
    kind: type[ParallelPlatform] = ParallelPlatform,
    film: float = 150.0,
    series: float = 0.0,
    limit: float = 1e6,
    **mechanism: Any,
) -> Machine:
    """The platform of the paper under a voltage, cooled by a film coefficient [W/(m² K)]."""
    one = Actuator(
        element=spring(),
        environment=Environment(temperature=25 + ZERO, cooling=ConstantCooling(h=film)),
        source=VoltageSource(series_resistance=series, current_limit=limit),
    )
    given: dict[str, Any] = {"side": SIDE, "height": HEIGHT, "mass": MASS, "gravity": GRAVITY}
    return Machine(mechanism=kind(**(given | mechanism)), group=Group(first=one, second=one, third=one))


class Kicked(ParallelPlatform):
    """A platform that is struck at the start. Deliberately not registered."""

    alpha_rate: Any = param("rad/s", "first rate of alpha", default=0.0)
    beta_rate: Any = param("rad/s", "first rate of beta", default=0.0)

    def init(self, xp: Any, elements: Any, elongations: Any, signals: Any) -> Any:
        memory = super().init(xp, elements, elongations, signals)
        struck = memory.course._replace(velocity=(self.alpha_rate, self.beta_rate))
        return memory._replace(course=struck)


def swing(duration: float, step: float, **changes: Any) -> Result:
    """Cold and struck, with inertia and all springs taut."""
    usual: dict[str, Any] = {"motion": "dynamic", "rho_inf": 1.0, "preload": 5.0}
    system = platform(Kicked, **(usual | changes))
    return simulate(system, {}, duration, step=step, samples=round(duration / step) + 1)


def crossings(result: Result, name: str) -> list[float]:
    """Times at which an angle passes zero upwards [s]."""
    t, q = result.times, result[name]
    return [t[i] + (t[i + 1] - t[i]) * q[i] / (q[i] - q[i + 1]) for i in range(len(t) - 1) if q[i] < 0.0 <= q[i + 1]]


def frequency(result: Result, name: str) -> float:
    """[Hz], from the zeros of an angle."""
    found = crossings(result, name)
    return (len(found) - 1) / (found[-1] - found[0])


# ---------------------------------------------------------------- geometry and stiffness


def test_lengths_that_the_paper_needs() -> None:
    """To the micrometre by an independent computation, to 1e-9 m by matrices."""
    mechanism: Any = platform().mechanism
    for degrees, millimetres in ((25, (36.009, 72.251, 72.251)), (30, (32.079, 74.534, 74.534))):
        turned = mechanism.contraction(floats, [math.radians(degrees), 0.0])
        found = [HEIGHT - shorter for shorter in turned]
        assert [1e3 * length for length in found] == pytest.approx(millimetres, abs=5e-4)
        assert found == pytest.approx(by_matrices(PLATES, about_x(math.radians(degrees))), abs=1e-9)


def test_stiffness_of_a_small_tilt_is_the_same_about_all_axes() -> None:
    _, over_alpha, over_beta = compute_length_slopes(floats, PLATES, 0.0, 0.0)
    levers = np.array([over_alpha, over_beta])
    assert levers @ levers.T * RATE == pytest.approx(TILT * np.eye(2), abs=1e-12)
    assert pytest.approx(1.162, abs=5e-4) == TILT


def test_inertia_and_joint_of_the_plate() -> None:
    """I = M s²/24 unless given."""
    made: list[Any] = [platform(inertia=i).mechanism for i in (0.0, 4e-5)]
    usual, given = (mechanism.top_plate(floats) for mechanism in made)
    assert usual.inertia == pytest.approx(3.125e-5, rel=1e-12)
    assert given.inertia == 4e-5
    off: Any = platform(eccentricity=0.02).mechanism
    assert off.plates() == Plates(SIDE, HEIGHT, HEIGHT - 0.02)
    with pytest.raises(ParameterError, match=r"`eccentricity`.*at most `height`, 60 mm"):
        platform(eccentricity=0.07)


# ---------------------------------------------------------------- vibration


@pytest.mark.parametrize("name", ["alpha", "beta"])
def test_natural_frequency(name: str) -> None:
    found = frequency(swing(0.3, 2e-4, **{f"{name}_rate": 0.1}), name)
    assert found == pytest.approx(math.sqrt(TILT / INERTIA) / (2 * math.pi), rel=3e-4)
    assert found == pytest.approx(30.7, abs=0.05)


def test_a_given_inertia_slows_it() -> None:
    found = frequency(swing(0.3, 2e-4, alpha_rate=0.1, inertia=4 * INERTIA), "alpha")
    assert found == pytest.approx(math.sqrt(TILT / INERTIA) / (4 * math.pi), rel=3e-4)


def test_damping_takes_what_it_should() -> None:
    """exp(-b t/(2 I)) between peaks that are whole periods apart."""
    b = 2e-4
    result = swing(0.2, 1e-4, alpha_rate=0.1, damping=b)
    times = crossings(result, "alpha")
    rates = [float(np.interp(t, result.times, result["alpha_rate"])) for t in times]
    expected = math.exp(-b * (times[-1] - times[0]) / (2 * INERTIA))
    assert rates[-1] / rates[0] == pytest.approx(expected, rel=2e-3)


def potential(alpha: float, beta: float, above: float, preload: float) -> float:
    """Of cold springs and weight [J]."""
    plates = Plates(SIDE, HEIGHT, HEIGHT - above)
    drawn = by_matrices(plates, about_y(beta) @ about_x(alpha)) - HEIGHT + preload / RATE
    weight = MASS * GRAVITY * above * math.cos(alpha) * math.cos(beta)
    return float(0.5 * RATE * drawn @ drawn + weight)


@pytest.mark.parametrize("above", [0.03, -0.05])
@pytest.mark.parametrize("name", ["alpha", "beta"])
def test_weight_and_preload_change_the_frequency(name: str, above: float) -> None:
    """A plate that stands above its joint is softer by M g e, one below it stiffer."""
    x = 1e-3
    at = [potential(*((y, 0.0) if name == "alpha" else (0.0, y)), above, 5.0) for y in (-x, 0.0, x)]
    stiffness = (at[0] - 2 * at[1] + at[2]) / x**2
    expected = math.sqrt(stiffness / (INERTIA + MASS * above**2)) / (2 * math.pi)
    found = swing(0.5, 5e-4, **{f"{name}_rate": 0.1}, eccentricity=above)
    assert frequency(found, name) == pytest.approx(expected, rel=1e-3)


def energies(result: Result, above: float = 0.0) -> Any:
    """Kinetic energy and that of cold springs and weight [J], at all samples."""
    alpha, beta = np.array(result["alpha"]), np.array(result["beta"])
    a, b = np.array(result["alpha_rate"]), np.array(result["beta_rate"])
    more = MASS * above**2
    spin = INERTIA + more + (INERTIA - more) * np.sin(alpha) ** 2
    kinetic = 0.5 * ((INERTIA + more) * a**2 + spin * b**2)
    elastic = sum(np.array(result[f"{port}.force"]) ** 2 for port in PORTS) / (2 * RATE)
    return kinetic, elastic + MASS * GRAVITY * above * np.cos(alpha) * np.cos(beta)


@pytest.mark.parametrize(("above", "rate"), [pytest.param(0.0, 40.0, marks=pytest.mark.slow), (0.03, 15.0)])
def test_energy_of_the_isolated_platform_stays(above: float, rate: float) -> None:
    """To second order in the step; a wrong Coriolis term would show at these rates."""
    lost: list[float] = []
    for step in (2e-4, 1e-4):
        result = swing(0.2, step, alpha_rate=rate, beta_rate=-0.75 * rate, eccentricity=above)
        kinetic, held = energies(result, above)
        assert max(map(abs, result["alpha"])) > math.radians(7)
        assert min(min(result[f"{port}.force"]) for port in PORTS) > 0.0
        total = kinetic + held
        lost.append(float(np.abs(total - total[0]).max() / kinetic[0]))
    assert lost[1] < 2e-4
    assert lost[1] < 0.3 * lost[0]


# ---------------------------------------------------------------- heating


def degrees(result: Result, name: str) -> list[float]:
    return [math.degrees(angle) for angle in result[name]]


def arrival(result: Result, angle: float) -> float:
    """Time at which α passes an angle [deg], by the parabola through three samples [s]."""
    turned = degrees(result, "alpha")
    k = next(i for i, a in enumerate(turned) if a >= angle)
    at = slice(k - 2, k + 1)
    return float(np.polyval(np.polyfit(turned[at], result.times[at], 2), angle))


@cache
def heated(volts: float, duration: float, step: float) -> Result:
    system = platform(film=68.6, series=0.594, limit=2.5)
    samples = round(duration / step) + 1
    return simulate(system, {"first": Constant(level=volts)}, duration, step=step, samples=samples)


def test_one_hot_spring_against_two_cold_ones() -> None:
    result = simulate(platform(), {"first": HOT}, 6.0, step=0.02, samples=301)
    assert result["first.martensite_fraction"][-1] == pytest.approx(0.0, abs=1e-15)
    assert degrees(result, "alpha")[-1] == pytest.approx(33.68, abs=5e-3)
    assert max(map(abs, result["beta"])) < 1e-12
    turned = result.system.mechanism.contraction(floats, [result["alpha"][-1], 0.0])
    assert 1e3 * turned[0] == pytest.approx(30.38, abs=5e-3)
    assert turned[0] == pytest.approx(Platform().contraction(0.0), abs=1e-9)


def test_heating_path() -> None:
    """It does not depend on the power: 25° at ξ = 0.344 and 76.0 °C, 30° at 0.165, 86.5 °C."""
    result = heated(5.0, 30.0, 0.02)
    for angle, fraction, temperature in ((25.0, 0.344, 76.0), (30.0, 0.165, 86.5)):
        turned, reference = degrees(result, "alpha"), Platform()
        theta = reference.theta_at(math.radians(angle))
        found = [
            float(np.interp(angle, turned, result[f"first.{name}"])) for name in ("martensite_fraction", "temperature")
        ]
        assert found == pytest.approx([fraction, temperature + ZERO], abs=0.05)
        assert found[0] == pytest.approx(math.cos(theta / 2) ** 2, abs=1e-6)
        assert found[1] - ZERO == pytest.approx(reference.temperature(theta), abs=1e-4)


def test_arrival_is_that_of_the_quadrature() -> None:
    reference = Platform(film=68.6, series=0.594, limit=2.5)
    for volts, duration in ((5.0, 30.0), (3.0, 31.0)):
        result = heated(volts, duration, 0.02)
        expected = replace(reference, volts=volts).arrival(math.radians(25.0))
        assert arrival(result, 25.0) == pytest.approx(expected, abs=1e-4)
    assert arrival(heated(5.0, 30.0, 0.02), 25.0) == pytest.approx(18.00, abs=0.01)


def test_three_equally_hot_springs_move_nothing() -> None:
    result = simulate(platform(), dict.fromkeys(PORTS, HOT), 16.0, step=0.02, samples=801)
    assert max(map(abs, [*result["alpha"], *result["beta"]])) < 1e-12
    force = 26.9e9 * WIRE**4 / (8 * TURNS * COIL**3) * (COLD - CLOSED)
    for port in PORTS:
        assert result[f"{port}.martensite_fraction"][-1] == pytest.approx(0.0, abs=1e-15)
        assert result[f"{port}.force"][-1] == pytest.approx(force, rel=1e-9)


def test_each_spring_alone_stays_on_its_ray() -> None:
    ends = {"first": (33.68, 0.0), "second": (-17.8, 28.1), "third": (-17.8, -28.1)}
    for leg, (port, end) in enumerate(ends.items()):
        result = simulate(platform(), {port: HOT}, 5.0, step=0.02, samples=251)
        assert (degrees(result, "alpha")[-1], degrees(result, "beta")[-1]) == pytest.approx(end, abs=0.05)
        for alpha, beta in zip(result["alpha"][::25], result["beta"][::25], strict=True):
            assert abs(compute_crosswise(floats, PLATES, leg, alpha, beta)) < 2e-7 * SIDE**3


# ---------------------------------------------------------------- weight


def test_torques_balance_with_weight_and_preload() -> None:
    """Springs and weight together, at every sample, by the potential of the springs' forces."""
    above = 0.03
    system = platform(eccentricity=above, preload=2.0)
    result = simulate(system, {"second": HOT}, 4.0, step=0.02, samples=41)
    plates = Plates(SIDE, HEIGHT, HEIGHT - above)
    assert degrees(result, "beta")[-1] > 20.0
    for k in range(len(result.times)):
        alpha, beta = result["alpha"][k], result["beta"][k]
        forces = np.array([result[f"{port}.force"][k] for port in PORTS])
        x = 1e-6
        over_alpha, over_beta = (
            (by_matrices(plates, ahead) - by_matrices(plates, behind)) / (2 * x)
            for ahead, behind in (
                (about_y(beta) @ about_x(alpha + x), about_y(beta) @ about_x(alpha - x)),
                (about_y(beta + x) @ about_x(alpha), about_y(beta - x) @ about_x(alpha)),
            )
        )
        weight = MASS * GRAVITY * above
        tilting = weight * math.sin(alpha) * math.cos(beta)
        assert forces @ over_alpha == pytest.approx(tilting, abs=5e-6)
        tilting = weight * math.cos(alpha) * math.sin(beta)
        assert forces @ over_beta == pytest.approx(tilting, abs=5e-6)


def test_a_heavy_plate_above_its_joint_leans_further() -> None:
    """Fully hot: the platform whose weight turns it over, upright, and hanging."""
    ends = [
        degrees(
            simulate(platform(eccentricity=0.03, gravity=g, mass=0.3), {"first": HOT}, 6.0, step=0.02, samples=61),
            "alpha",
        )[-1]
        for g in (GRAVITY, 0.0, -GRAVITY)
    ]
    assert ends[0] > ends[1] + 1.0 > ends[2] + 2.0


def test_a_plate_that_topples_is_no_result() -> None:
    """Heated, the spring that is relieved hangs slack and nothing balances the weight any more."""
    with pytest.raises(SolveError, match="not solved"):
        simulate(platform(eccentricity=0.03, mass=1.0), {"first": HOT}, 2.0, step=0.01, samples=21)


# ---------------------------------------------------------------- runtimes
