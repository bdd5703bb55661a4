"""Finger and platform as MJCF: the same equations, and the same motion in short steps.

Source of truth: the equations of the mechanisms. MuJoCo's inverse dynamics and tendons must be
`demand` and `contraction` to rounding; the model must move as `simulate` does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

import mujoco as installed
from builders import hanging_wire
from coil_cases import platform_spring
from finger import finger as finger_prototype
from finger import finger_law

from martensite.actuators.assembly import AbstractSystem, Actuator, Group, Machine, System
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.finger import Finger
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.base.errors import InputError, ParameterError
from martensite.export import mjcf
from martensite.export.mjcf import start_forces, tendon_signals, to_mjcf, to_mujoco
from martensite.export.mujoco_models import compile_spec, read_spec
from martensite.export.mujoco_result import MujocoResult
from martensite.kernels import floats
from martensite.kernels.compiler import find_compiler
from martensite.kernels.dual import compute_jacobian
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.step import Step
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.drive_waveforms import Waveforms
from martensite.simulate.result import Result

mujoco: Any = installed
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
TRAPEZOID = Table(times=(0.0, 0.2, 2.2, 4.0, 6.0, 8.2), values=(0.0, 0.0, 2.0, 2.0, 0.0, 0.0))
"""2 W: up and back."""
PULSE: dict[str, Any] = {"first": Step(low=0.0, high=34.0, until=1.9)}
"""Power [W]: to 26° in 1.9 s."""


def finger(offset: float = 3.5e-3, kind: type[Finger] = Finger, **changes: Any) -> System:
    """The prototype with inertia, some damping and the law without rates."""
    usual: dict[str, Any] = {
        "offset": offset,
        "bracket": 10.6e-3,
        "stiffness": 50.0,
        "arm": 8e-3,
        "extension": 1e-3,
        "inertia": 1.8e-5,
        "damping": 1e-4,
        "motion": "dynamic",
    }
    mechanism = kind(**(usual | changes))
    return finger_prototype(finger_law("mas-hybrid")).with_parts(mechanism=mechanism)


def platform(**changes: Any) -> Machine:
    """Three springs under power, with inertia and some damping."""
    usual: dict[str, Any] = {"side": 0.1, "height": 0.06, "mass": 0.075, "damping": 1e-3, "motion": "dynamic"}
    one = Actuator(
        element=platform_spring(),
        source=PowerSource(),
        environment=Environment(temperature=298.15, cooling=ConstantCooling(h=150.0)),
    )
    mechanism = ParallelPlatform(**(usual | changes))
    return Machine(mechanism=mechanism, group=Group(first=one, second=one, third=one))


MODELS: dict[str, AbstractSystem] = {
    "finger": finger(),
    "finger of three passes": finger(passes=3.0, damping=2e-3),
    "finger of one pass and a half": finger(5.5e-3, passes=1.5),
    "finger on a fixed spring": finger(spring="fixed", height=0.05),
    "finger with a weight": finger(weight="given", mass=0.02, tilt=-0.7),
    "platform": platform(),
    "platform on a low joint": platform(eccentricity=0.02, preload=2.0),
    "platform of a given inertia, hanging": platform(eccentricity=-0.01, inertia=8e-5, gravity=-9.81, side=0.12),
}


def multibody(system: AbstractSystem) -> AbstractMultibody:
    if not isinstance(system.mechanism, AbstractMultibody):
        raise TypeError("no coordinates")
    return system.mechanism


def read_model(text: str) -> Any:
    return compile_spec(read_spec(text))


class Longer(Finger):
    """A finger that is written by nothing. Deliberately not registered."""


class Posed:
    """A model at given coordinates of its mechanism, in the order of the mechanism."""

    def __init__(self, system: AbstractSystem) -> None:
        self.model = read_model(to_mjcf(system))
        self.data = mujoco.MjData(self.model)
        names = [c.name for c in multibody(system).coordinates()]
        joints = [self.model.joint(name) for name in names]
        self.order = [int(joint.qposadr[0]) for joint in joints]
        self.tendons = [self.model.tendon(port).id for port in system.mechanism.ports()]

    def tendon(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lengths [m] and moment arms [m/rad] of the elements."""
        self.data.qpos[self.order] = position
        mujoco.mj_forward(self.model, self.data)
        arms = np.array(self.data.ten_J).reshape(-1)
        if arms.size != self.model.ntendon * self.model.nv:  # sparse in some versions
            pytest.skip("this MuJoCo keeps moment arms in another form")
        arms = arms.reshape(self.model.ntendon, self.model.nv)
        return self.data.ten_length[self.tendons].copy(), arms[self.tendons][:, self.order]

    def demand(self, motion: Motion) -> np.ndarray:
        """Generalised forces [N m] that a motion takes, by MuJoCo's inverse dynamics."""
        data, order = self.data, self.order
        data.qpos[order], data.qvel[order], data.qacc[order] = motion
        mujoco.mj_inverse(self.model, data)
        return data.qfrc_inverse[order].copy()


