"""The MuJoCo bridge: what it returns, what it refuses, contacts, slack, and pictures.

Source of truth: the contract of the bridge, and statics of its small models.
"""

from __future__ import annotations

import inspect
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

import mujoco as installed
from builders import example, law_a
from matplotlib.image import imread
from mujoco_cases import GRAVITY, actuator, hanging, lever, weighed

import martensite as ms
from martensite.actuators.assembly import OUTPUTS
from martensite.actuators.elements.base import ELEMENTS
from martensite.base.errors import InputError, MartensiteError, ParameterError, SolveError, UnitError
from martensite.base.status import Status
from martensite.export import balance, mujoco_render
from martensite.export.balance import LineStepEnd, settle_lines
from martensite.export.mujoco_bridge import MujocoBridge, TendonActuator, holding_tensions, read_model
from martensite.export.mujoco_render import draw_poses, render_mujoco
from martensite.export.mujoco_result import MujocoResult
from martensite.signals.carrier import Carrier
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.table import Table

mujoco: Any = installed
MASS = 0.5
PULSE = Table(times=(0.0, 0.1, 0.2, 0.7, 0.8, 2.0), values=(0.0, 0.0, 3.0, 3.0, 0.0, 0.0))


def lifted(**changes: Any) -> MujocoBridge:
    """A mass that a wire can lift."""
    return MujocoBridge(hanging(2e-3, MASS), [actuator(start_force=MASS * GRAVITY)], **changes)


def pulled(more: str = "", **changes: Any) -> MujocoBridge:
    """A lever between two wires that can be heated."""
    pair = [actuator(n, diameter=0.15e-3, start_force=3.0) for n in ("wire", "other")]
    return MujocoBridge(lever(2e-3, more=more, **changes), pair)


# ---------------------------------------------------------------- what a run returns


def test_columns_of_a_run() -> None:
    bridge = lifted()
    result = bridge.run(0.5, {"wire": 12.0}, samples=26)
    assert len(result.times) == 26
    assert result.times[-1] == pytest.approx(0.5)
    assert set(result.tendons["wire"]) == {*OUTPUTS, "elongation", "length"}
    assert result["time"] == result.times
    assert result["x"][-1] == bridge.data.qpos[0] > 1e-3
    assert result.poses[-1] == [result["x"][-1]]
    assert result["wire.power"][-1] == pytest.approx(12.0)
    length = result["wire.length"]
    assert length[-1] == pytest.approx(0.3 - result["x"][-1])
    grown = [e - result["wire.elongation"][0] for e in result["wire.elongation"]]
    assert grown == pytest.approx([one - length[0] for one in length], abs=1e-15)
    assert result.status in (Status.OK, Status.LONG_STEP)
    assert (result.steps, result.step, result.turns) == (250, 2e-3, 1)
    assert result.error < 1e-6


def test_a_taut_element_is_as_long_as_its_tendon() -> None:
    result = lifted().run(0.5, {"wire": 12.0}, samples=11)
    strain = [e / 0.25 for e in result["wire.elongation"]]
    assert result["wire.strain"] == pytest.approx(strain, abs=1e-9)


def test_two_runs_are_one() -> None:
    whole, parts = lifted(), lifted()
    ramp = Ramp(high=12.0, end=0.5)
    whole.run(0.4, {"wire": ramp})
    parts.run(0.2, {"wire": ramp})
    parts.run(0.2, {"wire": ramp})
    assert parts.data.qpos[0] == whole.data.qpos[0]
    assert parts.observe() == whole.observe()


def test_steps_by_hand_are_a_run() -> None:
    bridge, other = lifted(), lifted()
    for _ in range(20):
        solved = bridge.step({"wire": 12.0})
    other.run(0.04, {"wire": 12.0})
    assert bridge.data.qpos[0] == other.data.qpos[0]
    assert solved.tensions == pytest.approx([bridge.observe()["wire"]["force"]], rel=1e-9)


def limited() -> MujocoBridge:
    """A mass on a wire that may be 330 K hot."""
    one = actuator(start_force=MASS * GRAVITY, law=law_a())
    limits = one.element.limits.with_values({"temperature_limit": 330.0})
    return MujocoBridge(hanging(2e-3, MASS), [one.with_parts(element=one.element.with_parts(limits=limits))])


