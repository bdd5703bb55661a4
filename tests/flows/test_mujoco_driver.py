"""`martensite export mujoco` with `--snippet` and `--driver`: the files run as they are written.

Source of truth: `simulate`, and the bridge that the tests of `martensite.export` compare with it;
the mechanism's own MJCF for what a snippet holds.
"""

from __future__ import annotations

import csv
import json
import math
import re
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

import mujoco as installed
from command import Command

import martensite as ms
from martensite.base.errors import InputError
from martensite.export.mjcf import bridge_of, tendon_signals, to_mjcf
from martensite.export.mjcf_snippet import to_mjcf_snippet
from martensite.export.mujoco_bridge import MujocoBridge, TendonActuator
from martensite.export.mujoco_driver import driver_text
from martensite.kernels.compiler import find_compiler
from martensite.scenario.scenario import Scenario, load
from martensite.simulate.api import simulate
from martensite.studies.platform.bench import SCENARIO as PLATFORM

mujoco: Any = installed
EXPORT = Command("export", "mujoco")
FINGER = """
[element]
kind = "wire"
material = "finger-mas"
law = "mas-hybrid"
resistance = "furst-seelecke"
diameter = "0.1 mm"
length = "440 mm"

[environment]
temperature = "295 K"
cooling = { kind = "constant", h = "200 W/m^2/K" }

[mechanism]
kind = "finger"
offset = "3.5 mm"
bracket = "10.6 mm"
stiffness = "50 N/m"
arm = "8 mm"
extension = "1 mm"
motion = "dynamic"
inertia = "1.8e-5 kg*m^2"
damping = "1e-4 N*m*s/rad"

[drive]
kind = "power"
waveform = { kind = "table", times = ["0 s", "0.1 s", "0.6 s"], values = ["0 W", "0 W", "2 W"] }

[run]
duration = "1.4 s"
samples = 71
"""
HUNG = FINGER.partition("[mechanism]")[0] + (
    '[mechanism]\nkind = "dead-weight"\nmass = "50 g"\n'
    '[drive]\nkind = "power"\nwaveform = { kind = "step", high = "1 W", at = "10 ms" }\n'
    '[run]\nduration = "0.1 s"\nsamples = 6\n'
)
WEIGHT = """<mujoco>
<include file="hung_snippet.xml"/>
<option timestep="0.002" gravity="0 0 -9.80665"/>
<worldbody>{held}
  <body pos="0 0 -0.44"><joint name="x" type="slide" axis="0 0 1"/>
    <geom type="sphere" size="0.01" mass="0.05"/>{pulled}</body></worldbody>
<keyframe><key name="high" qpos="0.1"/></keyframe>
</mujoco>"""
SITE = re.compile(r"<site .*?/>")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("finger.toml").write_text(FINGER, encoding="utf-8")
    Path("hung.toml").write_text(HUNG, encoding="utf-8")
    return tmp_path


def call(driver: str, *arguments: str) -> None:
    """A driver, in this process."""
    before, sys.argv = sys.argv, [driver, *arguments]
    try:
        runpy.run_path(driver, run_name="__main__")
    finally:
        sys.argv = before


