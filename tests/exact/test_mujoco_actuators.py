"""Elements as actuators of MuJoCo models: closed forms of the step, and nothing hidden from the data.

Sources of truth: the recurrence of a linear oscillator in MuJoCo's time step, statics of springs in parallel, a run
without inertia, the traced step on plain floats, the dense mass matrix; and copies, resets and saved states.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

from mujoco_cases import GRAVITY, actuator, hanging, lever, recurrence, stiffness, weighed

from martensite.actuators.assembly import System
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.base.errors import InputError, SolveError
from martensite.export.mujoco_actuators import COUPLINGS, MujocoActuators
from martensite.export.mujoco_models import load_mujoco, measure_tendons
from martensite.kernels.compiler import find_compiler
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_system

mujoco: Any = load_mujoco()
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

MASS, RADIUS, INERTIA = 0.5, 0.004, 1.8e-5
WEIGHT = 0.3 * GRAVITY
ONE = hanging(0.002, 0.3), [actuator(start_force=WEIGHT)]
TWO = lever(0.002, damping=2e-3), [actuator("wire", start_force=2.0), actuator("other", start_force=2.0)]
POINT = """<mujoco><option timestep="0.002" gravity="0 0 0"/>
<default><general ctrlrange="-3 3" forcerange="-1 1" gear="3"/><motor ctrlrange="-9 9"/></default><worldbody><body>
<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<geom size="0.01" mass="0.1"/></body></worldbody><tendon><fixed name="wire"><joint joint="x" coef="1"/></fixed></tendon>
<actuator><motor name="push" joint="x" gear="1" forcerange="-2 2"/></actuator></mujoco>"""


def pushed(model: MujocoActuators, joint: str, speed: float, steps: int) -> np.ndarray:
    """Positions of a joint in every step after a push."""
    data = model.begin()
    data.joint(joint).qvel[0] = speed
    signals = dict.fromkeys(model.tendons, 0.0)
    return np.array(model.run(steps * model.model.opt.timestep, signals, data=data, samples=steps + 1)[joint])


# ---------------------------------------------------------------- closed forms


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("share", [0.05, 4.0])
def test_a_mass_on_a_wire_is_the_recurrence(share: float, coupling: str) -> None:
    """Exact, at steps that resolve the oscillation (ω dt = 0.05) and at steps that do not."""
    frequency = math.sqrt(stiffness(actuator(elastic=True)) / MASS)
    dt, speed = share / frequency, 1e-2 / (1.0 + share)
    positions = pushed(weighed(MASS, dt, coupling), "x", speed, 200)
    expected, softer = (recurrence(f, dt, speed, 200, coupling) for f in (frequency, 0.9995 * frequency))
    size = max(map(abs, expected))
    np.testing.assert_allclose(positions, expected, atol=1e-9 * size)
    assert max(abs(a - b) for a, b in zip(expected, softer, strict=True)) > 1e-5 * size  # a softer wire is noticed


@pytest.mark.parametrize(("coupling", "order"), [("end", 1.0), ("centred", 2.0)])
def test_order_of_the_coupling(coupling: str, order: float) -> None:
    """Largest error of x = (v/ω) sin ωt over a period, in 160 and 320 steps."""
    frequency, speed = math.sqrt(stiffness(actuator(elastic=True)) / MASS), 1e-2
    errors = []
    for steps in (160, 320):
        dt = 2.0 * math.pi / frequency / steps
        # velocities of MuJoCo belong to half steps: at the start x is 0 and v is half a step old
        exact = speed / frequency * np.sin(frequency * dt * np.arange(steps + 1))
        errors.append(np.abs(pushed(weighed(MASS, dt, coupling), "x", speed, steps) - exact).max())
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def antagonists(dt: float, preload: float, **changes: float) -> MujocoActuators:
    """Two elastic wires of different diameters on one pulley."""
    pair = [
        actuator("wire", elastic=True, start_force=preload, diameter=0.2e-3),
        actuator("other", elastic=True, start_force=preload, diameter=0.3e-3),
    ]
    return MujocoActuators(lever(dt, **changes), pair)


@pytest.mark.parametrize("share", [0.05, 4.0])
def test_antagonists_act_as_one_spring(share: float) -> None:
    """The recurrence with ω² = (k₁ + k₂) r²/I; both yield to each other within the step."""
    rates = [stiffness(actuator(elastic=True, diameter=d)) for d in (0.2e-3, 0.3e-3)]
    frequency = math.sqrt(sum(rates) * RADIUS**2 / INERTIA)
    dt, speed = share / frequency, 0.1
    positions = pushed(antagonists(dt, 5.0, damping=0.0), "hinge", speed, 100)
    expected = recurrence(frequency, dt, speed, 100)
    np.testing.assert_allclose(positions, expected, atol=1e-6 * max(map(abs, expected)))


@pytest.mark.parametrize("torque", [0.01, 0.05])
def test_antagonists_under_a_torque(torque: float) -> None:
    """q = M/((k₁ + k₂) r²) while both are taut, and by the taut one alone after that."""
    preload = 4.0
    taut, slack = (stiffness(actuator(elastic=True, diameter=d)) for d in (0.2e-3, 0.3e-3))
    model = antagonists(1e-3, preload, damping=0.02)
    data = model.begin()
    data.qfrc_applied[0] = torque
    result = model.run(2.0, {"wire": 0.0, "other": 0.0}, data=data, samples=11)
    angle = torque / ((taut + slack) * RADIUS**2)
    if slack * angle * RADIUS > preload:
        angle = (torque / RADIUS - preload) / (taut * RADIUS)
    assert result["hinge"][-1] == pytest.approx(angle, rel=1e-6)
    assert result["wire.force"][-1] == pytest.approx(preload + taut * RADIUS * angle, rel=1e-6)
    left = max(preload - slack * RADIUS * angle, 0.0)
    assert result["other.force"][-1] == pytest.approx(left, abs=1e-6)
    assert [alarm.port for alarm in result.alarms] == (["other"] if left == 0.0 else [])


@pytest.mark.parametrize(("duration", "dt", "close"), [(8.0, 2e-3, 2e-3), (32.0, 8e-3, 5e-4)])
def test_slow_heating_is_a_dead_weight(duration: float, dt: float, close: float) -> None:
    """A hanging mass is where `simulate` has it without inertia; the slower, the closer."""
    wave = Sine(low=0.0, high=5.0, frequency=1.0 / duration)
    one = actuator(start_force=MASS * GRAVITY)
    weight = DeadWeight(mass=MASS, gravity=GRAVITY)
    quasi = System(element=one.element, environment=one.environment, source=one.source, mechanism=weight)
    still = simulate(quasi, wave, duration, tolerance=1e-5, samples=401)
    moving = MujocoActuators(hanging(dt, MASS), [one]).run(duration, {"wire": wave}, samples=401)
    assert still.stroke > 5e-3
    for name, other in (("x", "position"), ("wire.temperature", "temperature")):
        apart = np.abs(np.subtract(moving[name], still[other])).max()
        assert apart < close * still.range(other)


@pytest.mark.parametrize(("text", "actuators"), [ONE, TWO])
@pytest.mark.parametrize("coupling", COUPLINGS)
def test_steps_are_those_of_plain_floats_on_lines_that_the_model_follows(
    text: str, actuators: list[Any], coupling: str
) -> None:
    """On straight paths MuJoCo's own step ends where the line says: reach - give F."""
    ours = MujocoActuators(text, actuators, coupling=coupling)
    data, names, forces = ours.begin(), [one.tendon for one in actuators], list[float]()
    steps = []
    for one in ours.strands:
        compiled = compile_system(one.system)
        steps.append(compiled.program.bind_floats(*compiled.values(one.system))["step"])
    for k in range(1200):
        data.ctrl[:] = [12.0 * (k < 400), 12.0 * (700 < k < 1000)][: len(names)]
        mujoco.mj_step(ours.model, data)
        forces.append(ours.list_steps(data)[0].force)
        if k % 40:
            continue
        for strand, step, compute, length in zip(
            ours.strands, ours.list_steps(data), steps, measure_tendons(ours.model, data), strict=True
        ):
            end = length - strand.reference
            assert end == pytest.approx(step.reach - step.give * step.force, rel=1e-9, abs=1e-12)
            *state, _, crossing = compute(*step.start, step.drive, step.reach, step.give, 0.002)
            assert step.end == pytest.approx(state, rel=1e-12, abs=1e-12)
            assert step.crossing == pytest.approx(crossing, rel=1e-9, abs=1e-12)
    assert np.ptp(forces) > 0.5