def test_alarms_name_the_tendon() -> None:
    result = limited().run(1.0, {"wire": 12.0})
    assert [(alarm.kind, alarm.port) for alarm in result.alarms] == [("temperature", "wire")]
    assert result.warnings[0].startswith("Warning: `wire`: temperature reaches")


def test_alarms_come_from_every_step_and_not_from_the_samples() -> None:
    """Source of truth: a run with a sample at every step."""
    pulse = Table(times=(0.0, 0.1, 0.11, 0.6, 0.61, 4.0), values=(0.0, 0.0, 12.0, 12.0, 0.0, 0.0))
    few, many = (limited().run(4.0, {"wire": pulse}, samples=samples) for samples in (2, 2001))
    assert few.alarms == many.alarms
    assert [alarm.kind for alarm in few.alarms] == ["temperature"]
    assert few["wire.temperature"][-1] < 320.0


@pytest.mark.parametrize("name", ELEMENTS.names())
def test_any_element(name: str) -> None:
    """Heated for a moment under a small weight, every one contracts and carries it."""
    one = actuator(start_force=0.05 * GRAVITY).with_parts(element=example(ELEMENTS[name]))
    result = MujocoBridge(hanging(2e-3, 0.05), [one]).run(0.1, {"wire": 3.0}, samples=3)
    assert result["x"][-1] > 1e-5
    assert result["wire.force"][-1] == pytest.approx(0.05 * GRAVITY, rel=0.5)
    assert result["wire.temperature"][-1] > 293.15 + 0.5
    assert result.error < 1e-6


def test_a_tendon_may_turn_its_actuator() -> None:
    """`gear=-2` on the other wire of the lever: gain and sign are those of the model."""
    bridge = pulled()
    bridge.run(0.5, {"wire": 0.0, "other": 0.0})
    assert bridge.data.ctrl[0] == pytest.approx(-3.0, rel=0.02)
    assert bridge.data.ctrl[1] == pytest.approx(1.5, rel=0.02)
    assert abs(bridge.data.qpos[0]) < 1e-3


# ---------------------------------------------------------------- several, slack, contacts


def test_antagonists_in_turn() -> None:
    heats = {"wire": PULSE, "other": 0.0}
    result = pulled().run(2.0, heats)
    assert min(result["hinge"]) < math.radians(-4.0)
    assert result.error < 1e-6
    assert max(result["other.force"]) > 3.4
    back = {"wire": 0.0, "other": PULSE}
    mirrored = pulled().run(2.0, back)
    assert mirrored["hinge"] == pytest.approx([-q for q in result["hinge"]], abs=1e-5)


def test_light_levers_between_stiff_wires() -> None:
    """dt² S of 5 and of 500 times the compliance of a wire: the same motion without inertia."""
    heats = {"wire": PULSE, "other": 0.0}
    light, lighter = (pulled(inertia=i).run(2.0, heats, samples=101) for i in (1e-7, 1e-9))
    assert max(light.error, lighter.error) < 1e-6
    assert max(light.asked, lighter.asked) <= 8
    assert light["hinge"] == pytest.approx(lighter["hinge"], abs=1e-3)
    assert min(light["hinge"]) < math.radians(-4.0)


def test_a_slack_wire_does_not_push() -> None:
    slack = 1e-3
    one = actuator(slack=slack, elastic=True)
    bridge = MujocoBridge(hanging(1e-4, MASS), [one])
    result = bridge.run(0.02, {"wire": 0.0}, samples=201)
    taut = next(k for k, force in enumerate(result["wire.force"]) if force > 0.0)
    assert result.times[taut] == pytest.approx(math.sqrt(2.0 * slack / GRAVITY), rel=0.02)
    assert -result["x"][taut] > slack >= -result["x"][taut - 1]
    assert min(result["wire.force"]) == 0.0
    assert [alarm.kind for alarm in result.alarms] == []  # it was slack from the start


def test_a_joint_limit_is_met() -> None:
    """Where the line of a step has a kink, it is laid anew until the forces agree."""
    bridge = pulled('range="-2 2" limited="true" solreflimit="0.004 1"')
    result = bridge.run(2.0, {"wire": PULSE, "other": 0.0})
    assert math.degrees(min(result["hinge"])) == pytest.approx(-2.0, abs=0.3)
    assert result.turns > 1
    assert result.error < 1e-4


