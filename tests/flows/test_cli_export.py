"""`martensite export`: the file it writes, what it says, and what it refuses.

Source of truth: the options as documented, and the finger at assembly.
"""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner, Result

from martensite.cli import app
from martensite.export.mjcf import to_mjcf
from martensite.scenario.scenario import load

FINGER = """
[element]
kind = "wire"
material = "finger-mas"
law = { kind = "mas-hybrid" }
resistance = { kind = "furst-seelecke" }
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

[drive]
kind = "power"
waveform = { kind = "constant", level = "1 W" }

[run]
duration = "1 s"
"""
START = 50.0 * 8e-3 * 1e-3 / (2.0 * 3.5e-3)
"""Force of the wire at assembly [N]."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("finger.toml").write_text(FINGER, encoding="utf-8")
    hung = FINGER.partition("[mechanism]")[0] + '[mechanism]\nkind = "dead-weight"\nmass = "50 g"\n'
    Path("hung.toml").write_text(hung + "[drive]" + FINGER.partition("[drive]")[2], "utf-8")
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["export", "mujoco", *arguments])


def test_the_model_is_written() -> None:
    done = call("finger.toml")
    assert (done.exit_code, done.stderr) == (0, ""), done.output
    assert "tendon `element`: 0.0571429 N at assembly" in done.stdout
    assert "wrote finger.xml" in done.stdout
    text = Path("finger.xml").read_text(encoding="utf-8")
    assert text == to_mjcf(load("finger.toml").system)
    root = ElementTree.fromstring(text)
    assert root.tag == "mujoco"
    assert float(root.findall("option")[0].attrib["timestep"]) == 2e-3


def test_options() -> None:
    done = call(
        "finger.toml", "--out", "other.xml", "--timestep", "0.5 ms", "--set", 'mechanism.offset="7 mm"', "--json"
    )
    report = json.loads(done.stdout)
    assert report["mechanism"] == "finger"
    assert report["files"] == ["other.xml"]
    assert report["tendons"] == {"element": pytest.approx(START / 2.0)}
    root = ElementTree.parse("other.xml").getroot()
    assert float(root.findall("option")[0].attrib["timestep"]) == 5e-4
    (site,) = root.findall("worldbody/site")
    assert float(site.attrib["pos"].split()[2]) == -7e-3


def test_a_file_is_not_replaced_unless_wanted() -> None:
    Path("finger.xml").write_text("mine", encoding="utf-8")
    done = call("finger.toml")
    assert done.exit_code == 2
    assert "use --force to replace it" in done.stderr
    assert Path("finger.xml").read_text(encoding="utf-8") == "mine"
    assert call("finger.toml", "--force").exit_code == 0
    assert Path("finger.xml").read_text(encoding="utf-8") != "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("hung.toml",), "`dead-weight` cannot be written as MJCF; those that can: `finger`"),
        (("finger.toml", "--set", "mechanism.friction=0.2"), "without friction"),
        (("finger.toml", "--out", "finger.mjcf"), "must end in .xml"),
        (("finger.toml", "--out", "none/finger.xml"), "There is no folder `none`"),
        (("finger.toml", "--timestep", "2"), "`2` has no unit"),
        (("finger.toml", "--timestep", "0 s"), "`--timestep` must be above 0 s"),
        (("fingr.toml",), "Did you mean `finger.toml`"),
    ],
)
def test_bad_input_is_one_sentence(arguments: tuple[str, ...], words: str) -> None:
    done = call(*arguments)
    assert done.exit_code == 2
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
    assert words in done.stderr
    assert list(Path().glob("*.xml")) == []
