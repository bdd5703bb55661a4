"""The bench without a server: inputs from controls, runs by WebAssembly in Node.js, refusals."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import Command
from node_js import WEB, node
from static_wire import PULSE, ROW, TABLE, TEXT, WIRE, measure_wire, write_wire

from martensite.app.documents import build_packaged, list_standalone
from martensite.app.messages import write_message
from martensite.app.static_site.control_map import InputMap, write_quantity
from martensite.app.static_site.flat_inputs import list_inputs, list_waveforms
from martensite.app.static_site.input_map import measure_map
from martensite.app.static_site.number_rows import list_rows, read_row
from martensite.app.static_site.packaged_modules import provide_module
from martensite.app.static_site.rounding import describe_rounding, measure_rounding
from martensite.app.static_site.run_module import write_source
from martensite.app.static_site.scenario_table import describe_static
from martensite.app.static_site.site_writer import RUNS, make_site_folder
from martensite.base.errors import CompileError, DataError
from martensite.kernels.compiler import find_compiler
from martensite.show.summaries.run import tabulate_key_results
from martensite.simulate.compiled import compile_march
from martensite.simulate.result import Result

CLOSE = 1e-8
"""Difference by rounding, as a fraction of a range. The lengths of steps to kinks amplify it."""
STATIC = Command("app")
CHANGES = {"element.diameter": 1.2e-4, "drive.waveform.high": 0.55, "run.duration": 11.0}


def build(made: InputMap, changes: dict[str, float]) -> Any:
    nodes = {one.path: one.node for one in made.controls}
    return build_packaged(TEXT, {path: write_quantity(nodes[path], value) for path, value in changes.items()})


def test_a_site_that_cannot_be_finished_leaves_nothing(tmp_path: Path) -> None:
    """Neither folders that were made for it, nor anything in an empty folder that was there before."""
    there = tmp_path / "there"
    there.mkdir()
    for folder in (tmp_path / "a" / "b" / "c", there):
        with pytest.raises(CompileError), make_site_folder(folder):
            (folder / RUNS / "half").write_text("")
            raise CompileError("The compiler failed.")
    assert [path.name for path in tmp_path.rglob("*")] == ["there"]
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file" / "below", tmp_path / "file"):
        with pytest.raises(DataError), make_site_folder(folder):
            raise AssertionError


def test_inputs_follow_from_controls_as_the_builder_has_them() -> None:
    made, _ = measure_wire()
    found = made.predict({k: CHANGES[one.path] for k, one in enumerate(made.controls) if one.path in CHANGES})
    meant = list_inputs(build(made, CHANGES), made.drives).numbers
    assert found == pytest.approx(meant, rel=1e-12, abs=0.0)
    moved = {name for name in found if found[name] != made.numbers[name]}
    assert moved == {"p:element.diameter", "duration", "drive:0.level:1"}


def test_what_the_builder_refuses_in_the_wrong_order_moves_together_in_order() -> None:
    """Each of A_s and A_f may go where the other does not let it, and both as long as A_s stays below A_f."""
    made, _ = measure_wire()
    paths = [one.path for one in made.controls]
    start, finish = (paths.index(f"element.law.{name}") for name in ("A_s", "A_f"))
    assert (made.apart, made.ordered) == (set(), {(start, finish)})
    assert made.controls[start].high < made.controls[finish].value
    low, high = made.controls[finish].low, made.controls[start].high
    changes = {start: 0.5 * (low + high) - 0.1, finish: 0.5 * (low + high)}
    meant = list_inputs(build(made, {paths[k]: value for k, value in changes.items()}), made.drives).numbers
    assert made.predict(changes) == pytest.approx(meant, rel=1e-11, abs=0.0)


def test_a_product_of_controls_is_measured() -> None:
    """Pulses end at k/f + duty/f."""
    text = list_standalone()["pwm_bias_spring"]
    made = measure_map(text, ("drive.waveform.frequency", "drive.waveform.duty"))
    changes = {k: one.value + 0.7 * (one.high - one.value) for k, one in enumerate(made.controls)}
    written = {made.controls[k].path: write_quantity(made.controls[k].node, x) for k, x in changes.items()}
    meant = list_inputs(build_packaged(text, written), made.drives).numbers
    assert made.products
    assert made.predict(changes) == pytest.approx(meant, rel=1e-11, abs=0.0)


def test_a_row_of_numbers_is_a_control_for_each() -> None:
    """Where two neighbours are equal, the slope between them is no rounding, but 0."""
    made = measure_map(TABLE, (ROW, "drive.waveform.times"))
    assert [row.path for row in made.rows] == [ROW]
    assert [one.path for one in made.controls] == [f"{ROW}.{k}" for k in range(4)]
    for values in ([0.7, 0.37, 0.37, 0.0], [0.1, -0.2, 1.3, 4.5]):
        meant = list_inputs(build_packaged(TABLE, {ROW: [f"{x} W" for x in values]}), made.drives).numbers
        found = made.predict(dict(enumerate(values)))
        assert found == pytest.approx(meant, rel=1e-12, abs=0.0)
    with pytest.raises(ValueError, match="more than 50 numbers"):
        read_row({**next(list_rows(made.form)), "value": ", ".join(51 * ["1 W"])})


Played = list[dict[str, Any]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the page reads of the wires, and a program for Node.js that runs them."""
    made = tmp_path_factory.mktemp("static")
    write_wire(made, table=True)
    bundle = ["node_modules/.bin/esbuild", "test/run_columns.ts", "--bundle", "--platform=node", "--format=esm"]
    node()
    subprocess.run([*bundle, f"--outfile={made / 'run.mjs'}", "--log-level=warning"], cwd=WEB, check=True)
    return made