def test_a_floor_carries_the_mass() -> None:
    model = hanging(1e-3, MASS).replace("<worldbody>", '<worldbody><geom type="plane" size="1 1 1" pos="0 0 0.68"/>')
    bridge = MujocoBridge(model, [actuator(elastic=True, slack=0.05)])
    result = bridge.run(0.5, {"wire": 0.0}, samples=51)
    assert result["x"][-1] == pytest.approx(-0.01, abs=1e-3)
    assert max(result["wire.force"]) == 0.0


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit", "RK4"])
def test_any_integrator(integrator: str) -> None:
    model = hanging(1e-3, MASS).replace("<option", f'<option integrator="{integrator}"')
    bridge = MujocoBridge(model, [actuator(start_force=MASS * GRAVITY)])
    result = bridge.run(1.0, {"wire": 12.0}, samples=3)
    assert result.error < 1e-6
    assert result["x"][-1] == pytest.approx(9.5e-3, rel=0.1)


# ---------------------------------------------------------------- what holds a pose


def test_a_weight_is_held_by_its_weight() -> None:
    text = hanging(1e-3, MASS)
    assert holding_tensions(text, ["wire"])["wire"] == pytest.approx(MASS * GRAVITY, rel=1e-6)
    moving = mujoco.MjData(read_model(text))
    moving.qvel[0] = 3.0
    held = holding_tensions(moving.model, ["wire"], data=moving)
    assert held["wire"] == pytest.approx(MASS * GRAVITY, rel=1e-6)
    assert moving.qvel[0] == 3.0


def test_of_two_wires_the_one_that_is_needed_holds() -> None:
    model = lever(1e-3, stiffness=0.01, springref=math.degrees(-1.2))
    held = holding_tensions(model, ["wire", "other"])
    assert held["other"] == pytest.approx(0.01 * 1.2 / 0.004, rel=1e-6)
    assert held["wire"] == 0.0
    with pytest.raises(SolveError, match="No tensions of wire hold the model"):
        holding_tensions(model, ["wire"])


# ---------------------------------------------------------------- the balance by itself


def springs(compliances: list[float]) -> list[Callable[[float, float], LineStepEnd]]:
    """Linear springs that cannot push."""

    def trial(compliance: float) -> Callable[[float, float], LineStepEnd]:
        def answer(reach: float, give: float) -> LineStepEnd:
            force = max(reach / (compliance + give), 0.0)
            return LineStepEnd((), force, 0.0, compliance, 0.0, 0.0)

        return answer

    return [trial(c) for c in compliances]


def test_balance_of_many_springs_that_yield_to_each_other() -> None:
    """Twelve springs on two coordinates, far stiffer than these: forces as by linear algebra."""
    import numpy as np

    rng = np.random.default_rng(5)
    levers = rng.normal(size=(12, 2))
    give, compliances = 50.0 * levers @ levers.T, rng.uniform(0.5, 2.0, 12)
    reach = rng.uniform(-0.5, 1.0, 12)
    found = settle_lines(springs(list(compliances)), list(reach), give.tolist(), [0.0] * 12, [1e-3] * 12)
    forces = np.array([answer.force for answer in found.answers])
    gap = reach - give @ forces - compliances * forces  # 0 where taut, below where slack
    assert found.error < 1e-8
    assert (forces == 0.0).any()
    assert abs(gap[forces > 0.0]).max() < 1e-6
    assert (gap[forces == 0.0] < 1e-9).all()