def samples(count: int, size: int, seed: int = 3) -> list[Motion]:
    """Motions within ±60°, fast ones."""
    drawn = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3, size))
    return [Motion(*(tuple(row) for row in one * [[1.0], [20.0], [500.0]])) for one in drawn]


# ---------------------------------------------------------------- the same equations


@pytest.mark.parametrize("name", MODELS)
def test_tendons_are_the_paths_of_the_elements(name: str) -> None:
    """Length and moment arm of every element, at 25 postures."""
    system, posed = MODELS[name], Posed(MODELS[name])
    mechanism = multibody(system)
    home, _ = posed.tendon(np.zeros(len(posed.order)))
    for motion in samples(25, len(posed.order)):
        found, arms = posed.tendon(np.array(motion.position))
        shorter, slopes = compute_jacobian(floats, mechanism.contraction, motion.position)
        np.testing.assert_allclose(home - found, shorter, atol=1e-15)
        np.testing.assert_allclose(-arms, slopes, atol=1e-15)


@pytest.mark.parametrize("name", MODELS)
def test_inverse_dynamics_are_the_demand(name: str) -> None:
    """Inertia, Coriolis terms, damping, springs and weight, at 25 fast motions."""
    system, posed = MODELS[name], Posed(MODELS[name])
    for motion in samples(25, len(posed.order)):
        expected = multibody(system).demand(floats, motion, ())
        np.testing.assert_allclose(posed.demand(motion), expected, rtol=1e-11, atol=1e-15)


@pytest.mark.parametrize("stop", [0.5, 10.0])
@pytest.mark.parametrize(
    ("changes", "limit", "side"),
    [
        ({"highest": 0.7}, 0.7, 1.0),
        ({"lowest": -0.2}, -0.2, -1.0),
        ({"bracket": 2e-3}, 2.0 * math.atan2(2.0, 3.5), 1.0),
    ],
)
def test_limits_give_way_as_the_stops_do(changes: dict[str, Any], limit: float, side: float, stop: float) -> None:
    """At rest 20 mN m push the hinge past a stop, or past brackets that met, by M/K."""
    system = finger(stop=stop, stiffness=0.0, **changes)
    model = read_model(to_mjcf(system))
    data = mujoco.MjData(model)
    data.qfrc_applied[0] = side * 0.02
    mujoco.mj_step(model, data, 2000)
    past = data.qpos[0] - limit
    assert past == pytest.approx(side * 0.02 / stop, rel=1e-9)
    rest = Motion((float(data.qpos[0]),), (0.0,), (0.0,))
    assert multibody(system).demand(floats, rest, ())[0] == pytest.approx(side * 0.02, rel=1e-3)


# ---------------------------------------------------------------- the same motion


