"""Runs of MuJoCo models with elements: columns, alarms, contacts, slack, refusals, holding tensions, and pictures.

Source of truth: the documented contract, and statics of small models.
"""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

import mujoco as installed
from builders import example, law_a
from mujoco_cases import GRAVITY, actuator, hanging, lever, weighed

from martensite.actuators.assembly import OUTPUTS
from martensite.actuators.elements.base import ELEMENTS
from martensite.base.errors import InputError, ParameterError, SolveError, UnitError
from martensite.export.mujoco_actuators import MujocoActuators
from martensite.export.mujoco_models import holding_tensions, read_spec
from martensite.kernels.compiler import find_compiler
from martensite.signals.carrier import Carrier
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.table import Table

mujoco: Any = installed
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
MASS = 0.5
PULSE = Table(times=(0.0, 0.1, 0.2, 0.7, 0.8, 2.0), values=(0.0, 0.0, 3.0, 3.0, 0.0, 0.0))


def lifted(**changes: Any) -> MujocoActuators:
    """A mass that a wire can lift."""
    return MujocoActuators(hanging(2e-3, MASS), [actuator(start_force=MASS * GRAVITY)], **changes)


def pulled(more: str = "", **changes: Any) -> MujocoActuators:
    """A lever between two wires that can be heated."""
    pair = [actuator(n, diameter=0.15e-3, start_force=3.0) for n in ("wire", "other")]
    return MujocoActuators(lever(2e-3, more=more, **changes), pair)


# ---------------------------------------------------------------- what a run returns


def test_columns_of_a_run() -> None:
    model = lifted()
    data = model.begin()
    result = model.run(0.5, {"wire": 12.0}, data=data, samples=26)
    assert len(result.times) == 26
    assert result.times[-1] == pytest.approx(0.5)
    assert set(result.tendons["wire"]) == {*OUTPUTS, "elongation", "length"}
    assert result["time"] == result.times
    assert result["x"][-1] == data.qpos[0] > 1e-3
    assert result.poses[-1] == [result["x"][-1]]
    assert result["wire.power"][-1] == pytest.approx(12.0)
    assert result["wire.length"] == pytest.approx([0.3 - x for x in result["x"]])
    assert result["wire.strain"] == pytest.approx([e / 0.25 for e in result["wire.elongation"]], abs=1e-9)
    assert result.step == 2e-3


def test_two_runs_are_one_and_steps_by_hand_too() -> None:
    model, ramp = lifted(), Ramp(high=12.0, end=0.5)
    whole, parts, stepped = model.begin(), model.begin(), model.begin()
    model.run(0.4, {"wire": ramp}, data=whole)
    model.run(0.2, {"wire": ramp}, data=parts)
    model.run(0.2, {"wire": ramp}, data=parts)
    for _ in range(200):
        stepped.ctrl[0] = ramp.value(stepped.time + 1e-3)
        mujoco.mj_step(model.model, stepped)
    stepped.ctrl[0] = whole.ctrl[0]
    assert parts.qpos[0] == whole.qpos[0] == stepped.qpos[0]
    assert model.observe(parts) == model.observe(whole) == model.observe(stepped)
    assert model.observe(model.begin())["wire"]["temperature"] == pytest.approx(293.15)  # new data are new


def limited() -> MujocoActuators:
    """A mass on a wire that may be 330 K hot."""
    one = actuator(start_force=MASS * GRAVITY, law=law_a())
    limits = one.element.limits.with_values({"temperature_limit": 330.0})
    return MujocoActuators(hanging(2e-3, MASS), [one.with_parts(element=one.element.with_parts(limits=limits))])


def test_alarms_come_from_every_step_and_name_the_tendon() -> None:
    """Source of truth: a run with a sample at every step."""
    pulse = Table(times=(0.0, 0.1, 0.11, 0.6, 0.61, 4.0), values=(0.0, 0.0, 12.0, 12.0, 0.0, 0.0))
    few, many = (limited().run(4.0, {"wire": pulse}, samples=samples) for samples in (2, 2001))
    assert few.alarms == many.alarms
    assert [(alarm.kind, alarm.port) for alarm in few.alarms] == [("temperature", "wire")]
    assert few.warnings[0].startswith("Warning: `wire`: temperature reaches")
    assert few["wire.temperature"][-1] < 320.0


