"""Finger: geometry, springs, friction and stops in closed form; motion, energy and order.

Source of truth: points and distances in the plane, energies whose slopes the torques are, the
frequency of a mass on springs, and roots of the balance found by SciPy. The angles of the full
stroke were computed for this project.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import FunctionWaveform, plain_law
from finger import DURATION, NUMBERS, finger, finger_law, joint, trapezoid
from scipy.optimize import brentq

from martensite.actuators.assembly import State, System
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanics.motion import Motion, MotionHistory
from martensite.actuators.mechanisms.finger import Finger
from martensite.actuators.mechanisms.joints import bowstring_arm
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.kernels.nested import flatten_numbers
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_system
from martensite.simulate.result import Result

G, K, PULLED = 10.6e-3, 50.0, 1e-3
SECTION = 0.25 * math.pi * 0.1e-3**2
FULL = {1.5: 92.75, 3.5: 75.44, 5.5: 62.19}
"""Angle [deg] of the whole stroke for r [mm], a = 8 mm."""
COLD_STRESS = {1.5: 17.0e6, 3.5: 7.3e6, 5.5: 4.6e6}
ANGLES = np.radians([-20.0, 0.0, 1.0, 30.0, 90.0, 120.0])
OFFSETS = pytest.mark.parametrize("r", FULL)
SPRINGS = pytest.mark.parametrize("spring", ["follower", "fixed"])


def slope(function: Any, x: float, h: float = 1e-3) -> float:
    """Derivative by central differences of fourth order."""
    near, far = function(x + h) - function(x - h), function(x + 2 * h) - function(x - 2 * h)
    return (8.0 * near - far) / (12.0 * h)


def shortened(mechanism: Finger, angle: float) -> float:
    """How much shorter the path of the wire is [m]."""
    (found,) = mechanism.contraction(floats, [angle])
    return found


def lever(mechanism: Finger, angle: float) -> float:
    """n m [m]."""
    return mechanism.passes * bowstring_arm(floats, angle, mechanism.offset, mechanism.bracket)


# ---------------------------------------------------------------- geometry


@OFFSETS
def test_the_path_is_the_distance_between_the_holes(r: float) -> None:
    mechanism, near = joint(1e-3 * r), np.array([-G, -1e-3 * r])
    for angle in np.linspace(0.0, 2.0 * math.atan2(G, 1e-3 * r), 7):
        c, s = math.cos(angle), math.sin(angle)
        far = np.array([G * c - 1e-3 * r * s, -G * s - 1e-3 * r * c])  # turned towards the other
        apart = float(np.linalg.norm(far - near))
        assert shortened(mechanism, angle) == pytest.approx(2.0 * (2.0 * G - apart), abs=1e-15)


@OFFSETS
def test_the_moment_arm_is_the_slope_of_the_path(r: float) -> None:
    mechanism = joint(1e-3 * r)
    assert lever(mechanism, 0.0) == 2e-3 * r
    for angle in ANGLES:
        found = slope(lambda x: shortened(mechanism, x), float(angle))
        assert lever(mechanism, float(angle)) == pytest.approx(found, rel=1e-9)


@OFFSETS
def test_brackets_meet_and_then_press(r: float) -> None:
    mechanism, met = joint(1e-3 * r), 2.0 * math.atan2(G, 1e-3 * r)
    assert shortened(mechanism, met) == pytest.approx(4.0 * G, rel=1e-14)
    assert mechanism.stops(floats, met - 1e-6) == 0.0
    assert mechanism.stops(floats, min(met + 1e-4, 2.99)) == pytest.approx(mechanism.stop * 1e-4, rel=1e-3)


# ---------------------------------------------------------------- springs


def stored(mechanism: Finger, angle: float) -> float:
    """Energy of the return spring [J], from the distance of its ends."""
    a = mechanism.arm
    if mechanism.spring == "follower":
        return 0.5 * K * (PULLED + a * angle) ** 2
    length = math.hypot(a * math.cos(angle) - a, -a * math.sin(angle) - mechanism.height)
    return 0.5 * K * (length - mechanism.height + PULLED) ** 2


@SPRINGS
@pytest.mark.parametrize("arm", [6e-3, 25e-3])
def test_torques_are_slopes_of_the_energy(spring: str, arm: float) -> None:
    mechanism = joint(arm=arm, spring=spring)
    for angle in ANGLES:
        found = slope(lambda x: stored(mechanism, x), float(angle))
        torque = mechanism.spring_torque(floats, float(angle))
        assert torque == pytest.approx(found, rel=1e-9, abs=1e-12)
    assert mechanism.spring_torque(floats, 0.0) == pytest.approx(K * arm * PULLED, rel=1e-14)


def test_a_fixed_spring_pulls_over_centre() -> None:
    """Beyond 97 degrees at a = 6 mm and H = 50 mm."""
    mechanism = joint(arm=6e-3, spring="fixed", height=50e-3)
    centre = math.pi - math.atan(50.0 / 6.0)
    assert math.degrees(centre) == pytest.approx(96.8, abs=0.1)
    before, beyond = (mechanism.spring_torque(floats, centre + d) for d in (-1e-3, 1e-3))
    assert before > 0.0 > beyond


def test_springs_agree_where_the_fixed_end_is_far() -> None:
    near, far = (joint(spring="fixed", height=h) for h in (0.05, 10.0))
    follower = joint()
    for angle in (0.1, 0.3):
        # pulled along its first direction, it acts at the arm a cos θ with the way a sin θ
        drawn = K * 8e-3 * math.cos(angle) * (PULLED + 8e-3 * math.sin(angle))
        assert far.spring_torque(floats, angle) == pytest.approx(drawn, rel=2e-3)
        torques = [m.spring_torque(floats, angle) for m in (near, follower)]
        assert torques[0] == pytest.approx(torques[1], rel=0.1)


def test_stops_out_of_order_are_refused() -> None:
    with pytest.raises(ParameterError, match="lowest"):
        joint(lowest=0.1)
    with pytest.raises(ParameterError, match="highest"):
        joint(highest=-0.1)


# ---------------------------------------------------------------- at rest


@pytest.mark.parametrize(
    "options",
    [{}, {"spring": "fixed"}, {"friction": 0.2}, {"motion": "dynamic"}],
    ids=["follower", "fixed", "friction", "dynamic"],
)
def test_nothing_moves_where_nothing_heats(options: dict[str, Any]) -> None:
    system = finger(finger_law("mas-hybrid"), **options)
    run = simulate(system, Constant(level=0.0), 5.0, step=0.1, samples=11)
    assert np.abs(run["angle"]).max() < 1e-12
    torque = K * 8e-3 * PULLED
    assert run["force"] == pytest.approx([torque / 7e-3] * 11, rel=1e-9)


@OFFSETS
def test_stress_of_the_cold_finger(r: float) -> None:
    (force,) = joint(1e-3 * r).start_forces(floats)
    assert force / SECTION == pytest.approx(COLD_STRESS[r], rel=0.01)


# ---------------------------------------------------------------- the stroke


@cache
def cycle(offset: float = 3.5e-3, **changes: Any) -> Result:
    """The trapezoid of 2 W; force and angle belong to the end of every step."""
    system = finger(finger_law("mas-hybrid"), offset, **changes)
    return simulate(system, trapezoid(), DURATION, step=0.02, samples=1251)


def at(run: Result, name: str, time: float) -> float:
    """A column at a time [s]."""
    return float(np.interp(time, run.times, run[name]))


@OFFSETS
def test_the_full_stroke_is_a_root_of_the_geometry(r: float) -> None:
    """ΔL(θ) = L₀ (ε₀ - σ/E_A), with the stress that the spring asks for."""
    mechanism = joint(1e-3 * r)

    def stress(angle: float) -> float:
        return K * 8e-3 * (PULLED + 8e-3 * angle) / (lever(mechanism, angle) * SECTION)

    cold = NUMBERS["eps_T"] + stress(0.0) / NUMBERS["E_M"]

    def missing(angle: float) -> float:
        strain = cold - stress(angle) / NUMBERS["E_A"]
        return shortened(mechanism, angle) - 0.44 * strain

    root: Any = brentq(missing, 0.1, 2.0, xtol=1e-14)
    assert math.degrees(root) == pytest.approx(FULL[r], abs=0.005)
    run = cycle(1e-3 * r)
    assert at(run, "angle", 13.0) == pytest.approx(root, abs=1e-8)
    assert run["angle"][-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("options", [{}, {"spring": "fixed"}], ids=["follower", "fixed"])
def test_wire_and_spring_balance_at_every_sample(options: dict[str, Any]) -> None:
    run, mechanism = cycle(**options), joint(**options)
    for angle, force in zip(run["angle"][::25], run["force"][::25], strict=True):
        torque = mechanism.spring_torque(floats, angle)
        assert force * lever(mechanism, angle) == pytest.approx(torque, rel=1e-6)


# ---------------------------------------------------------------- friction


def share(mechanism: Finger, angle: float, rate: float) -> float:
    """η."""
    (found,) = mechanism.transmission(floats, Motion((angle,), (rate,), (0.0,)))
    return found


@pytest.mark.parametrize(("mu", "factor"), [(0.1, 1.17), (0.15, 1.27), (0.2, 1.37)])
def test_tensions_there_and_back_differ_by_the_capstan_factor(mu: float, factor: float) -> None:
    """At 90 degrees; each of two brackets is wrapped by half of it, one is passed each way."""
    mechanism, right = joint(friction=mu), 0.5 * math.pi
    pulling, yielding = (share(mechanism, right, rate) for rate in (1.0, -1.0))
    assert pulling == pytest.approx(math.exp(-mu * math.pi / 4.0), rel=1e-12)
    assert yielding / pulling == pytest.approx(factor, abs=0.005)
    assert share(mechanism, right, 0.0) == share(mechanism, 0.0, 1.0) == 1.0
    assert share(mechanism, -right, 1.0) == pulling


def test_a_moving_finger_loses_the_share_of_friction() -> None:
    """Where it moves ten times as fast as friction takes to change sign."""
    run, free = cycle(friction=0.2), joint()
    angles, forces = np.array(run["angle"]), np.array(run["force"])
    rates = np.diff(angles, prepend=0.0) / np.diff(run.times, prepend=-0.02)
    for sign in (1.0, -1.0):
        moving = np.flatnonzero(sign * rates > 10.0 * free.friction_rate)
        assert len(moving) > 10
        for angle, force in zip(angles[moving], forces[moving], strict=True):
            kept = free.spring_torque(floats, angle) / (force * lever(free, angle))
            assert kept == pytest.approx(math.exp(-sign * 0.1 * angle), rel=1e-4)


def test_friction_widens_the_loop() -> None:
    """Half of the angle is reached hotter and left colder, by σ sinh(μ θ/2)/s and a little more."""
    rough, free = (
        {
            way: float(np.interp(0.65, np.array(run["angle"])[part], np.array(run["temperature"])[part]))
            for way, part in (("up", slice(0, 500)), ("down", slice(None, 650, -1)))
        }
        for run in (cycle(friction=0.2), cycle())
    )
    torque = joint().spring_torque(floats, 0.65)
    shift = torque / (lever(joint(), 0.65) * SECTION) * math.sinh(0.065) / 4e6
    assert 0.2 < shift < 1.0
    assert rough["up"] - free["up"] == pytest.approx(shift, rel=0.15)
    assert free["down"] - rough["down"] == pytest.approx(shift, rel=0.15)


# ---------------------------------------------------------------- one-sided: stops and slack


def test_an_end_stop_holds() -> None:
    limit = math.radians(50.0)
    run, mechanism = cycle(highest=limit), joint()
    angle, force = at(run, "angle", 13.0), at(run, "force", 13.0)
    past = force * lever(mechanism, angle) - mechanism.spring_torque(floats, angle)
    assert angle - limit == pytest.approx(past / mechanism.stop, rel=1e-6)
    assert 1e-4 < angle - limit < 2e-3
    assert force > 2.0 * at(cycle(), "force", 13.0)


def test_brackets_that_meet_hold_too() -> None:
    """Short ones: the wire could shorten by twice what they allow."""
    run, met = cycle(0.5e-3, bracket=2e-3, stiffness=10.0), 2.0 * math.atan2(2e-3, 0.5e-3)
    mechanism = joint(0.5e-3, bracket=2e-3, stiffness=10.0)
    angle, force = max(run["angle"]), max(run["force"])
    balance = mechanism.spring_torque(floats, angle) / lever(mechanism, angle)
    assert met < angle < met + 1e-3
    assert force > 2.0 * balance


def test_a_wire_cannot_push() -> None:
    """Assembled hot and cooled, a wire of one martensite gets longer than the finger can follow."""
    limit = math.radians(-5.0)
    element = Wire(
        diameter=0.1e-3,
        length=0.44,
        density=6500.0,
        heat_capacity=500.0,
        initial_fraction=0.0,
        law=plain_law(),
        resistance=PerLengthResistance(r_A=125.0, r_M=125.0),
    )
    system = finger(lowest=limit).with_parts(element=element, source=PrescribedTemperature())
    wave = FunctionWaveform(function=lambda t: 400.0 - 10.0 * t)
    run = simulate(system, wave, 12.0, step=0.05, samples=121)
    end, mechanism = run["angle"][-1], joint()
    assert run["force"][-1] == 0.0 < run["force"][0]
    held = mechanism.spring_torque(floats, end) + mechanism.stop * (end - limit)
    assert held == pytest.approx(0.0, abs=1e-12)
    assert end < limit
    assert run["strain"][-1] > run["strain"][0] + 0.03


# ---------------------------------------------------------------- with inertia

J = 1.8e-5


def frozen(**changes: Any) -> System:
    """A finger whose wire stays cold and elastic."""
    element = Wire(
        diameter=0.1e-3,
        length=0.44,
        density=6500.0,
        heat_capacity=500.0,
        law=plain_law(E_A=28e9),
        resistance=PerLengthResistance(r_A=125.0, r_M=125.0),
    )
    environment = Environment(temperature=295.0, cooling=ConstantCooling(h=200.0))
    return finger(motion="dynamic", inertia=J, **changes).with_parts(element=element, environment=environment)


def natural(system: System) -> float:
    """Circular frequency [rad/s] of small oscillations about angle zero.

    k a² + κ (n r)² - n F₀ g/2 over J, with κ = E A/L of the wire and F₀ its tension: as the
    finger bends its moment arm grows, by g/2 per angle.
    """
    mechanism: Any = system.mechanism
    (force,) = mechanism.start_forces(floats)
    taut = 28e9 * SECTION / 0.44 * lever(mechanism, 0.0) ** 2
    return math.sqrt((K * mechanism.arm**2 + taut - force * G) / J)


def swinging(system: System, rate: float, dt: float, count: int) -> np.ndarray:
    """Angle and rate over steps of dt [s], from angle zero with a rate [rad/s]."""
    compiled, state = compile_system(system), system.init(floats, 0.0)
    functions = compiled.program.bind_floats(*compiled.values(system))
    course = MotionHistory((0.0,), (rate,), (0.0,), (0.0,))
    numbers = flatten_numbers(State(state.elements, state.mechanism._replace(course=course)))
    names, found = list(system.outputs()), [(0.0, rate)]
    places = [names.index(name) for name in ("angle", "angle_rate")]
    for _ in range(count):
        numbers = functions["step"](*numbers, 0.0, dt)[: compiled.size]
        outputs = functions["observe"](*numbers, 0.0)
        found.append((outputs[places[0]], outputs[places[1]]))
    return np.array(found)


def test_frequency_of_an_elastic_finger() -> None:
    system = frozen(rho_inf=1.0)
    omega, rate = natural(system), 1e-6
    period = 2.0 * math.pi / omega
    assert 0.1 < period < 0.3
    angle, speed = swinging(system, rate, period / 400, 400).T
    times = np.arange(401) * period / 400
    assert angle == pytest.approx(rate / omega * np.sin(omega * times), abs=3e-4 * rate / omega)
    assert speed == pytest.approx(rate * np.cos(omega * times), abs=3e-4 * rate)


def test_damping_lets_it_fade() -> None:
    """A quarter of the critical damping: amplitude falls by exp(-π b/(J ω_d)) in half a turn."""
    omega = natural(frozen())
    damping = 0.5 * J * omega
    system, half = frozen(damping=damping, rho_inf=1.0), math.pi / (omega * math.sqrt(1.0 - 1 / 16))
    angle, _ = swinging(system, 1e-6, half / 400, 800).T
    first, second = np.abs(angle[:400]).max(), np.abs(angle[400:]).max()
    assert second / first == pytest.approx(math.exp(-damping * half / (2.0 * J)), rel=1e-3)


def test_mechanical_energy_stays() -> None:
    """A large swing, in which the moment arm changes and the wire stays taut."""
    system = frozen(rho_inf=1.0)
    mechanism: Any = system.mechanism
    (force,) = mechanism.start_forces(floats)
    stiffness = 28e9 * SECTION / 0.44
    angle, speed = swinging(system, 0.4, 2e-4, 3000).T

    def energy(x: float, v: float) -> float:
        tension = force - stiffness * shortened(mechanism, x)
        assert tension > 0.0
        return 0.5 * J * v * v + stored(mechanism, x) + 0.5 * tension**2 / stiffness

    found = np.array([energy(x, v) for x, v in zip(angle, speed, strict=True)])
    assert np.abs(angle).max() > 5e-3
    assert np.ptp(found) < 1e-4 * 0.5 * J * 0.4**2


# ---------------------------------------------------------------- energy, order


def test_work_of_the_wire_is_energy_of_the_spring() -> None:
    run, mechanism = cycle(1.5e-3), joint(1.5e-3)
    top = int(np.argmax(run["angle"])) + 1
    ways = [shortened(mechanism, x) for x in run["angle"][:top]]
    work = float(np.trapezoid(run["force"][:top], ways))
    gained = stored(mechanism, max(run["angle"])) - stored(mechanism, 0.0)
    assert work == pytest.approx(gained, rel=1e-4)