def columns(path: str) -> dict[str, np.ndarray]:
    """A CSV by its heads."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


def weight() -> str:
    """A mass on the snippet of `hung.toml`, with its sites pasted from the comment."""
    held, pulled = SITE.findall(Path("hung_snippet.xml").read_text("utf-8").partition("-->")[0])
    Path("weight.xml").write_text(WEIGHT.format(held=held, pulled=pulled), encoding="utf-8")
    return "weight.xml"


# ---------------------------------------------------------------- the driver


def degrees_apart(driven: dict[str, np.ndarray], scenario: Scenario) -> float:
    """Angle of a driver and of our own run, where they are farthest apart."""
    ours = simulate(
        scenario.system,
        scenario.waveform,
        scenario.duration,
        step=2e-3,
        samples=scenario.samples,
        runtime="c" if find_compiler() else "floats",
    )
    np.testing.assert_allclose(driven["time"], ours.times, atol=1e-9)
    assert math.degrees(max(ours["angle"])) > 30.0
    return math.degrees(np.abs(driven["angle"] - np.array(ours["angle"])).max())


def test_the_driver_runs_as_written() -> None:
    """A process of its own: step for step the bridge, and our own run within 0.1°."""
    EXPORT.fine("finger.toml", "--driver")
    command = [sys.executable, "-W", "error", "finger_driver.py"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "wrote finger_driver.csv"
    driven, scenario = columns("finger_driver.csv"), load("finger.toml")
    _, bridge = bridge_of(scenario.system)
    same = bridge.run(1.4, tendon_signals(scenario.system, scenario.waveform), samples=71)
    assert set(driven) == {"time", "angle", *(f"element.{n}" for n in same.tendons["element"])}
    for name, column in driven.items():
        assert column.tolist() == same[name]
    assert degrees_apart(driven, scenario) < 0.1


def test_another_model_is_noticed() -> None:
    """The comparison above can fail; and a model of one's own goes by argument."""
    EXPORT.fine("finger.toml", "--driver", "--timestep", "2 ms")
    EXPORT.fine("finger.toml", "--set", 'mechanism.offset="3.7 mm"', "--out", "other.xml")
    call("finger_driver.py", "other.xml", "--csv", "other.csv")
    assert degrees_apart(columns("other.csv"), load("finger.toml")) > 1.0


def test_a_weight_of_ones_own() -> None:
    """Snippet and driver for a mechanism without a model: it hangs at rest, then rises."""
    files = EXPORT.report("hung.toml", "--snippet", "--driver")["files"]
    assert files == ["hung_snippet.xml", "hung_driver.py"]
    call("hung_driver.py", weight())
    driven = columns("hung_driver.csv")
    assert driven["element.force"][0] == pytest.approx(0.05 * 9.80665)
    call("hung_driver.py", "weight.xml", "--set", "drive.waveform.high=0 W", "--csv", "cold.csv")
    assert np.abs(columns("cold.csv")["x"]).max() < 1e-9
    call("hung_driver.py", "weight.xml", "--hold", "--keyframe", "high", "--csv", "held.csv")
    held = columns("held.csv")
    assert held["x"][0] == 0.1
    assert held["element.force"][0] == pytest.approx(0.05 * 9.80665, rel=1e-6)
    np.testing.assert_allclose(held["x"] - 0.1, driven["x"], atol=1e-6)


def test_the_viewer_follows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every step is shown, until the window is closed."""
    EXPORT.fine("finger.toml", "--driver", "--set", "run.duration=0.04 s")
    seen: list[float] = []

    class Window:
        def __init__(self, model: Any, data: Any) -> None:
            self.data = data

        def __enter__(self) -> Window:
            return self

        def __exit__(self, *_: object) -> None:
            seen.append(-1.0)

        def is_running(self) -> bool:
            return len(seen) < 12

        def sync(self) -> None:
            seen.append(self.data.time)

    viewer = type(sys)("mujoco.viewer")
    monkeypatch.setattr(viewer, "launch_passive", Window, raising=False)
    monkeypatch.setitem(sys.modules, "mujoco.viewer", viewer)
    call("finger_driver.py", "--view")
    assert seen == [*(pytest.approx(2e-3 * k) for k in range(1, 13)), -1.0]
    assert columns("finger_driver.csv")["time"][-1] <= 0.024 + 1e-9


def test_a_film_is_drawn(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    EXPORT.fine("finger.toml", "--driver", "--set", "run.duration=0.01 s")
    drawn: list[Any] = []

    def draw(model: Any, result: ms.export.MujocoResult, path: Path, *, camera: str | None) -> Path:
        drawn.append((model.ntendon, len(result.poses), camera))
        return path

    monkeypatch.setattr(ms.export, "render_mujoco", draw)
    call("finger_driver.py", "--film", "finger.mp4")
    assert drawn == [(1, 6, "view")]
    assert "wrote finger.mp4" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("none.xml",), "error: There is no MJCF file `none.xml`"),
        (("--set", "drive.waveform.levle=1"), "levle"),
        (("--keyframe", "up"), "No keyframe of the model is named `up`"),
        (("--csv", "none/finger.csv"), "The folder of `none/finger.csv` does not exist"),
    ],
)
def test_what_a_driver_refuses(arguments: tuple[str, ...], words: str) -> None:
    EXPORT.fine("finger.toml", "--driver", "--set", "run.duration=0.01 s")
    with pytest.raises(SystemExit) as ended:
        call("finger_driver.py", *arguments)
    assert words in str(ended.value)
    assert "\n" not in str(ended.value)


def test_fast_switching_is_refused() -> None:
    wave = {"kind": "triangle", "high": "1 W", "frequency": "400 Hz"}
    inline = ", ".join(f'{name} = "{value}"' for name, value in wave.items())
    EXPORT.fine("finger.toml", "--driver", "--set", f"drive.waveform={{ {inline} }}")
    with pytest.raises(SystemExit, match=r"The drive of `element` switches more than once in 0.002"):
        call("finger_driver.py")


NASTY = 'a = "\\\\ \\u00e9 é ß"\nb = \'\'\'x"""y\'\'\'\nc = """\\"""z"""\n# $NAME ${SOURCE} \\'


