"""The hand: twelve elements, six joints, three fingers that do not know of each other.

Sources of truth: a single joint between two elements written anew, roots of the statics of one
and of two joints, the heat balance of every element, and the double pendulum of two rods in
absolute angles by another solver.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import builders
import numpy as np
import pytest
from builders import wire_a
from elastic import kelvins, machine
from scipy import integrate, optimize

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.elements.rows import Bundle
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import Column
from martensite.actuators.mechanisms.hand import FINGERS, JOINTS, Hand
from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.laws.brinson import Brinson
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.constant import Constant
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_system
from martensite.simulate.result import Result

GEOMETRY: dict[str, Any] = {"offset": 5e-3, "bracket": 4e-3, "knuckle": 7e-3, "preload": 0.5, "highest": 1.2}
ANGLES = [f"{finger}_{joint}" for finger in FINGERS for joint in JOINTS]
COLD = Environment(temperature=275.0, cooling=ConstantCooling(h=150.0))
"""Colder than the finish of martensite."""
STEP = 0.05


def hand(**changes: Any) -> Hand:
    return Hand(**(GEOMETRY | changes))


@cache
def bundle(oriented: float) -> Actuator:
    """Two wires of 0.15 mm and 0.2 m, cold; those that are twinned are short."""
    law = builders.example(Brinson)
    wire = wire_a(law, diameter=0.15e-3, length=0.2, latent_heat=0.0, initial_oriented=oriented)
    element = Bundle(strand=wire, count=2.0)
    return Actuator(element=element, environment=COLD, source=PowerSource())


def manned(mechanism: AbstractMultibody) -> Machine:
    """A mechanism with long flexors and short extensors."""
    members = {p: bundle(1.0 if p.endswith("flexor") else 0.0) for p in mechanism.ports()}
    return Machine(mechanism=mechanism, group=Group(**members))


def pulse(begin: float, watts: float = 1.6) -> Table:
    """Power for 2.5 s."""
    times = (0.0, begin, begin + 0.2, begin + 2.5, begin + 2.7, 100.0)
    return Table(times=times, values=(0.0, 0.0, watts, watts, 0.0, 0.0))


def run(drives: dict[str, Any], duration: float = 5.0, **changes: Any) -> Result:
    """A hand with real wires."""
    samples = round(duration / STEP) + 1
    return simulate(manned(hand(**changes)), drives, duration, step=STEP, samples=samples)


def column(result: Result, name: str) -> np.ndarray:
    return np.array(result[name])


# ---------------------------------------------------------------- twelve powers, six joints


def test_it_has_twelve_ports_and_six_angles() -> None:
    ports = hand().ports()
    assert len(ports) == 12
    assert ports[:4] == (
        "thumb_proximal_flexor",
        "thumb_proximal_extensor",
        "thumb_distal_flexor",
        "thumb_distal_extensor",
    )
    assert [c.name for c in hand().coordinates()] == ANGLES


def test_every_element_has_a_power_of_its_own() -> None:
    """Steady temperatures under twelve powers, too low to transform anything."""
    watts = {port: 0.01 * (k + 1) for k, port in enumerate(hand().ports())}
    result = run({port: Constant(level=w) for port, w in watts.items()}, 20.0)
    surface = 2.0 * math.pi * 0.15e-3 * 0.2
    for port, w in watts.items():
        assert result[f"{port}.power"][-1] == pytest.approx(w, rel=1e-12)
        warmer = result[f"{port}.temperature"][-1] - 275.0
        assert warmer == pytest.approx(w / (150.0 * surface), rel=1e-6)


def test_a_passing_flexor_bends_both_joints_of_its_finger() -> None:
    result = run({"index_distal_flexor": pulse(0.5)}, tendons="passing")
    assert column(result, "index_proximal").max() > 0.1
    assert column(result, "index_distal").max() > 0.1
    for name in ANGLES:
        if not name.startswith("index"):
            assert np.abs(column(result, name)).max() < 1e-12, name


@pytest.mark.parametrize("tendons", [pytest.param("separate", marks=pytest.mark.slow), "passing"])
def test_fingers_do_not_know_of_each_other(tendons: str) -> None:
    """Each moves alone as it moves together with others that have other powers."""
    together = {
        f"{finger}_{joint}_flexor": pulse(0.3 + 0.4 * k, 1.4 + 0.2 * k)
        for k, finger in enumerate(FINGERS)
        for joint in JOINTS
    }
    all_three = run(together, 3.5, tendons=tendons)
    for finger in FINGERS:
        own = {p: w for p, w in together.items() if p.startswith(finger)}
        alone = run(own, 3.5, tendons=tendons)
        for joint in JOINTS:
            name = f"{finger}_{joint}"
            assert column(alone, name).max() > 0.05
            assert column(all_three, name) == pytest.approx(column(alone, name), abs=1e-6)


def test_the_antagonist_opens_what_the_protagonist_closed() -> None:
    drives = {"index_proximal_flexor": pulse(0.5), "index_proximal_extensor": pulse(6.0)}
    result = run(drives, 12.0)
    bent = column(result, "index_proximal")
    closed, kept, opened = (bent[round(t / STEP)] for t in (3.0, 6.0, 8.5))
    assert closed > 1.1
    assert 0.9 * closed < kept < closed  # nothing but the extensor draws it back
    assert opened < 0.1 * closed
    oriented = column(result, "index_proximal_extensor.oriented_fraction")
    assert (oriented[0], oriented[round(6.0 / STEP)] > 0.5) == (0.0, True)


# ---------------------------------------------------------------- one joint, written anew


class Joint(AbstractMultibody):
    """One joint between a flexor and an extensor. Deliberately not registered."""

    stiffness: Number = param("N*m/rad", "joint spring", default=0.0)

    def ports(self) -> tuple[str, ...]:
        return ("flexor", "extensor")

    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate("bent", "rad", "angle", "θ", 1.0),)

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """From the straight distance of the holes, by the law of cosines."""
        angle = position[0]
        r, g = GEOMETRY["offset"], GEOMETRY["bracket"]
        c, s = xp.cos(angle), xp.sin(angle)
        across, along = -r * s + g * (c + 1.0), r * (1.0 - c) - g * s
        apart = xp.sqrt(across * across + along * along)
        return [2.0 * g - apart, -GEOMETRY["knuckle"] * angle]

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        past = xp.maximum(motion.position[0] - GEOMETRY["highest"], 0.0)
        past = past + xp.minimum(motion.position[0], 0.0)
        return [self.stiffness * motion.position[0] + 10.0 * past]

    def start_forces(self, xp: Namespace) -> Column:
        one = GEOMETRY["preload"]
        return [one, one * GEOMETRY["offset"] / GEOMETRY["knuckle"]]


@pytest.mark.parametrize("stiffness", [pytest.param(0.0, marks=pytest.mark.slow), 0.02])
def test_a_joint_of_the_hand_is_a_joint_alone(stiffness: float) -> None:
    drives = {"flexor": pulse(0.5), "extensor": pulse(3.6)}
    alone = simulate(manned(Joint(stiffness=stiffness)), drives, 6.0, step=STEP, samples=121)
    in_hand = {f"middle_distal_{side}": wave for side, wave in drives.items()}
    result = run(in_hand, 6.0, stiffness=stiffness)
    assert np.ptp(column(alone, "bent")) > 0.8
    assert column(result, "middle_distal") == pytest.approx(column(alone, "bent"), abs=1e-6)
    for port in ("flexor", "extensor"):
        for name in ("force", "temperature", "martensite_fraction", "oriented_fraction"):
            expected = column(alone, f"{port}.{name}")
            found = column(result, f"middle_distal_{port}.{name}")
            assert found == pytest.approx(expected, rel=1e-5, abs=1e-6), name


# ---------------------------------------------------------------- statics with elastic elements

SOFT = 5e-4


def drawn(shortened: dict[str, float], **changes: Any) -> Result:
    """Elastic elements that get shorter by so many millimetres within 1 s."""
    system = machine(hand(**changes), compliance=SOFT, contraction=1e-3)
    return simulate(system, kelvins(system, **shortened), 1.5, step=0.05, samples=4)


def torques(mechanism: Hand, angles: np.ndarray, millimetres: dict[str, float]) -> np.ndarray:
    """Torque that elements and springs leave over in the joints of the index finger [N m]."""
    r, g, rho = (mechanism.index * n for n in (mechanism.offset, mechanism.bracket, mechanism.knuckle))
    start = mechanism.start_forces(floats)[4:8]
    bow = 2.0 * (r * np.sin(0.5 * angles) + g * (1.0 - np.cos(0.5 * angles)))
    arm = r * np.cos(0.5 * angles) + g * np.sin(0.5 * angles)
    paths = [bow[0], -rho * angles[0], bow[1], -rho * angles[1]]
    if mechanism.tendons == "passing":
        paths[2] = bow[0] + bow[1]
    names = [f"index_{joint}_{side}" for joint in JOINTS for side in ("flexor", "extensor")]
    force = [
        max(f + (1e-3 * millimetres.get(name, 0.0) - path) / SOFT, 0.0)
        for f, path, name in zip(start, paths, names, strict=True)
    ]
    over = np.array([force[0] * arm[0] - force[1] * rho, force[2] * arm[1] - force[3] * rho])
    if mechanism.tendons == "passing":
        over[0] += force[2] * arm[0]
    return over - mechanism.torque - mechanism.stiffness * angles


@pytest.mark.parametrize("size", [1.0, 1.3])
@pytest.mark.parametrize("tendons", ["separate", "passing"])
@pytest.mark.parametrize(
    "millimetres",
    [
        {"index_distal_flexor": 3.0},
        {"index_proximal_flexor": 4.0, "index_distal_extensor": -8.0},
        {"index_proximal_flexor": 2.0, "index_distal_flexor": 5.0, "index_distal_extensor": -1.0},
    ],
)
def test_it_rests_where_nothing_is_left_over(millimetres: dict[str, float], tendons: str, size: float) -> None:
    changes = {"tendons": tendons, "torque": 1e-3, "stiffness": 0.02, "index": size, "lowest": -1.0}
    result = drawn(millimetres, **changes)
    mechanism = hand(**changes)
    found = optimize.root(lambda q: torques(mechanism, q, millimetres), [0.2, 0.2], tol=1e-12).x
    assert [result[f"index_{joint}"][-1] for joint in JOINTS] == pytest.approx(found, abs=1e-8)
    assert np.abs(found).max() > 0.1
    assert abs(result["thumb_proximal"][-1]) < 1e-12


def test_preload_and_springs_are_in_balance_at_assembly() -> None:
    for tendons in ("separate", "passing"):
        mechanism = hand(tendons=tendons, torque=1.5e-3, thumb=0.7)
        home, forces = [0.0] * 6, mechanism.start_forces(floats)
        assert mechanism.supply(floats, home, forces, home) == pytest.approx([1.5e-3] * 6, rel=1e-12)
        assert forces[::2] == [0.5] * 6


def test_extensors_cannot_push_at_assembly() -> None:
    with pytest.raises(ParameterError, match=r"`preload` of `hand` must be at least 0\.8"):
        hand(torque=4e-3)
    assert hand(torque=4e-3, preload=0.81).preload == 0.81


def test_brackets_that_meet_before_the_stop_are_a_caution() -> None:
    assert hand(highest=1.34).cautions() == []
    (caution,) = hand(highest=1.36).cautions()
    assert "meet at 1.349 rad" in caution


# ---------------------------------------------------------------- inertia


class Lifted(Hand):
    """A hand that is let go from a bent position, all elements slack. Not registered."""

    def home(self, xp: Namespace) -> Column:
        return [0.9, 0.5, -0.6, 1.2, 0.7, -0.8]

    def assembled_elongations(self, xp: Namespace, elongations: Column) -> Column:
        return [-1.0] * 12


def pendulum(start: tuple[float, float], size: float, times: np.ndarray) -> np.ndarray:
    """Angles of both joints of two rods that swing, in absolute angles a and b = a + θ₂."""
    l1, l2, m1, m2 = size * 0.05, size * 0.04, size**3 * 0.02, size**3 * 0.01
    cross, g = 0.5 * m2 * l1 * l2, 9.81

    def rates(_: float, y: np.ndarray) -> list[float]:
        a, b, va, vb = y
        c, s = cross * math.cos(a - b), cross * math.sin(a - b)
        mass = np.array([[(m1 / 3 + m2) * l1 * l1, c], [c, m2 * l2 * l2 / 3]])
        side = [-s * vb * vb - (0.5 * m1 + m2) * g * l1 * math.sin(a), s * va * va - 0.5 * m2 * g * l2 * math.sin(b)]
        return [va, vb, *np.linalg.solve(mass, side)]

    begin = [start[0], sum(start), 0.0, 0.0]
    found = integrate.solve_ivp(rates, (0.0, times[-1]), begin, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-12).y
    return np.array([found[0], found[1] - found[0]])


def test_fingers_swing_as_double_pendulums() -> None:
    """Large swings, three fingers of other sizes and starts, against another solver."""
    sizes: dict[str, Any] = {"thumb": 0.8, "index": 1.0, "middle": 1.2}
    free: dict[str, Any] = {"highest": 3.0, "lowest": -3.0, "preload": 0.0, "gravity": 9.81}
    mechanism = Lifted(**(GEOMETRY | free | sizes), motion="dynamic", rho_inf=0.95)
    system = machine(mechanism)
    result = simulate(system, kelvins(system), 0.5, step=2.5e-4, samples=101)
    home, times = mechanism.home(floats), np.array(result.times)
    for k, (finger, size) in enumerate(sizes.items()):
        expected = pendulum((home[2 * k], home[2 * k + 1]), size, times)
        found = np.array([result[f"{finger}_{joint}"] for joint in JOINTS])
        assert np.ptp(expected, axis=1).min() > 0.8
        assert np.abs(found - expected).max() < 5e-3
    assert max(max(result[f"{port}.force"]) for port in mechanism.ports()) == 0.0


# ---------------------------------------------------------------- cost


def test_twelve_alike_elements_are_one_loop() -> None:
    """The program of a step holds their law once, not twelve times."""
    alike = compile_system(manned(hand())).program.graph
    lone = compile_system(manned(Joint())).program.graph
    assert alike.operations.count("each") >= 1
    assert len(alike.operations) < 5 * len(lone.operations)