# ---------------------------------------------------------------- what stands in the data


def test_all_that_is_remembered_stands_in_the_data() -> None:
    text, actuators = TWO
    ours = MujocoActuators(text, actuators)
    model, data = ours.model, mujoco.MjData(ours.model)
    what = mujoco.mjtState.mjSTATE_INTEGRATION

    def go(one: Any, steps: int) -> list[float]:
        one.ctrl[:] = 10.0, 0.0
        for _ in range(steps):
            mujoco.mj_step(model, one)
        return [one.time, *one.qpos, *one.qvel, *one.userdata]

    go(data, 150)
    saved = np.zeros(mujoco.mj_stateSize(model, what))
    mujoco.mj_getState(model, data, saved, what)
    copied = mujoco.MjData(model)
    mujoco.mj_copyData(copied, model, data)
    after = go(data, 100)
    mujoco.mj_forward(model, copied)  # at the same time: asks for the force, and takes no step
    assert go(copied, 100) == after
    mujoco.mj_setState(model, data, saved, what)
    assert go(data, 100) == after
    mujoco.mj_resetData(model, data)
    go(data, 150)
    assert go(data, 100) == after
    other = MujocoActuators(hanging(0.002, 0.3), [actuator(start_force=WEIGHT)])
    between = mujoco.MjData(other.model)
    mujoco.mj_step(other.model, between)
    mujoco.mj_resetData(model, data)
    go(data, 150)
    assert go(data, 100) == after
    assert other.observe(between)["wire"]["force"] == pytest.approx(WEIGHT, rel=1e-6)


