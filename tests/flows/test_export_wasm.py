"""`martensite export wasm`: the numbers of the C, in lanes and through the script, and what is refused.

Source of truth: the same core in C of this machine; `math` of Python for what stands for libm. What zig compiles
is tried where zig is (the extra `cc`, 440 MB, is not part of the development environment).
"""

from __future__ import annotations

import ctypes
import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
from benchmarks.wasm_runs import NativeLanes, call_node, play_module, say_missing, write_module
from builders import problem_a
from c_cores import Called
from fences import ROOT, fences
from one_wire import THIN_WIRE
from typer.testing import CliRunner, Result

from martensite.cli import app
from martensite.export.c_core import build_c_core
from martensite.export.c_example import Step, list_run_inputs
from martensite.export.fmu import binaries
from martensite.export.wasm import build_wasm, module
from martensite.scenario.scenario import load

SCENARIO = (
    THIN_WIRE
    + """
[drive]
kind = "current"
waveform = { kind = "step", high = "0.3 A", at = "0.5 s", until = "2 s" }

[run]
duration = "4 s"
"""
)
STEPS: list[Step] = [(0.02, (3.0 * (k % 50 < 20),)) for k in range(200)]
MOST = 40_000
"""Bytes of the module of a wire, compressed."""
PAGE = ROOT / "docs/howto/export-wasm.md"


def call(*arguments: str) -> Result:
    return CliRunner(env={"COLUMNS": "140"}).invoke(app, ["export", "wasm", *arguments])


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("wire.toml").write_text(SCENARIO, encoding="utf-8")
    return "wire.toml"


@pytest.fixture
def zig() -> None:
    """Skip where modules can be neither made nor played."""
    missing = say_missing()
    if missing:
        pytest.skip(f"WebAssembly is not tried: there is no {missing}")


# ---------------------------------------------------------------- in C of this machine


def test_lanes_are_the_core_bit_for_bit(c_compiler: str, tmp_path: Path) -> None:
    """Rows after every third step and the last one; a lane that cannot go on stops, and no other."""
    core = build_c_core(problem_a(), name="wire")
    one, lanes = Called(core, tmp_path), NativeLanes(core, tmp_path, 3, ["-O0"])
    assert one.start(0.0) == 0
    lanes.start([0.0])
    meant = []
    for k, (dt, inputs) in enumerate(STEPS):
        one.step(*inputs, dt=dt)
        if k % 3 == 2 or k + 1 == len(STEPS):
            meant.append(one.observe(*inputs)[1])
    lanes.models[1, len(core.parameters) + core.constants] = math.nan
    chosen = [2, 0]
    rows, _ = lanes.run(STEPS, 3, chosen)
    assert lanes.taken.tolist() == [200, 0, 200]
    assert lanes.status[1] > 1 and np.isnan(rows[:, :, 1]).all()
    for lane in (0, 2):
        assert rows[:, :, lane].tolist() == [[row[k] for k in chosen] for row in meant]


def test_functions_that_stand_for_libm(c_compiler: str, tmp_path: Path) -> None:
    core = build_c_core(problem_a(), name="a")
    names = ("pow", "tanh", "erfc")
    text = module.list_sources(core)["math.h"].replace(" erfc(", " own_erfc(")
    for name in names:
        text = text.replace(f" {name}(", f" own_{name}(")
    calls = "".join(
        f"double try_{name}(double x, double y) {{ return own_{name}({'x, y' if name == 'pow' else 'x'}); }}\n"
        for name in names
    )
    (tmp_path / "own.c").write_text(text + calls, encoding="utf-8")
    library = tmp_path / "own.so"
    subprocess.run([c_compiler, "-O1", "-fPIC", "-shared", "own.c", "-o", library, "-lm"], cwd=tmp_path, check=True)
    loaded = ctypes.CDLL(str(library))
    points = {
        "pow": [(x, y) for x in (1e-12, 0.3, 1.0, 7.5, 1e9) for y in (-2.5, -0.1, 0.0, 0.7, 12.3)],
        "tanh": [(x, 0.0) for x in np.linspace(-20.0, 20.0, 4001).tolist()],
        "erfc": [(x, 0.0) for x in np.linspace(0.0, 5.0, 501).tolist()],
    }
    for name, every in points.items():
        function = getattr(loaded, f"try_{name}")
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * 2
        for point in every:
            meant = getattr(math, name)(*point[: 2 if name == "pow" else 1])
            assert function(*point) == pytest.approx(meant, rel=1e-13, abs=0.0), (name, point)


# ---------------------------------------------------------------- refusals


def test_without_a_compiler_it_says_what_brings_one(scenario: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binaries.shutil, "which", lambda _: None)
    monkeypatch.setattr(binaries, "find_spec", lambda _: None)
    done = call(scenario)
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "WebAssembly is compiled by zig, which is not installed; run `pip install" in done.stderr
    assert not Path("wire_wasm").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--part", "plants"), "Did you mean `plant`"),
        (("--name", "a-b"), "try `a_b`"),
        (("--out", "a/b"), "folder `a`"),
    ],
)
def test_bad_input_is_one_sentence(scenario: str, arguments: tuple[str, ...], words: str) -> None:
    done = call(scenario, *arguments)
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert words in done.stderr


# ---------------------------------------------------------------- with zig and Node.js