def test_newton_is_what_makes_it_fast(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two stiff wires on a light lever: plain sweeps alone are not done after 60."""
    give, reach = [[100.0, -100.0], [-100.0, 100.0]], [3.0, 2.0]
    fast = settle_lines(springs([1.0, 1.0]), reach, give, [0.0, 0.0], [1e-3, 1e-3])
    monkeypatch.setattr(balance, "PLAIN", 1)
    slow = settle_lines(springs([1.0, 1.0]), reach, give, [0.0, 0.0], [1e-3, 1e-3])
    assert fast.error < 1e-9
    assert fast.asked < 8
    assert (slow.asked, slow.error > 1e-3) == (60, True)


# ---------------------------------------------------------------- what is refused


def without(line: str) -> str:
    """The hanging mass without a line of its model."""
    return hanging(1e-3, MASS).replace(line, "")


LINE = '<general tendon="wire" gainprm="1" biastype="none"/>'
LIMITED = LINE.replace("/>", ' ctrlrange="-1 1" ctrllimited="true"/>')
BIASED = LINE.replace('"none"', '"affine" biasprm="0 -1 0"')


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (without(LINE), r"exactly one .* has 0; add the line <actuator><general tendon=\"wire\""),
        (hanging(1e-3, MASS).replace(LINE, LINE + LINE), "exactly one actuator .* has 2"),
        (hanging(1e-3, MASS).replace(LINE, BIASED), "exactly one actuator .* has 0"),
        (hanging(1e-3, MASS).replace(LINE, LIMITED), "limits its control"),
        (
            hanging(1e-3, MASS).replace('name="wire"', 'name="wirr"').replace('tendon="wire"', 'tendon="wirr"'),
            "No tendon .* `wire`. Did you mean `wirr`",
        ),
        ("no-such-file.xml", "There is no MJCF file `no-such-file.xml`"),
        ("<mujoco><wrong/></mujoco>", "MuJoCo cannot read the model"),
        (
            hanging(1e-3, MASS).replace("/>\n<worldbody>", '><flag actuation="disable"/></option>\n<worldbody>'),
            "disables actuation",
        ),
    ],
)
def test_models_that_cannot_be_driven(model: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        MujocoBridge(model, [actuator(start_force=1.0)])


def test_arguments_that_are_refused() -> None:
    one = actuator(start_force=1.0)
    with pytest.raises(InputError, match=r"No coupling `centered`\. Did you mean `centred`"):
        MujocoBridge(hanging(1e-3, MASS), [one], coupling="centered")
    with pytest.raises(InputError, match="each at a tendon of its own"):
        MujocoBridge(hanging(1e-3, MASS), [one, one])
    with pytest.raises(InputError, match="No keyframe of the model is named `home`"):
        MujocoBridge(hanging(1e-3, MASS), [one], keyframe="home")
    with pytest.raises(ParameterError, match="both `start_force` and `slack`"):
        actuator(start_force=1.0, slack=1e-3)
    with pytest.raises(ParameterError, match="`start_force`"):
        actuator(start_force=-1.0)


@pytest.mark.parametrize(
    ("signals", "error", "words"),
    [
        ({"wire": math.inf}, InputError, "must be finite"),
        ({}, InputError, "signal is missing for tendon wire"),
        ({"wire": 0.0, "wir": 0.0}, InputError, "No tendon of the bridge is named `wir`"),
        ({"wire": Carrier(duty=Constant(level=0.5), frequency=10.0)}, UnitError, "takes W"),
    ],
)
def test_signals_that_are_refused(signals: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        lifted().run(0.1, signals)


def test_runs_that_are_refused() -> None:
    bridge = lifted()
    with pytest.raises(ParameterError, match="`duration`"):
        bridge.run(0.0, {"wire": 0.0})
    with pytest.raises(InputError, match="2 samples or more"):
        bridge.run(0.1, {"wire": 0.0}, samples=1)
    with pytest.raises(InputError, match="No hinge or slide named `y`"):
        bridge.run(0.1, {"wire": 0.0}, joints=["y"])
    many = Table(times=tuple(1e-3 * k for k in range(101)), values=tuple(k % 2 for k in range(101)))
    with pytest.raises(InputError, match="more than one edge per time step"):
        bridge.run(0.1, {"wire": many})


def test_a_failed_step_says_when_and_where() -> None:
    bridge = lifted()
    bridge.run(0.01, {"wire": 0.0})
    (strand,) = bridge.strands
    good = strand._step
    strand._step = lambda *state: tuple(math.nan for _ in good(*state))
    with pytest.raises(SolveError, match=r"`wire` failed in the step at t = 0.01 s\. A number"):
        bridge.step({"wire": 0.0})
    strand._step = good
    assert bridge.plant.time == pytest.approx(0.01)  # nothing was moved
    bridge.step({"wire": 0.0})


def test_an_unstable_model_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log
    bridge = weighed(MASS, 1e-3)
    bridge.data.qvel[0] = 1e12
    with pytest.raises(SolveError, match="t = 0"):
        bridge.step({"wire": 0.0})


def test_models_come_in_three_ways(tmp_path: Path) -> None:
    text = hanging(1e-3, MASS)
    path = tmp_path / "mass.xml"
    path.write_text(text, encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text)
    assert read_model(model) is model
    assert read_model(path).ntendon == read_model(str(path)).ntendon == read_model(text).ntendon == 1


def test_a_keyframe_is_where_it_starts() -> None:
    text = hanging(1e-3, MASS).replace("</mujoco>", '<keyframe><key name="low" qpos="-0.1"/></keyframe></mujoco>')
    bridge = MujocoBridge(text, [actuator(start_force=MASS * GRAVITY)], keyframe="low")
    seen = bridge.observe()["wire"]
    assert seen["length"] == pytest.approx(0.4)
    assert seen["force"] == pytest.approx(MASS * GRAVITY)
    assert seen["elongation"] == pytest.approx(0.25 * seen["strain"])


def test_martensite_does_not_need_mujoco() -> None:
    """Without the package the names exist, and the first use says what to install."""
    code = (
        "import sys; sys.modules['mujoco'] = None\n"
        "import martensite as ms\n"
        "assert ms.export.MujocoBridge and ms.export.TendonActuator and ms.export.render_mujoco\n"
        "try:\n    ms.export.MujocoBridge('a.xml', [ms.Constant(level=1)])\n"
        "except AttributeError:\n    pass\n"
        "from martensite.export.mujoco_bridge import read_model\n"
        "try:\n    read_model('a.xml')\n"
        "except ms.InputError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'martensite[mujoco]'" in done.stdout


def test_public_names_are_the_same_objects() -> None:
    assert (ms.export.MujocoBridge, ms.export.TendonActuator) == (MujocoBridge, TendonActuator)
    assert ms.export.MujocoResult is MujocoResult
    assert inspect.unwrap(ms.export.render_mujoco) is render_mujoco
    assert inspect.unwrap(ms.export.holding_tensions) is holding_tensions


# ---------------------------------------------------------------- pictures


@pytest.fixture(scope="module")
def drawn() -> tuple[Any, MujocoResult]:
    """A model and a short run; skips where nothing can draw."""
    bridge = MujocoBridge(hanging(2e-3, MASS), [actuator(slack=0.3)])
    result = bridge.run(0.2, {"wire": 0.0}, samples=6)  # it falls
    try:
        draw_poses(bridge.model, result.poses[:1], (32, 24))
    except MartensiteError as error:
        pytest.skip(str(error))
    return bridge.model, result


def test_a_picture(drawn: tuple[Any, MujocoResult], tmp_path: Path) -> None:
    path = render_mujoco(*drawn, tmp_path / "arm.png", size=(96, 64))
    picture = imread(path)
    assert picture.shape[:2] == (64, 96)
    assert picture[..., :3].std() > 0.01  # something is to be seen


def test_a_film(drawn: tuple[Any, MujocoResult], tmp_path: Path) -> None:
    from PIL import Image, ImageSequence

    path = render_mujoco(*drawn, tmp_path / "arm.gif", size=(96, 64), fps=20.0)
    with Image.open(path) as film:
        assert film.size == (96, 64)
        assert len(list(ImageSequence.Iterator(film))) == 5


def test_an_mp4(drawn: tuple[Any, MujocoResult], tmp_path: Path) -> None:
    if mujoco_render._find_ffmpeg() is None:
        pytest.skip("no ffmpeg on this machine (pip install imageio-ffmpeg)")
    path = render_mujoco(*drawn, tmp_path / "arm.mp4", size=(97, 65), fps=20.0)
    assert path.read_bytes()[4:8] == b"ftyp"


def test_a_film_without_ffmpeg_is_a_gif(
    drawn: tuple[Any, MujocoResult], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mujoco_render, "_find_ffmpeg", lambda: None)
    with pytest.warns(UserWarning, match="No ffmpeg was found"):
        path = render_mujoco(*drawn, tmp_path / "arm.mp4", size=(32, 24), fps=10.0)
    assert path == tmp_path / "arm.gif"
    assert path.is_file()


def test_no_graphics_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    bridge = lifted()
    monkeypatch.setenv("MUJOCO_GL", "no-such-way")
    with pytest.raises(MartensiteError, match=r"No OpenGL .* was found \(no-such-way: .*apt install"):
        draw_poses(bridge.model, [[0.0]], (32, 24))


@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("arm.bmp", {}, "no suffix that can be drawn"),
        ("arm.png", {"size": (0, 5)}, "must be above 0"),
        ("arm.png", {"camera": "top"}, "No camera of the model is named `top`"),
    ],
)
def test_pictures_that_are_refused(tmp_path: Path, name: str, more: Any, words: str) -> None:
    bridge = lifted()
    result = bridge.run(0.01, {"wire": 0.0})
    with pytest.raises(InputError, match=words):
        render_mujoco(bridge.model, result, tmp_path / name, **more)