def test_what_else_acts_is_in_the_line() -> None:
    """A motor at its limit pulls as the wire is assembled and keeps it in its place; a control is read where it stands.

    Defaults of the model, which would limit and scale, are not for the wire.
    """
    ours = MujocoActuators(POINT, [actuator(start_force=2.0)])
    data = mujoco.MjData(ours.model)
    assert [ours.model.actuator(k).name for k in range(2)] == ["push", "wire"]
    data.ctrl[:] = 5.0, 0.0
    mujoco.mj_step(ours.model, data, nstep=100)
    assert abs(data.qpos[0]) < 1e-12
    assert ours.list_steps(data)[0].force == pytest.approx(2.0, rel=1e-9)
    data.ctrl[:] = 5.0, 8.0
    mujoco.mj_step(ours.model, data, nstep=500)
    assert data.qpos[0] < -1e-4
    assert ours.observe(data)["wire"]["temperature"] > 300.0


@pytest.mark.parametrize("damped", [True, False])
def test_the_line_is_that_of_the_dense_mass_matrix(damped: bool) -> None:
    """A humanoid that stands in the air: what a path yields, and where it ends, by linear algebra."""
    gymnasium: Any = pytest.importorskip("gymnasium")
    spec = mujoco.MjSpec.from_file(str(Path(gymnasium.__file__).parent / "envs/mujoco/assets/humanoid.xml"))
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    if not damped:
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    ours = MujocoActuators(spec, [actuator("left_hipknee", start_force=1.0)])
    model, data = ours.model, mujoco.MjData(ours.model)
    dt, rng = model.opt.timestep, np.random.default_rng(0)
    data.qvel[:], data.ctrl[:-1] = rng.normal(size=model.nv), 0.2 * rng.normal(size=model.nu - 1)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    mass, moment = np.zeros((model.nv, model.nv)), np.zeros((model.nu, model.nv))
    mujoco.mj_fullM(model, data, mass)
    mujoco.mju_sparse2dense(moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind)
    own = moment[-1]
    mass += damped * dt * np.diag(model.dof_damping)
    forces = data.qfrc_passive - data.qfrc_bias + moment[:-1].T @ data.actuator_force[:-1]  # no limits one step ago
    (step,) = ours.list_steps(data)
    assert step.give == pytest.approx(dt * dt * own @ np.linalg.solve(mass, own), rel=1e-12)
    end = data.actuator_length[-1] + dt * own @ (data.qvel + dt * np.linalg.solve(mass, forces))
    assert step.reach == pytest.approx(end - ours.strands[0].reference, rel=1e-10)


def test_a_step_that_fails_is_told() -> None:
    ours = MujocoActuators(ONE[0], ONE[1])
    data = mujoco.MjData(ours.model)
    mujoco.mj_step(ours.model, data, nstep=5)
    data.time = 0.004
    mujoco.mj_forward(ours.model, data)
    assert np.isnan(data.actuator_force).all()
    with pytest.raises(SolveError, match=r"t = 0.004 s: time went back"):
        ours.observe(data)
    mujoco.mj_resetData(ours.model, data)
    ours.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    mujoco.mj_forward(ours.model, data)
    with pytest.raises(SolveError, match="Euler"):
        ours.require_solved()


WRONG = [
    (ONE[0], "wir", "wire"),
    (ONE[0].replace("<option", '<option integrator="RK4"'), "wire", "Euler"),
    (ONE[0].replace('"/>', '"><flag actuation="disable"/></option>', 1), "wire", "disables actuation"),
    (ONE[0].replace("</tendon>", "</tend>"), "wire", "cannot read the model"),
    ("no_such.xml", "wire", "no MJCF file"),
]


@pytest.mark.parametrize(("text", "tendon", "said"), WRONG)
def test_what_does_not_fit_is_said(text: str, tendon: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        MujocoActuators(text, [actuator(tendon)])
    with pytest.raises(InputError, match="its own tendon"):
        MujocoActuators(ONE[0], [])