def run_mujoco(system: AbstractSystem, waveform: Waveforms, times: Any, step: float) -> MujocoResult:
    """Run the system in MuJoCo, with the samples of a run of ours."""
    model = to_mujoco(system, timestep=step)
    found = model.run(times[-1], tendon_signals(system, waveform), samples=len(times))
    np.testing.assert_allclose(found.times, times, atol=1e-9)
    return found


def apart(ours: Result, found: MujocoResult, names: Mapping[str, str]) -> dict[str, float]:
    """Largest difference of columns; angles in degrees. `names`: ours -> MuJoCo's."""
    found_apart: dict[str, float] = {}
    for name, other in names.items():
        scale = math.degrees(1.0) if ours.system.outputs()[name].unit == "rad" else 1.0
        found_apart[name] = scale * float(np.abs(np.subtract(ours[name], found[other])).max())
    return found_apart


STATES = ("temperature", "martensite_fraction", "force")
FINGER = {"angle": "angle"} | {name: f"element.{name}" for name in STATES}


@needs_compiler
def test_the_finger_moves_alike() -> None:
    """In steps of 1 ms, through a wire that hangs slack as the finger falls back."""
    ours = simulate(finger(5.5e-3), TRAPEZOID, 8.2, step=1e-3, samples=411, runtime="c")
    assert math.degrees(max(ours["angle"])) == pytest.approx(62.6, abs=0.2)
    assert math.degrees(ours["angle"][-1]) < 0.5
    off = apart(ours, run_mujoco(finger(5.5e-3), TRAPEZOID, ours.times, 1e-3), FINGER)
    assert off["angle"] < 0.05
    assert off["temperature"] < 0.1
    assert off["martensite_fraction"] < 2e-3
    assert off["force"] < 0.04 * max(ours["force"])


def platform_names() -> dict[str, str]:
    """All angles and states."""
    columns = [f"{port}.{name}" for port in ("first", "second", "third") for name in STATES]
    return {name: name for name in ("alpha", "beta", *columns)}


@needs_compiler
def test_the_platform_moves_alike() -> None:
    """One spring up to 26°, then another while it cools: both axes, in steps of 5 ms."""
    wave = PULSE | {"second": Step(low=0.0, high=30.0, at=2.2, until=4.0)}
    ours = simulate(platform(), wave, 6.0, step=1e-3, samples=241, runtime="c")
    assert math.degrees(max(ours["alpha"])) == pytest.approx(26.3, abs=0.1)
    assert math.degrees(ours["alpha"][-1]) < 20.0
    assert math.degrees(max(ours["beta"])) > 5.0
    off = apart(ours, run_mujoco(platform(), wave, ours.times, 5e-3), platform_names())
    assert max(off["alpha"], off["beta"]) < 0.02
    assert max(off[f"{port}.temperature"] for port in ("first", "second")) < 0.02
    assert max(value for name, value in off.items() if name.endswith("_fraction")) < 5e-4
    assert max(value for name, value in off.items() if name.endswith("force")) < 0.01


# ---------------------------------------------------------------- what is written


@needs_compiler
def test_the_start_is_that_of_the_system() -> None:
    system = finger()
    ours = to_mujoco(system, timestep=1e-3)
    assert ours.model.opt.timestep == 1e-3
    force = 50.0 * 8e-3 * 1e-3 / (2.0 * 3.5e-3)
    assert start_forces(system) == {"element": pytest.approx(force)}
    assert ours.model.numeric("start_force_element").data[0] == pytest.approx(force)
    data = ours.begin()
    seen = ours.observe(data)["element"]
    first = simulate(system, TRAPEZOID, 1e-3, step=1e-3, samples=2)
    for name in ("force", "strain", "temperature", "martensite_fraction"):
        assert seen[name] == pytest.approx(first[name][0], rel=1e-12)
    ours.run(0.2, {"element": 0.0}, data=data)
    assert abs(data.qpos[0]) < 1e-9