@pytest.mark.parametrize("text", [FINGER, NASTY, '# "', '# ""'])
def test_the_text_of_a_scenario_is_kept(text: str, tmp_path: Path) -> None:
    path = tmp_path / 'a "b" c.py'
    written = driver_text(load("finger.toml").system, text, path, source=tmp_path / "x" / "f.toml")
    path.write_text(written, encoding="utf-8")
    found = runpy.run_path(str(path))
    assert found["SCENARIO"].strip() == text.strip()
    assert found["SOURCE"] == tmp_path / "x" / "f.toml"
    assert found["MODEL"] is None


def test_files_are_found_from_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Model, scenario and modules of one's own, whatever folder the driver is called from."""
    (tmp_path / "out").mkdir()
    Path("own.py").write_text("LOADED = True\n", encoding="utf-8")
    report = EXPORT.report(
        "finger.toml", "--driver", "out/move.py", "--import", "own.py", "--set", "run.duration=0.01 s"
    )
    assert report["files"] == ["finger.xml", "out/move.py"]
    monkeypatch.delitem(sys.modules, "own")
    monkeypatch.chdir(tmp_path / "out")
    call("../out/move.py")
    assert sys.modules["own"].LOADED
    assert len(columns("move.csv")["time"]) == 6


# ---------------------------------------------------------------- the snippet


def test_a_snippet_is_what_the_model_holds() -> None:
    """The finger without its element, with the snippet in its place, moves as it did."""
    scenario = load("finger.toml")
    root = ElementTree.fromstring(to_mjcf(scenario.system))
    for name in ("tendon", "actuator", "custom"):
        for section in root.findall(name):
            root.remove(section)
    ElementTree.SubElement(root, "include", file="snippet.xml")
    snippet = to_mjcf_snippet(scenario.system)
    model = mujoco.MjModel.from_xml_string(
        ElementTree.tostring(root, encoding="unicode"), {"snippet.xml": snippet.encode()}
    )
    _, whole = bridge_of(scenario.system)
    one, start = scenario.single_system, float(whole.strands[0].force)
    wire = TendonActuator(
        tendon="element", element=one.element, environment=one.environment, source=one.source, start_force=start
    )
    pasted = MujocoBridge(model, [wire], coupling="centred")
    for bridge in (whole, pasted):
        bridge.run(0.2, {"element": 2.0})
    assert pasted.data.qpos[0] == pytest.approx(whole.data.qpos[0], rel=1e-12)
    assert pasted.data.ctrl[0] == pytest.approx(pasted.observe()["element"]["force"], rel=0.05)
    assert pasted.data.ctrl[0] > start
    assert f"element: {start:.6g} N" in snippet


