"""Elements as actuators in C: the forces of the bridge, whoever steps the model, and nothing hidden from its data.

Sources of truth: `MujocoBridge`, which tries whole steps of MuJoCo, on models where the line is straight; the traced
step on plain floats, at the lines that the C recorded; MuJoCo's own energies; and copies, resets and saved states.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

from mujoco_cases import actuator, hanging, lever

from martensite.base.errors import InputError, SolveError
from martensite.export.mujoco_actuators import MujocoActuators
from martensite.export.mujoco_bridge import MujocoBridge
from martensite.export.mujoco_plant import load_mujoco
from martensite.kernels.compiler import find_compiler

mujoco: Any = load_mujoco()
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

WEIGHT = 0.3 * 9.81
ONE = (hanging(0.002, 0.3), [actuator(start_force=WEIGHT)], [lambda k: 12.0 * (k < 500)])
TWO = (
    lever(0.002, damping=2e-3),
    [actuator("wire", start_force=2.0), actuator("other", start_force=2.0)],
    [lambda k: 15.0 * (k < 400), lambda k: 15.0 * (700 < k < 1000)],
)
CASES = {"a weight": (*ONE, 1e-11), "two against each other, damped": (*TWO, 1e-8)}
"""With the difference of forces, as a share: the bridge balances several elements to 1e-6 only."""
POINT = """<mujoco><option timestep="0.002" gravity="0 0 0"/>
<default><general ctrlrange="-3 3" forcerange="-1 1" gear="3"/><motor ctrlrange="-9 9"/></default><worldbody><body>
<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<geom size="0.01" mass="0.1"/></body></worldbody><tendon><fixed name="wire"><joint joint="x" coef="1"/></fixed></tendon>
<actuator><motor name="push" joint="x" gear="1" forcerange="-2 2"/></actuator></mujoco>"""


def without_actuators(text: str) -> str:
    return re.sub("<actuator>.*?</actuator>", "", text, flags=re.DOTALL)


@pytest.mark.parametrize("case", CASES)
def test_forces_and_energies_are_those_of_the_bridge(case: str) -> None:
    text, actuators, powers, near = CASES[case]
    bridge, ours = MujocoBridge(text, actuators), MujocoActuators(without_actuators(text), actuators)
    data, forces, steps = mujoco.MjData(ours.model), [], []
    for k in range(1200):
        signals = [power(k) for power in powers]
        bridge.step(dict(zip(ours.tendons, signals, strict=True)))
        data.ctrl[:] = signals
        mujoco.mj_step(ours.model, data)
        steps.append(ours.list_steps(data))
        forces.append([[one.force for one in steps[-1]], [strand.force for strand in bridge.strands]])
    found, expected = np.moveaxis(np.array(forces), 1, 0)
    assert np.ptp(expected) > 0.5 and abs(bridge.data.qpos[0]) > 1e-4
    np.testing.assert_allclose(found, expected, rtol=near, atol=1e-10)
    energies = []
    for model, one in ((ours.model, data), (bridge.model, bridge.data)):
        mujoco.mj_fwdPosition(model, one)
        mujoco.mj_energyPos(model, one)
        mujoco.mj_energyVel(model, one)
        energies.append(one.energy.copy())
    np.testing.assert_allclose(*energies, rtol=10.0 * near, atol=1e-12)
    for measured, own in zip(ours.observe(data).values(), bridge.observe().values(), strict=True):
        assert measured == pytest.approx(own, rel=10.0 * near, abs=1e-10)
    for row in steps[::40]:  # the same steps on plain floats
        for strand, step in zip(ours.strands, row, strict=True):
            strand.state = step.start
            answer = strand.trial(step.drive, 0.002)(step.reach, step.give)
            assert step.end == pytest.approx(answer.state, rel=1e-12, abs=1e-12)


def test_all_that_is_remembered_stands_in_the_data() -> None:
    text, actuators, _ = TWO
    ours = MujocoActuators(without_actuators(text), actuators)
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
    other = MujocoActuators(without_actuators(hanging(0.002, 0.3)), [actuator(start_force=WEIGHT)])
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
    ours = MujocoActuators(without_actuators(ONE[0]), ONE[1])
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
    with pytest.raises(InputError, match="tendon of its own"):
        MujocoActuators(ONE[0], [])
