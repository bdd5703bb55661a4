"""`martensite export wasm --slopes`: derivatives that a run takes along, and what is refused.

Source of truth: `compute_sensitivity` on the same given steps, whose kernels are printed for vectors; central
differences of the module itself; and of values the module without slopes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks.wasm_runs import NativeLanes, NativeSlopes, call_node, say_missing, write_module
from builders import problem_a
from fences import ROOT, fences
from typer.testing import CliRunner

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.cli import app
from martensite.export.c_core import build_c_core
from martensite.export.c_example import Step
from martensite.export.wasm import build_wasm
from martensite.export.wasm.module import list_sources
from martensite.export.wasm.slopes import CoreSlopes, choose_slopes
from martensite.export.wasm.wrapper import read_text
from martensite.scenario.scenario import load
from martensite.signals import PulseWidthModulation
from martensite.simulate.batch import compute_sensitivity
from martensite.simulate.drive_waveforms import grid_of

MOST = 40_000
"""Bytes of a module with slopes in three directions, compressed."""
OUTPUTS = ("position", "temperature", "stress", "resistance")
DURATION, SAMPLES, STEP = 8.0, 81, 0.01
NAMES = {
    "wire on a spring": ("element.diameter", "mechanism.stiffness", "element.law.A_f"),
    "README": ("stiffness", "preload", "diameter", "A_f", "h"),
}


def readme_wire(folder: Path) -> AbstractSystem:
    """The wire of the README."""
    (text,) = [one.text for one in fences(ROOT / "README.md") if one.text.startswith("# wire.toml")]
    (folder / "wire.toml").write_text(text, encoding="utf-8")
    return load(str(folder / "wire.toml")).system


def choose(which: str, folder: Path) -> tuple[AbstractSystem, PulseWidthModulation]:
    """A wire and pulses that heat it through a transformation and let it cool."""
    if which == "README":
        return readme_wire(folder), PulseWidthModulation(high=0.9, frequency=10.0, duty=0.28)
    return problem_a(), PulseWidthModulation(high=3.0, frequency=0.2, duty=0.6)


def meant_slopes(system: AbstractSystem, pulses: Any, names: Sequence[str]) -> Mapping[str, Any]:
    """(samples, directions) by output, without the first sample."""
    found = {}
    for output in OUTPUTS:
        made = compute_sensitivity(
            system, pulses, DURATION, names, step=STEP, output=output, samples=SAMPLES, runtime="c"
        )
        found[output] = np.array(list(made.slopes.values())).T[1:]
    return found


def given_steps(system: AbstractSystem, pulses: Any) -> tuple[tuple[float, ...], list[Step], list[int]]:
    """Signals at the start, the steps of the grid, and after how many of them its samples are."""
    grid = grid_of(system, pulses, DURATION, SAMPLES, STEP)
    steps = [(dt, tuple(row[:1])) for dt, row in zip(grid.lengths, grid.drives, strict=True)]
    return grid.sampled[0], steps, np.cumsum(grid.counts).tolist()


def make_lanes(slopes: CoreSlopes, folder: Path, lanes: int) -> NativeSlopes:
    """Lanes in a folder of their own: a library that is loaded must not be written anew."""
    (folder / "slopes").mkdir()
    return NativeSlopes(slopes, folder / "slopes", lanes, ["-O0"])


@pytest.fixture
def zig() -> None:
    """Skip where modules can be neither made nor played."""
    if say_missing():
        pytest.skip(f"WebAssembly is not tried: there is no {say_missing()}")


# ---------------------------------------------------------------- in C of this machine


@pytest.mark.parametrize("which", NAMES)
def test_slopes_are_those_of_the_march(c_compiler: str, tmp_path: Path, which: str) -> None:
    system, pulses = choose(which, tmp_path)
    core = build_c_core(system, name="wire")
    slopes = choose_slopes(system, core, NAMES[which])
    first, steps, ends = given_steps(system, pulses)
    places = [one.index for name in OUTPUTS for one in core.outputs if one.name == name]
    lanes, plain = make_lanes(slopes, tmp_path, 2), NativeLanes(core, tmp_path, 1, ["-O0"])
    lanes.start(first)
    rows, found = lanes.run_slopes(steps, 1, places)
    plain.start(first)
    assert rows[:, :, 1].tolist() == plain.run(steps, 1, places)[0][:, :, 0].tolist()
    for k, meant in enumerate(meant_slopes(system, pulses, slopes.names).values()):
        largest = np.abs(meant).max(axis=0)
        error = np.abs(found[np.array(ends) - 1, k, :, 1] - meant).max(axis=0)
        assert (largest > 0.0).any() and (error <= 1e-9 * largest).all(), (OUTPUTS[k], error / largest)


def test_a_signal_is_moved_from_the_start_on(c_compiler: str, tmp_path: Path) -> None:
    """Against central differences of the lanes without slopes, of a length and of the signal."""
    system, change = problem_a(), 1e-6
    core = build_c_core(system, name="wire")
    slopes = choose_slopes(system, core, ["drive", "element.length"])
    assert slopes.names == ("element.length", "drive") and slopes.width == 2
    given = [3.0 * (k < 150) + 0.1 for k in range(300)]
    lanes, plain = make_lanes(slopes, tmp_path, 1), NativeLanes(core, tmp_path, 4, ["-O0"])
    length = next(one.index for one in core.parameters if one.name == "element.length")
    plain.models[:2, length] *= [1.0 + change, 1.0 - change]
    plain.call("prepare", plain.status)
    moved = np.array([0.0, 0.0, change, -change])
    plain.call("start", given[0] + moved, plain.status)
    ends = np.empty((len(core.outputs), 4))
    for value in given:
        plain.call("step", value + moved, 0.02, plain.status)
    plain.call("observe", given[-1] + moved, ends, plain.status)
    lanes.start(given[:1])
    _, found = lanes.run_slopes([(0.02, (value,)) for value in given], len(given), range(len(core.outputs)))
    spans = np.array([system.value_of("element.length"), 1.0]) * 2.0 * change
    meant = (ends[:, [0, 2]] - ends[:, [1, 3]]) / spans
    scale = np.abs(ends[:, :1]) + np.abs(meant) * spans / change
    assert (np.abs(found[0, :, :, 0] - meant) * spans <= 1e-10 * scale).all()
    assert (np.abs(meant).max(axis=0) > 0.0).all()


@pytest.mark.parametrize("array", ["models", "tangents"])
def test_a_lane_that_fails_keeps_state_and_slopes(c_compiler: str, tmp_path: Path, array: str) -> None:
    """One whose values are no numbers, and one whose slopes are none."""
    system = problem_a()
    core = build_c_core(system, name="wire")
    slopes = choose_slopes(system, core, ["element.diameter"])
    lanes = make_lanes(slopes, tmp_path, 3)
    lanes.start([0.0])
    value, slope = len(core.parameters) + core.constants, slopes.program.constant_slopes
    if array == "models":
        lanes.models[1, value] = math.nan
    else:
        lanes.tangents[1, 0, slope] = math.nan
    kept = lanes.models[1, value : value + core.states].copy(), lanes.tangents[1, 0, slope : slope + core.states].copy()
    rows, found = lanes.run_slopes([(0.02, (3.0,))] * 20, 5, [0])
    assert lanes.taken.tolist() == [20, 0, 20] and lanes.status.tolist() == [lanes.status[0], 4, lanes.status[0]]
    assert np.isnan(rows[:, :, 1]).all() and np.isnan(found[..., 1]).all()
    assert np.isfinite(found[..., [0, 2]]).all() and (found[..., 0] == found[..., 2]).all()
    np.testing.assert_array_equal(lanes.models[1, value : value + core.states], kept[0])
    np.testing.assert_array_equal(lanes.tangents[1, 0, slope : slope + core.states], kept[1])


def test_without_the_option_nothing_is_added() -> None:
    """The core is printed alike before and after slopes of it were; its lanes stand alone."""
    system = problem_a()
    core = build_c_core(system, name="wire")
    before = core.source, list_sources(core)
    assert choose_slopes(system, core, ["element.diameter"]).source
    again = build_c_core(system, name="wire")
    assert (again.source, list_sources(again)) == before
    assert before[1]["lanes.c"].endswith(read_text("lanes.c"))


# ---------------------------------------------------------------- refusals


def test_directions_that_there_are_not() -> None:
    """Unknown, without a consequence, or the length of every step."""
    system = problem_a()
    core = build_c_core(system, name="wire")
    with pytest.raises(ParameterError, match=r"signal `element.diametre`\. Did you mean `element.diameter`"):
        choose_slopes(system, core, ["element.diametre"])
    unused = next(one.name for one in core.parameters if not one.used)
    with pytest.raises(ParameterError, match="no number follows from it"):
        choose_slopes(system, core, [unused])
    loop = load(ROOT / "examples/closed_loop.toml").whole
    pace = build_c_core(loop, name="loop")
    (sample,) = [one.name for one in pace.parameters if pace.sample == f"m->p[{one.index}]"]
    with pytest.raises(ParameterError, match="length of every step"):
        choose_slopes(loop, pace, [sample])


# ---------------------------------------------------------------- with zig and Node.js

TRIED = """
import { load } from "./wire_wasm/wire.js";
import { readFileSync } from "node:fs";
const { first, steps } = JSON.parse(readFileSync("played.json", "utf8"));
const program = await load(), by = ["element.diameter", "mechanism.stiffness", "drive"], names = NAMES;
const dt = steps.map(([length]) => length), drive = steps.map(([, [value]]) => value);
const create = (options) => program.create({ signals: { drive: first[0] }, ...options });
const play = (model, moved = 0) => model.run({ dt, signals: { drive: drive.map((x) => x + moved) }, outputs: names });
const begun = create({ slopes: by, lanes: 2 }), found = play(begun), plain = play(create());
const sides = by.map((name) => {
  const here = name === "drive" ? 1 : create().get(name), change = 1e-6 * here;
  const [more, less] = [change, -change].map((moved) =>
    name === "drive"
      ? play(create({ signals: { drive: first[0] + moved } }), moved)
      : play(create({ parameters: { [name]: here + moved } })));
  return names.map((one) => Array.from(more.columns[one], (x, k) => (x - less.columns[one][k]) / (2 * change)));
});
const model = create({ slopes: ["drive"] }), seen = [];
for (let k = 0; k < 50; k++) model.step(dt[k], { drive: drive[k] });
const saved = model.save();
for (let twice = 0; twice < 2; twice++) {
  model.restore(saved);
  for (let k = 50; k < 60; k++) model.step(dt[k], { drive: drive[k] });
  seen.push(model.slope("temperature", "drive"));
}
const refused = (call) => { try { call(); return ""; } catch (error) { return `${error.name}: ${error.message}`; } };
const one = (columns, lane) => Array.from(columns).filter((_, k) => k % 2 === lane);
console.log(JSON.stringify({
  found: by.map((name) => names.map((output) => one(found.slopes[output][name], 1))),
  sides,
  same: names.every((name) => one(found.columns[name], 0).every((x, k) => x === plain.columns[name][k])),
  last: begun.slope(names[1], by[0], 1) === found.slopes[names[1]][by[0]].at(-1),
  seen,
  row: found.slopes.temperature.drive[119],
  foreign: refused(() => create({ slopes: [by[0]] }).restore(saved)),
  unknown: refused(() => create({ slopes: ["element.length"] })),
  absent: refused(() => model.slope("position", by[0])),
  none: Object.keys(plain.slopes.position).length,
}));
"""


def test_a_wire_is_written_with_slopes(zig: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    system, pulses = choose("README", tmp_path)
    chosen = "diameter, stiffness,drive"
    done = CliRunner().invoke(app, ["export", "wasm", "wire.toml", "--slopes", chosen, "--json"])
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report["slopes"] == ["element.diameter", "mechanism.stiffness", "drive"]
    assert report["packed_bytes"] < MOST
    assert '"element.diameter" | "mechanism.stiffness" | "drive";' in Path("wire_wasm/wire.d.ts").read_text()
    first, steps, ends = given_steps(system, pulses)
    Path("played.json").write_text(json.dumps({"first": first, "steps": steps}), encoding="utf-8")
    Path("package.json").write_text('{"type": "module"}', encoding="utf-8")
    said = json.loads(call_node(Path(), TRIED.replace("NAMES", json.dumps(OUTPUTS))))
    found, sides = np.array(said["found"]), np.array(said["sides"])
    meant = np.array(list(meant_slopes(system, pulses, report["slopes"][:2]).values())).transpose(2, 0, 1)
    largest = np.abs(found).max(axis=2)
    there = found[:2][:, :, np.array(ends) - 1]
    assert (np.abs(there - meant).max(axis=2) <= 1e-9 * largest[:2]).all()
    assert (np.abs(found - sides).max(axis=2) <= 1e-5 * largest).all() and (largest > 0.0).all()
    assert said["same"] and said["last"] and said["none"] == 0
    assert said["seen"] == [said["row"]] * 2
    assert said["foreign"].startswith("RangeError: These numbers were not saved")
    assert said["unknown"].startswith('RangeError: There are no slopes by "element.length". Valid: element.diameter')
    assert said["absent"] == 'RangeError: This model takes no slopes by "element.diameter" along, but by: drive.'


def test_a_module_without_slopes_says_so(zig: None, tmp_path: Path) -> None:
    write_module(build_wasm(problem_a(), name="wire"), tmp_path)
    script = 'import { load } from "./wire.js";\nconst program = await load();\n'
    script += 'try { program.create({ slopes: ["drive"] }); } catch (error) { console.log(error.message); }'
    said = 'There are no slopes by "drive". Valid: none; write the module with `--slopes`.\n'
    assert call_node(tmp_path, script) == said