def test_signals_go_by_the_names_of_tendons() -> None:
    assert tendon_signals(finger(), TRAPEZOID) == {"element": TRAPEZOID}
    found = tendon_signals(platform(), PULSE)
    assert found["first"] == PULSE["first"]
    assert [found[port].value(0.5) for port in ("first", "second", "third")] == [34.0, 0.0, 0.0]
    with pytest.raises(InputError, match="There is no drive `frist`"):
        tendon_signals(platform(), {"frist": PULSE["first"]})


def test_a_finger_without_stops_has_no_limits() -> None:
    assert read_model(to_mjcf(finger(stop=0.0))).jnt_limited[0] == 0


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (hanging_wire(), "`dead-weight` cannot be written as MJCF; .*`finger`, `parallel-platform`"),
        (finger(friction=0.1), "slide without friction, but parameter `friction` of `finger` is 0.1"),
        (finger(spring="fixed", extension=0.06), "`extension` of `finger` .* at most `height`, 50 mm"),
        (finger(kind=Longer), "cannot be written"),
    ],
)
def test_what_cannot_be_written(system: AbstractSystem, words: str) -> None:
    with pytest.raises(InputError, match=words):
        to_mjcf(system)


def test_a_writer_of_ones_own() -> None:
    """A mechanism that has none gets one by an entry of the table."""
    system = finger(kind=Longer)
    mjcf.WRITERS[Longer] = mjcf.WRITERS[Finger]
    try:
        assert read_model(to_mjcf(system)).ntendon == 1
    finally:
        del mjcf.WRITERS[Longer]


@pytest.mark.parametrize("timestep", [0.0, -1e-3, 1.0, math.nan])
def test_timesteps_that_are_refused(timestep: float) -> None:
    with pytest.raises(ParameterError, match="`timestep` must be above 0 s and below 1 s"):
        to_mjcf(finger(), timestep=timestep)


@needs_compiler
def test_a_static_grip_is_that_of_soft_contacts() -> None:
    """MuJoCo's contact gives way by nanometres: forces of wire and contact are equal to some millionths."""
    grip = {"contact": "cylinder", "cylinder_along": 0.025, "cylinder_inwards": 0.03, "weight": "given", "tilt": -0.35}
    rise = Table(times=(0.0, 0.2, 1.2, 9.0), values=(0.0, 0.0, 2.0, 2.0))
    still = finger(**grip, motion="quasi-static")
    ours = simulate(still, rise, 7.0, samples=5, tolerance=1e-4)
    system = finger(**grip, damping=1e-3)
    model = to_mujoco(system, timestep=4e-3)
    data, force = model.begin(), np.zeros(6)
    theirs = model.run(7.0, tendon_signals(system, rise), data=data, samples=5)
    mujoco.mj_contactForce(model.model, data, 0, force)
    assert data.ncon == 1
    assert force[0] == pytest.approx(ours["contact_force"][-1], rel=1e-5)
    assert force[0] > 0.1
    assert -1e-7 < data.contact[0].dist < 0.0
    assert theirs["element.force"][-1] == pytest.approx(ours["force"][-1], rel=1e-5)


@needs_compiler
def test_a_rigid_stop_is_a_limit() -> None:
    rise = Table(times=(0.0, 0.2, 1.2, 9.0), values=(0.0, 0.0, 2.0, 2.0))
    ours = simulate(finger(contact="stops", highest=0.5, motion="quasi-static"), rise, 7.0, samples=5, tolerance=1e-4)
    system = finger(contact="stops", highest=0.5, damping=1e-3)
    model = to_mujoco(system, timestep=4e-3)
    data = model.begin()
    model.run(7.0, tendon_signals(system, rise), data=data, samples=5)
    assert data.qfrc_constraint[0] == pytest.approx(ours["stop_moment"][-1], rel=1e-5)
    assert ours["stop_moment"][-1] < -1e-3


def test_a_mass_needs_inertia_about_its_centre() -> None:
    with pytest.raises(InputError, match="nothing is left about the centre"):
        to_mjcf(finger(weight="given", motion="quasi-static", inertia=4e-6))