def play(folder: Path, name: str, *cases: dict[str, Any]) -> Played:
    """What comes of changes of a scenario in Node.js."""
    command = [node(), folder / "run.mjs", folder / RUNS, name, *map(json.dumps, cases)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture(scope="module")
def played(folder: Path) -> Played:
    """Runs of the wire: as packaged, with changes, and with what the page refuses."""
    turned = {"element.law.A_s": 345.0, "element.law.A_f": 344.0}
    return play(folder, WIRE, {}, CHANGES, turned, {"element.diameter": 1.0}, {"element.length": 0.2})


@pytest.mark.parametrize(("number", "changes"), [(0, {}), (1, CHANGES)])
def test_a_run_in_the_page_is_the_run(played: Played, number: int, changes: dict[str, float]) -> None:
    made, _ = measure_wire()
    require_run(played[number], build(made, changes))


def test_a_row_is_read_as_it_is_typed(folder: Path) -> None:
    typed = ["0 W", "300 mW", "0.4 W", "0.1 W"]
    short, far, odd = typed[:3], ["0 W", "9 W", "0.4 W", "0 W"], ["0 W", "0.3", "0.4 W", "0 W"]
    times = {"drive.waveform.times": ["0 s", "1 s", "2 s", "6 s"]}
    run, *others = play(folder, "table", {ROW: typed}, {ROW: short}, {ROW: far}, {ROW: odd}, {ROW: "1 W"}, times)
    require_run(run, build_packaged(TABLE, {ROW: typed}))
    assert run["rows"][ROW] == ", ".join(typed)
    words = [
        f"keeps the 4 numbers of `{ROW}`, but 3 were given",
        f"change `{ROW}` from -5 to 5 W only",
        f"`{ROW}` needs a number with a unit such as `W`, `mW`, but is `0.3`",
        f"`{ROW}` must be a list, but is `1 W`",
        "cannot change `drive.waveform.times` by itself",
    ]
    for one, said in zip(others, words, strict=True):
        assert said in one["refused"]


def test_a_short_pulse_of_a_long_run_is_in_the_numbers_of_the_page(folder: Path) -> None:
    (found,) = play(folder, "pulse", {})
    require_run(found, build_packaged(PULSE))
    assert found["alarms"]
    assert found["ends"]["hottest"][1] > max(found["columns"]["hottest"]) + 50.0


def require_run(found: dict[str, Any], scenario: Any) -> None:
    """Steps, status, heat and columns are those of `martensite run`."""
    compiler = find_compiler() is not None
    meant = scenario.run(runtime="c" if compiler else "floats")
    least = dict(compile_march(scenario.whole).convergence_scales)
    assert (found["steps"], found["rejected"], found["status"]) == (meant.steps, meant.rejected, meant.status.name)
    if compiler:  # the coarse first pass on floats takes slightly other steps than in C
        assert found["accuracy"] == pytest.approx(meant.accuracy, rel=1e-3)  # two passes that round differently
    assert list(found["columns"]) == list(meant.columns)
    for name, column in meant.columns.items():
        size = max(float(np.ptp(column)), least.get(name, 0.0))
        assert np.abs(np.subtract(found["columns"][name], column)).max() <= CLOSE * size, name
    assert meant.heat is not None
    assert math.isclose(found["putIn"], meant.heat.put_in, rel_tol=1e-9)
    require_numbers(found, meant)


def require_numbers(found: dict[str, Any], meant: Result) -> None:
    """Require the printed numbers of the page to be those of the summary, and its ends to be the extremes.

    The page has no peaks between the ends of steps: hence the allowance.
    """
    for (words, text), (meant_words, meant_text) in zip(found["key"], tabulate_key_results(meant).rows, strict=True):
        (number, *unit), (meant_number, *meant_unit) = text.split(" "), meant_text.split(" ")
        assert (words, unit) == (meant_words, meant_unit)
        assert float(number) == pytest.approx(float(meant_number), rel=1e-3, abs=1e-3), words
    for name, (low, high) in meant.extremes.items():
        size = 1e-3 * max(high - low, 1e-9)
        assert found["ends"][name] == pytest.approx([low, high], abs=size), name
    alarms = [(one["kind"], one["first"], one["duration"], one["worst"]) for one in found["alarms"]]
    wanted = [(one.kind, one.first, one.duration, one.worst) for one in meant.alarms]
    assert [kind for kind, *_ in alarms] == [kind for kind, *_ in wanted]
    assert [x for _, *own in alarms for x in own] == pytest.approx([x for _, *own in wanted for x in own], rel=1e-3)


def test_what_the_page_cannot_do_is_said(played: Played) -> None:
    words = [one["refused"] for one in played[2:]]
    assert words[0] == "`element.law.A_s` must be below `element.law.A_f`."
    assert "from 0.01 to 1 mm only" in words[1]
    assert "cannot change `element.length` by itself" in words[2]
    assert all("martensite app" in one for one in words[1:])


def test_steps_by_hand_are_the_run(tmp_path: Path) -> None:
    """The drive held over spans of 20 ms, each from the state of the one before."""
    write_wire(tmp_path)
    found = _step_columns(tmp_path, WIRE, "0.02")
    assert found["rows"] == 501
    assert list(found["apart"]) == ["temperature", "martensite_fraction", "stress", "position"]
    assert max(found["apart"].values()) <= build_packaged(TEXT).tolerance
    assert max(found["apart"].values()) > 0.0


def test_a_loop_by_hand_is_the_run_to_the_bit(tmp_path: Path) -> None:
    """Its set point of each period, from the state of the period before; noise is the noise of the document."""
    text = list_standalone()["closed_loop"]
    made = measure_map(text, ())
    source = write_source(made.scenario, list_waveforms(made.scenario))
    (tmp_path / RUNS).mkdir()
    (tmp_path / RUNS / "loop.wasm").write_bytes(provide_module(source))
    (tmp_path / RUNS / "loop.json").write_bytes(write_message(describe_static("loop", text, made, source, "loop.wasm")))
    found = _step_columns(tmp_path, "loop", "0.02")
    assert found["rows"] == 1201
    assert set(found["apart"].values()) == {0}
    # periods taken three at a time hold the set point for longer, which changes the run
    assert max(_step_columns(tmp_path, "loop", "0.06")["apart"].values()) > 0.0


def _step_columns(folder: Path, name: str, span: str) -> dict[str, Any]:
    script = folder / "step_columns.mjs"
    bundle = ["node_modules/.bin/esbuild", "test/step_columns.ts", "--bundle", "--platform=node", "--format=esm"]
    program = node()
    subprocess.run([*bundle, f"--outfile={script}", "--log-level=warning"], cwd=WEB, check=True)
    command = [program, script, folder / RUNS, name, span]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def test_what_a_last_digit_grows_to_is_measured_and_said() -> None:
    """A wire keeps it; where a finger bends, the length of a step follows from small differences."""
    assert measure_rounding(build_packaged(TEXT)) < CLOSE
    share = measure_rounding(build_packaged(list_standalone()["finger"]))
    assert CLOSE < share < 1e-4
    assert f"as much as {share:.0e} of a range".replace("e-0", "e-") in describe_rounding(share)
    assert "as much as 40 % of a range: `martensite run` may differ" in describe_rounding(0.4)
    assert describe_rounding(0.0) == ""


# ---------------------------------------------------------------- the command


def test_a_folder_with_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    done = STATIC("--static", str(tmp_path))
    assert done.exit_code == 2
    assert "holds something else" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_a_scenario_that_starts_elsewhere_is_refused(tmp_path: Path) -> None:
    (tmp_path / "warm.toml").write_text(f'{TEXT}\n[initial]\ntemperature = "40 degC"\n')
    done = STATIC(str(tmp_path / "warm.toml"), "--static", str(tmp_path / "page"))
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "cannot run `warm`" in done.stderr
    assert not (tmp_path / "page").exists()