def test_steps_too_long_for_the_law_are_warned_of() -> None:
    one = actuator(start_force=MASS * GRAVITY)
    slow, fast = (MujocoActuators(hanging(dt, MASS), [one]).run(1.0, {"wire": 30.0}) for dt in (5e-4, 0.1))
    assert slow.coarse_time is None
    assert fast.coarse_time is not None and any("first at t" in words for words in fast.warnings)


@pytest.mark.parametrize("name", ELEMENTS.names())
def test_any_element(name: str) -> None:
    """Heated for a moment under a small weight, every one contracts and carries it."""
    one = actuator(start_force=0.05 * GRAVITY).with_parts(element=example(ELEMENTS[name]))
    result = MujocoActuators(hanging(2e-3, 0.05), [one]).run(0.1, {"wire": 3.0}, samples=3)
    assert result["x"][-1] > 1e-5
    assert result["wire.force"][-1] == pytest.approx(0.05 * GRAVITY, rel=0.5)
    assert result["wire.temperature"][-1] > 293.15 + 0.5


# ---------------------------------------------------------------- several, slack, contacts


def test_antagonists_in_turn() -> None:
    result = pulled().run(2.0, {"wire": PULSE, "other": 0.0})
    assert min(result["hinge"]) < math.radians(-4.0)
    assert max(result["other.force"]) > 3.4
    mirrored = pulled().run(2.0, {"wire": 0.0, "other": PULSE})
    assert mirrored["hinge"] == pytest.approx([-q for q in result["hinge"]], abs=1e-5)


def test_light_levers_between_stiff_wires() -> None:
    """dt² S of 5 and of 500 times the compliance of a wire: the same motion without inertia."""
    heats = {"wire": PULSE, "other": 0.0}
    light, lighter = (pulled(inertia=i).run(2.0, heats, samples=101) for i in (1e-7, 1e-9))
    assert light["hinge"] == pytest.approx(lighter["hinge"], abs=1e-3)
    assert min(light["hinge"]) < math.radians(-4.0)


def test_a_slack_wire_does_not_push() -> None:
    slack = 1e-3
    result = MujocoActuators(hanging(1e-4, MASS), [actuator(slack=slack, elastic=True)]).run(
        0.02, {"wire": 0.0}, samples=201
    )
    taut = next(k for k, force in enumerate(result["wire.force"]) if force > 0.0)
    assert result.times[taut] == pytest.approx(math.sqrt(2.0 * slack / GRAVITY), rel=0.02)
    assert -result["x"][taut] > slack >= -result["x"][taut - 1]
    assert min(result["wire.force"]) == 0.0
    assert [alarm.kind for alarm in result.alarms] == []  # it was slack from the start


def test_a_joint_limit_is_met() -> None:
    limits = 'range="-2 2" limited="true" solreflimit="0.004 1"'
    result = pulled(limits).run(2.0, {"wire": PULSE, "other": 0.0})
    assert math.degrees(min(result["hinge"])) == pytest.approx(-2.0, abs=0.3)


def test_a_floor_carries_the_mass() -> None:
    model = hanging(1e-3, MASS).replace("<worldbody>", '<worldbody><geom type="plane" size="1 1 1" pos="0 0 0.68"/>')
    result = MujocoActuators(model, [actuator(elastic=True, slack=0.05)]).run(0.5, {"wire": 0.0}, samples=51)
    assert result["x"][-1] == pytest.approx(-0.01, abs=1e-3)
    assert max(result["wire.force"]) == 0.0


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit"])
def test_any_integrator(integrator: str) -> None:
    model = hanging(1e-3, MASS).replace("<option", f'<option integrator="{integrator}"')
    result = MujocoActuators(model, [actuator(start_force=MASS * GRAVITY)]).run(1.0, {"wire": 12.0}, samples=3)
    assert result["x"][-1] == pytest.approx(9.5e-3, rel=0.1)


