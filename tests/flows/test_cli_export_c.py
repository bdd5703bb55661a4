"""`martensite export c`: the files it writes, what it says, and what it refuses.

Source of truth: the options as documented, and `c_core` itself.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from c_cores import STRICT
from fences import ROOT
from one_wire import THIN_WIRE
from typer.testing import CliRunner, Result

from martensite.cli import app
from martensite.export import c_example
from martensite.export.c_core import build_c_core, build_c_loop
from martensite.kernels.compiler import find_compiler
from martensite.scenario.scenario import load

HELD = f"""{THIN_WIRE}
[driver]
kind = "mosfet"
supply = "5 V"
frequency = "1 kHz"

[sensor]
kind = "position"
delay = "20 ms"

[controller]
kind = "pid"
measured = "position"
period = "20 ms"
Kp = 150.0
Ki = 75.0
reference = {{ kind = "step", high = "3 mm", at = "0.1 s" }}

[run]
duration = "1 s"
"""
DRIVEN = (
    HELD.partition("[driver]")[0]
    + """
[drive]
kind = "current"
waveform = { kind = "step", high = "0.4 A", at = "0.5 s", until = "2.1 s" }

[run]
duration = "5 s"
"""
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("held.toml").write_text(HELD, encoding="utf-8")
    Path("driven.toml").write_text(DRIVEN, encoding="utf-8")
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner(env={"COLUMNS": "140"}).invoke(app, ["export", "c", *arguments])


def read(name: str) -> str:
    return Path(name).read_text(encoding="utf-8")


def test_a_bench_is_written() -> None:
    done = call("held.toml")
    assert (done.exit_code, done.stderr) == (0, ""), done.output
    core = build_c_core(load("held.toml").whole, name="held")
    assert (read("held.h"), read("held.c")) == (core.header, core.source)
    assert "wrote held.h\nwrote held.c\nwrote held_example.c" in done.stdout
    assert f"model: {core.size:,} bytes" in done.stdout
    assert "operations at most" in done.stdout
    step = next(line.split() for line in done.stdout.splitlines() if "step" in line)
    assert int(step[1]) == sum(core.operations["step"].values())


def test_the_example_runs(c_compiler: str) -> None:
    assert call("driven.toml", "--precision", "float32").exit_code == 0
    command = [find_compiler() or "", *STRICT, "driven.c", "driven_example.c", "-o", "example", "-lm"]
    subprocess.run(command, check=True)
    done = subprocess.run(["./example"], capture_output=True, text=True, check=True)
    title, *rows = (line.split(",") for line in done.stdout.splitlines())
    column = {name: [float(row[i]) for row in rows] for i, name in enumerate(title)}
    assert 400 < len(rows) < 500
    assert column["time"][-1] == pytest.approx(5.0, rel=1e-5)
    meant = load("driven.toml").run()
    assert max(column["position"]) == pytest.approx(max(meant["position"]), rel=0.01)
    assert max(column["temperature"]) == pytest.approx(max(meant["temperature"]), rel=0.01)


def test_options() -> None:
    Path("made").mkdir()
    done = call(
        "held.toml",
        "--out",
        "made",
        "--name",
        "core",
        "--part",
        "plant",
        "--set",
        'element.diameter="0.2 mm"',
        "--json",
    )
    report = json.loads(done.stdout)
    system = load("held.toml", {"element.diameter": "0.2 mm"}).system
    core = build_c_core(system, name="core")
    assert read("made/core.c") == core.source
    assert report["files"] == ["made/core.h", "made/core.c", "made/core_example.c"]
    assert (report["name"], report["part"], report["model_bytes"]) == ("core", "plant", core.size)
    assert report["operations"] == core.operations


def test_the_loop_without_its_plant() -> None:
    done = call("held.toml", "--part", "loop", "--precision", "float32", "--json")
    bench = load("held.toml").bench
    assert bench is not None
    core = build_c_loop(bench, name="held", precision="float32")
    assert read("held.c") == core.source
    assert json.loads(done.stdout)["sample_time"] == 0.02
    assert "held_u_position_age" in read("held.h")
    assert "    {1, 0.0199999996f, {" in read("held_example.c")


@pytest.mark.parametrize(("name", "time"), [("finger", "4.44"), ("antagonistic_wires", "2.68")])
def test_a_program_that_stops_is_not_written(c_compiler: str, name: str, time: str) -> None:
    """Models of activation need more than seven digits; the example, compiled by hand, stops there with status 2."""
    done = call(str(ROOT / "examples" / f"{name}.toml"), "--precision", "float32")
    assert (done.exit_code, done.stdout) == (2, "")
    assert f"In float32 this program stops at {time} s of the scenario: The coupling" in done.stderr
    assert not list(Path().glob(f"{name}*"))


def test_single_precision_says_how_far_it_was_tried(c_compiler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    tried = json.loads(call("driven.toml", "--precision", "float32", "--json").stdout)["tried"]
    assert tried == "Tried in float32 over 5 s of the scenario: it does not stop."
    loop = json.loads(call("held.toml", "--part", "loop", "--precision", "float32", "--json").stdout)["tried"]
    assert loop == "Tried in float32 over 1 s of the scenario: it does not stop."
    assert json.loads(call("driven.toml", "--json", "--force").stdout)["tried"] is None
    monkeypatch.setattr(c_example, "find_compiler", lambda: None)
    said = call("driven.toml", "--precision", "float32", "--force").stdout
    assert "Not tried: there is no C compiler here" in said


def test_a_file_is_not_replaced_unless_wanted() -> None:
    Path("driven.h").write_text("mine", encoding="utf-8")
    done = call("driven.toml")
    assert done.exit_code == 2
    assert "use --force to replace it" in done.stderr
    assert read("driven.h") == "mine"
    assert not Path("driven.c").exists()
    assert call("driven.toml", "--force").exit_code == 0
    assert read("driven.h") != "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("driven.toml", "--part", "loop"), "has no loop"),
        (("driven.toml", "--part", "plants"), "Did you mean `plant`"),
        (("driven.toml", "--precision", "float16"), "Did you mean `float"),
        (("driven.toml", "--name", "a-b"), "try `a_b`"),
        (("driven.toml", "--out", "none/deeper"), "There is no folder `none`"),
        (("drivn.toml",), "Did you mean `driven.toml`"),
    ],
)
def test_bad_input_is_one_sentence(arguments: tuple[str, ...], words: str) -> None:
    done = call(*arguments)
    assert done.exit_code == 2
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
    assert words in done.stderr
    assert list(Path().glob("*.c")) == []