TRIED = """
import { load, parameters, signals, outputs, ModelError } from "./wire_wasm/wire.js";
const program = await load(), model = program.create(), three = program.create({ lanes: 3, parameters: PARAMETERS });
const drive = Object.keys(signals)[0];
const heat = (one, value) => one.step(0.02, { [drive]: value });
for (let k = 0; k < 40; k++) heat(model, 0.3);
const saved = model.save(), twice = [0, 1].map(() => {
  model.restore(saved);
  const seen = [];
  for (let k = 0; k < 5; k++) { heat(model, 0.1 * k); seen.push(model.read("temperature"), model.time); }
  return JSON.stringify(seen);
});
three.run({ dt: 0.02, steps: 40, signals: { [drive]: 0.3 }, outputs: [] });
const alone = program.create({ parameters: { "element.diameter": 0.2e-3 } });
for (let k = 0; k < 40; k++) heat(alone, 0.3);
const refused = (call) => { try { call(); return ""; } catch (error) { return `${error.name}: ${error.message}`; } };
console.log(JSON.stringify({
  imports: WebAssembly.Module.imports(program.module).length,
  same: twice[0] === twice[1],
  lanes: [...three.column("temperature")],
  alone: alone.read("temperature"),
  units: [outputs.temperature.unit, parameters["element.diameter"].unit],
  step: refused(() => model.step(-1)),
  signal: refused(() => heat(model, NaN)),
  kept: refused(() => heat(model, 0.1)),
  row: refused(() => model.run({ dt: 0.02, signals: { [drive]: [1, NaN] }, steps: 2 })),
  set: refused(() => model.set({ "element.diameter": -1 })),
  name: refused(() => model.step(0.1, { none: 1 })).slice(0, 40),
  diameter: model.get("element.diameter"),
  foreign: refused(() => three.restore(saved)),
}));
"""


def test_a_wire_is_written_and_held_by_its_script(zig: None, scenario: str) -> None:
    done = call(scenario, "--json")
    assert (done.exit_code, done.stderr) == (0, ""), done.output
    report = json.loads(done.stdout)
    assert report["files"] == [f"wire_wasm/{name}" for name in ("wire.wasm", "wire.js", "wire.d.ts", "README.md")]
    assert report["packed_bytes"] < MOST
    Path("package.json").write_text('{"type": "module"}', encoding="utf-8")
    parameters = '{ "element.diameter": [0.1e-3, 0.2e-3, 0.3e-3] }'
    found = json.loads(call_node(Path(), TRIED.replace("PARAMETERS", parameters)))
    diameter = load(scenario).system.value_of("element.diameter")
    assert (found["imports"], found["same"], found["units"], found["diameter"]) == (0, True, ["K", "m"], diameter)
    assert found["lanes"][1] == found["alone"] and len(set(found["lanes"])) == 3
    assert found["step"].startswith("ModelError: Lane 0 failed to go on by -1 s: an argument is not finite")
    assert found["signal"] == found["row"] == "RangeError: All signals must be finite." and found["kept"] == ""
    assert found["set"].startswith("ModelError: Lane 0 failed to take these parameters")
    assert found["name"] == 'RangeError: There is no signal "none". V'
    assert found["foreign"].startswith("RangeError: These numbers were not saved")
    assert call(scenario).exit_code == 2  # the files are there


LOOSE = {"clamped_wire": 1e-11, "closed_loop_platform": 1e-9, "closed_loop_sensorless": 1e-11}
"""Of examples that make more of the last bit in which one libm differs from another."""
RATIOS = ("estimated.nis",)
"""What is a ratio of roundings while an observer has nothing to correct."""
LEFT_OUT = {
    **dict.fromkeys(("fit_flexinol_trained", "fit_isobaric", "fit_nitihf"), "no scenario, but what is fitted to one"),
    **dict.fromkeys(("flexinol_trained", "isobaric_log", "nitihf"), "follows a log, and does not load by itself"),
}
EXAMPLES = sorted({path.stem for path in (ROOT / "examples").glob("*.toml")} - set(LEFT_OUT))
QUICK = ("pwm_bias_spring", "closed_loop_beam")


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in EXAMPLES]
)
def test_examples_are_those_in_c(zig: None, tmp_path: Path, name: str) -> None:
    """After every step, as a share of the largest value of each output."""
    scenario = load(ROOT / f"examples/{name}.toml")
    first, steps = list_run_inputs(scenario.whole, scenario.waveform, scenario.duration, 400)
    made = build_wasm(scenario.whole, name="model", first=first)
    write_module(made, tmp_path)
    found, said = play_module(made, tmp_path, steps)
    lanes = NativeLanes(made.core, tmp_path, 1)
    lanes.start(first)
    meant = lanes.run(steps, 1, range(len(made.core.outputs)))[0][:, :, 0]
    assert said["status"] in ("ok", "long step") and len(found) == len(steps) + 1
    largest = np.maximum(np.abs(meant).max(axis=0), 1e-300)
    error = np.abs(found[1:] - meant).max(axis=0) / largest
    kept = [one.name not in RATIOS for one in made.core.outputs]
    assert error[kept].max() < LOOSE.get(name, 1e-12)


def test_the_script_of_the_page_prints_what_it_says(zig: None, tmp_path: Path) -> None:
    page, system = fences(PAGE), load(ROOT / "examples/pwm_bias_spring.toml").whole
    scripts = [k for k, one in enumerate(page) if one.language == "js"]
    write_module(build_wasm(system, name="spring"), tmp_path)
    for k in scripts:
        assert call_node(tmp_path, page[k].text) == page[k + 1].text