# ---------------------------------------------------------------- the start


LOW = hanging(1e-3, MASS).replace("</mujoco>", '<keyframe><key name="low" qpos="-0.1" qvel="3"/></keyframe></mujoco>')


def test_a_weight_is_held_by_its_weight() -> None:
    spec = read_spec(LOW)
    for model in (LOW, spec):
        assert holding_tensions(model, ["wire"], keyframe="low")["wire"] == pytest.approx(MASS * GRAVITY, rel=1e-6)
    assert len(spec.actuators) == 0  # it is as it was


def test_of_two_wires_the_one_that_is_needed_holds() -> None:
    model = lever(1e-3, stiffness=0.01, springref=math.degrees(-1.2))
    tensions = holding_tensions(model, ["wire", "other"])
    assert tensions["other"] == pytest.approx(0.01 * 1.2 / 0.004, rel=1e-6)
    assert tensions["wire"] == 0.0
    with pytest.raises(SolveError, match="No tensions of wire hold the model"):
        holding_tensions(model, ["wire"])


def test_a_keyframe_is_where_it_starts(tmp_path: Path) -> None:
    path = tmp_path / "mass.xml"
    path.write_text(LOW, encoding="utf-8")
    model = MujocoActuators(path, [actuator(start_force=MASS * GRAVITY)], keyframe="low")
    seen = model.observe(model.begin())["wire"]
    assert seen["length"] == pytest.approx(0.4)
    assert seen["force"] == pytest.approx(MASS * GRAVITY)
    assert seen["elongation"] == pytest.approx(0.25 * seen["strain"])


# ---------------------------------------------------------------- what is refused


def test_arguments_that_are_refused() -> None:
    one = actuator(start_force=1.0)
    with pytest.raises(InputError, match=r"No coupling named `centered`\. Did you mean `centred`"):
        lifted(coupling="centered")
    with pytest.raises(InputError, match="each at its own tendon"):
        MujocoActuators(hanging(1e-3, MASS), [one, one])
    with pytest.raises(InputError, match="No keyframe of the model is named `home`"):
        lifted(keyframe="home")
    with pytest.raises(ParameterError, match="both `start_force` and `slack`"):
        actuator(start_force=1.0, slack=1e-3)
    with pytest.raises(ParameterError, match="`start_force`"):
        actuator(start_force=-1.0)


MANY = Table(times=tuple(1e-3 * k for k in range(101)), values=tuple(k % 2 for k in range(101)))


@pytest.mark.parametrize(
    ("duration", "signals", "more", "error", "words"),
    [
        (0.1, {}, {}, InputError, "signal is missing for tendon wire"),
        (0.1, {"wire": 0.0, "wir": 0.0}, {}, InputError, "No tendon with an element is named `wir`"),
        (0.1, {"wire": Carrier(duty=Constant(level=0.5), frequency=10.0)}, {}, UnitError, "the drive needs W"),
        (0.0, {"wire": 0.0}, {}, ParameterError, "`duration`"),
        (0.1, {"wire": 0.0}, {"samples": 1}, InputError, "2 samples or more"),
        (0.1, {"wire": 0.0}, {"joints": ["y"]}, InputError, "No hinge or slide named `y`"),
        (0.1, {"wire": MANY}, {}, InputError, "more than one edge per time step"),
    ],
)
def test_runs_that_are_refused(duration: float, signals: Any, more: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        lifted().run(duration, signals, **more)


def test_an_unstable_model_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log
    model = weighed(MASS, 1e-3)
    data = model.begin()
    data.qvel[0] = 1e12
    with pytest.raises(SolveError, match="t = 0"):
        model.run(0.1, {"wire": 0.0}, data=data)


def test_martensite_does_not_need_mujoco() -> None:
    """Without the package the names exist, and the first use reports the line that installs it."""
    code = (
        "import sys; sys.modules['mujoco'] = None\n"
        "import martensite as ms\n"
        "assert ms.export.MujocoActuators and ms.export.TendonActuator\n"
        "try:\n    ms.export.holding_tensions('a.xml', ['wire'])\n"
        "except ms.InputError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "mujoco]" in done.stdout