def test_sites_stand_under_their_bodies() -> None:
    """Those of the platform: three in the base, three in the plate, as in its model."""
    system = load(PLATFORM).system
    root, text = ElementTree.fromstring(to_mjcf(system)), to_mjcf_snippet(system)
    comment, _, document = text.partition("-->")
    world, plate = comment.split('in <body name="plate">:')
    for part, body in ((world, "worldbody"), (plate, "worldbody/body[@name='plate']")):
        found = [ElementTree.fromstring(site).attrib for site in SITE.findall(part)]
        assert found == [site.attrib for site in root.findall(f"{body}/site")]
        assert len(found) == 3
    pasted = ElementTree.fromstring(document)
    assert [m.attrib["tendon"] for m in pasted.findall("actuator/motor")] == list(system.actuators())
    assert {m.attrib["gear"] for m in pasted.findall("actuator/motor")} == {"-1"}


def test_a_snippet_hints_at_contacts() -> None:
    EXPORT.fine("hung.toml", "--snippet")
    text = Path("hung_snippet.xml").read_text(encoding="utf-8")
    assert '<flag contact="disable"/>' in text.partition("-->")[0]
    assert list(ElementTree.fromstring(text).iter("flag")) == []


# ---------------------------------------------------------------- the command


def test_drivers_by_name() -> None:
    EXPORT.fine("--driver", "finger.toml")
    assert Path("finger_driver.py").is_file()
    EXPORT.fine("finger.toml", "--driver", "own.py", "--force")
    assert Path("own.py").is_file()
    for name in ("finger_driver.py", "own.py"):
        compile(Path(name).read_text(encoding="utf-8"), name, "exec")


def test_what_is_left_out_is_said() -> None:
    pulled = (
        HUNG.partition("[mechanism]")[0] + '[mechanism]\nkind = "testing-machine"\ncontrol = "elongation"\n[drive]\n'
        'kind = "power"\nwaveform = { kind = "constant", level = "0 W" }\n[signals]\n'
        'command = { kind = "constant", level = "0 mm" }\n[run]\nduration = "1 s"\n'
    )
    Path("pulled.toml").write_text(pulled, encoding="utf-8")
    assert EXPORT.report("pulled.toml", "--snippet")["left_out"] == ["command"]
    said = EXPORT.fine("pulled.toml", "--snippet", "--force")
    assert "signal `command` of the mechanism is left out" in said


@pytest.mark.parametrize("there", ["finger.xml", "finger_driver.py"])
def test_files_are_not_replaced(there: str) -> None:
    Path(there).write_text("mine", encoding="utf-8")
    assert "use --force to replace it" in EXPORT.refused("finger.toml", "--driver")
    names = sorted(path.name for path in Path().glob("finger*"))
    assert names == sorted({"finger.toml", there})
    assert Path(there).read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("hung.toml", "--driver"), "cannot be written as MJCF; .* `martensite export mujoco --sn"),
        (("finger.toml", "--driver", "a.txt"), "`a.txt` must end in .py"),
        (("finger.toml", "--snippet", "--out", "a.txt"), "`a.txt` must end in .xml"),
        (("finger.toml", "--driver", "none/a.py"), "There is no folder `none`"),
    ],
)
def test_bad_input_is_one_sentence(arguments: tuple[str, ...], words: str) -> None:
    assert re.search(words, EXPORT.refused(*arguments))
    assert [*Path().glob("*.xml"), *Path().glob("*.py")] == []


def test_a_controller_cannot_be_played() -> None:
    from fences import ROOT

    said = EXPORT.refused(str(ROOT / "examples" / "closed_loop.toml"), "--snippet", "--driver")
    assert "this scenario has a controller" in said
    assert list(Path().glob("closed_loop*")) == []


def test_a_model_of_blocks_has_no_element() -> None:
    from fences import ROOT

    system = load(ROOT / "examples" / "model_run.toml").system
    with pytest.raises(InputError, match="no shape-memory element in model"):
        to_mjcf_snippet(system)
    with pytest.raises(InputError, match="no shape-memory element in model"):
        driver_text(system, "", Path("a.py"), source=Path("a.toml"))


def test_the_report_is_that_of_the_model() -> None:
    report = json.loads(EXPORT.fine("finger.toml", "--driver", "--json"))
    assert report["mechanism"] == "finger"
    assert list(report["tendons"]) == ["element"]
    assert report["files"] == ["finger.xml", "finger_driver.py"]
    assert Path("finger.xml").read_text("utf-8") == to_mjcf(load("finger.toml").system)
