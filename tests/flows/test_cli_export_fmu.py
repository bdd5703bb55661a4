"""`martensite export fmu`: what it writes and says, and what it refuses.

Source of truth: the options as documented, and the scenario.
"""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest
from one_wire import THIN_WIRE
from typer.testing import CliRunner, Result

from martensite.cli import app

SCENARIO = (
    THIN_WIRE.partition("[mechanism]")[0]
    + """[mechanism]
kind = "dead-weight"
mass = "200 g"

[drive]
kind = "power"
waveform = { kind = "constant", level = "1 W" }

[run]
duration = "1 s"
samples = 11
step = "20 ms"
"""
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("lifted weight.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["export", "fmu", *arguments])


def test_it_writes_an_fmu_and_says_what_is_in_it(c_compiler: str) -> None:
    """Text; the name of the file becomes an identifier."""
    result = call("lifted weight.toml")
    assert result.exit_code == 0, result.output
    assert "1 input, " in result.output
    assert "inner step of at most 0.02 s" in result.output
    assert "inputs: drive [W]" in result.output
    assert "wrote lifted weight.fmu (FMI 2.0; " in result.output
    names = zipfile.ZipFile("lifted weight.fmu").namelist()
    assert any(Path(name).stem == "lifted_weight" for name in names if "binaries" in name)


def test_json_names_variables_with_their_references() -> None:
    """Sources alone need no compiler."""
    result = call(
        "lifted weight.toml",
        "--fmi",
        "3.0",
        "--out",
        "a.fmu",
        "--step",
        "5 ms",
        "--name",
        "weight",
        "--sources-only",
        "--set",
        "mechanism.mass=150 g",
        "--json",
    )
    assert result.exit_code == 0, result.output
    said = json.loads(result.output)
    assert (said["fmi"], said["identifier"], said["step"]) == ("3.0", "weight", 0.005)
    assert said["inputs"] == {"drive": 0}
    assert said["outputs"]["temperature"] == 100001
    assert said["parameters"]["element.diameter"] == 200000
    assert said["platforms"] == []
    text = zipfile.ZipFile("a.fmu").read("modelDescription.xml").decode()
    assert 'start="0.15"' in text
    assert said["token"] in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--fmi", "1.0"], "No version of FMI named `1.0`"),
        (["--step", "5 mm"], "cannot be converted"),
        (["--step", "-1 ms"], "`step` must be above 0"),
        (["--platform", "amiga"], "No platform named `amiga`"),
        (["--platform", "x86_64-linux", "--sources-only"], "exclude each other"),
        (["--name", "2nd"], "identifier"),
        (["--out", "a.zip"], "must end in .fmu"),
        (["--set", "element.diametre=1 mm"], "diameter"),
    ],
)
def test_bad_input_is_refused(arguments: list[str], words: str) -> None:
    """Exit code 2, one sentence, nothing written."""
    result = call("lifted weight.toml", *arguments)
    assert result.exit_code == 2
    assert words in result.output
    assert not list(Path().glob("*.fmu"))


def test_nothing_is_replaced_unasked() -> None:
    """`--force` does."""
    Path("a.fmu").write_text("kept")
    arguments = ("lifted weight.toml", "--out", "a.fmu", "--sources-only")
    assert call(*arguments).exit_code == 2
    assert Path("a.fmu").read_text() == "kept"
    assert call(*arguments, "--force").exit_code == 0
    assert zipfile.is_zipfile("a.fmu")
