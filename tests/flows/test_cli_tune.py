"""`tune`: what it shows and writes, and how it refuses.

Sources of truth: the scenario that is saved, which must hold the numbers that are shown.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from one_wire import THIN_WIRE
from typer.testing import CliRunner

from martensite.base.errors import InputError
from martensite.cli import app
from martensite.control.tuning.bench_tuning import compare_gains
from martensite.control.tuning.loop_runs import LoopRuns
from martensite.scenario.scenario import load

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

SCENARIO = f"""
title = "thin wire"{THIN_WIRE}[drive]
kind = "pwm-voltage"
supply = "5 V"
[sensor]
kind = "position"
[controller]
kind = "pid"
measured = "position"
period = "50 ms"
Kp = 100
Ki = 10
[bench]
substeps = 2
[reference]
kind = "constant"
level = "4 mm"
[run]
duration = "4 s"
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "wire.toml"
    path.write_text(SCENARIO, encoding="utf-8")
    return path


def tuned(*words: object) -> Any:
    return CliRunner().invoke(app, ["tune", *map(str, words)])


def test_rules_are_saved_as_they_are_shown(scenario: Path, c_compiler: str) -> None:
    saved, figure = scenario.with_name("tuned.toml"), scenario.with_name("tuned.svg")
    how = "--method", "rules", "--rule", "cohen-coon", "--form", "pi", "--level", "4 mm"
    found = tuned(scenario, *how, "--out", saved, "--figure", figure, "--json", "--save-anyway")
    assert found.exit_code == 0, found.output
    shown = json.loads(found.stdout)
    again = load(saved).bench
    assert again is not None
    for name in ("Kp", "Ki", "Kd"):
        number = shown["parameters"][f"controller.{name}"]
        assert again.value_of(f"controllers.drive.{name}") == number["after"]
        assert number["unit"] == {"Kp": "1/m", "Ki": "1/m/s", "Kd": "s/m"}[name]
    assert shown["parameters"]["controller.Kp"]["before"] == 100.0
    assert shown["parameters"]["controller.Kd"]["after"] == 0.0
    assert shown["step_test"]["heating"]["gain"] > 0.0
    assert "tuned: pi by rule cohen-coon" in saved.read_text(encoding="utf-8")
    assert "before" in figure.read_text(encoding="utf-8")


def test_gradient_lowers_the_cost_on_other_plants(scenario: Path, c_compiler: str) -> None:
    spreads = "--spread", "diameter=3 %", "--spread", "drive.supply=5 %", "--plants", "4"
    found = tuned(scenario, "--free", "Kp,Ki", *spreads, "--json")
    assert found.exit_code == 0, found.output
    shown = json.loads(found.stdout)
    assert shown["after"]["cost"] < shown["before"]["cost"]
    assert shown["gradients"] > 0
    assert (shown["verdict"]["plants"], shown["verdict"]["measure"]) == (4, "itae")
    assert shown["verdict"]["ratio_median"] < 1.0
    assert not shown["verdict"]["worse"]


def test_what_people_read(scenario: Path, c_compiler: str) -> None:
    found = tuned(scenario, "--method", "relay", "--rule", "ziegler-nichols", "--form", "pid")
    assert found.exit_code == 1, found.output
    for words in ("pid by rule ziegler-nichols", "K_u", "controller.Kp", "1/m/s", "mm s²", "°C"):
        assert words in found.stdout
    assert "Tests of the tuned loop: " in found.stdout


WEAK = "--set", "controller.Kp=400", "--set", "controller.Ki=200"
"""Gains with which the loop is faster than by SIMC."""


def run_errors(path: Path, overrides: dict[str, Any]) -> float:
    """Rms error of a run of a scenario [mm]."""
    run = load(path, overrides).run()
    return 1e3 * float(np.sqrt(np.mean((run["reference"] - run["position"]) ** 2)))


@pytest.mark.parametrize("method", ["rules", "schedule"])
def test_a_worse_result_is_not_saved_unless_forced(scenario: Path, method: str, c_compiler: str) -> None:
    """The truth: runs of the scenario before, and of the one that is saved by force."""
    saved = scenario.with_name("tuned.toml")
    how = "--method", method, *(("--sensitivity", "1.01") if method == "schedule" else ()), *WEAK, "--out", saved
    forced = tuned(scenario, *how, "--save-anyway", "--json")
    assert forced.exit_code == 0, forced.output
    verdict = json.loads(forced.stdout)["verdict"]
    before = run_errors(scenario, {"controller.Kp": 400, "controller.Ki": 200})
    after = run_errors(saved, {})
    assert (1e3 * verdict["before"], 1e3 * verdict["after"]) == pytest.approx((before, after), rel=1e-6)
    assert after > before
    if method == "rules":
        saved.unlink()
        found = tuned(scenario, *how)
        assert found.exit_code == 1, found.output
        assert not saved.exists()
        first = found.stdout.splitlines()[0]
        assert first.startswith(f"Worse than before: rms {after:.3g} mm instead of {before:.3g} mm")
        assert first.endswith(" on the plant of the scenario; not saved. --save-anyway saves it.")


def test_a_relay_test_alone_gives_a_loop_that_does_not_chatter(c_compiler: str) -> None:
    """The truth is the run of the example: a derivative by the same rule moves the duty cycle 22 times as much."""
    found = tuned(EXAMPLES / "closed_loop.toml", "--method", "relay", "--json")
    assert found.exit_code == 0, found.output
    numbers = json.loads(found.stdout)
    assert numbers["parameters"]["controller.Kd"]["after"] == 0.0
    assert numbers["after"]["activity"] < 4.0 * numbers["before"]["activity"]
    assert numbers["after"]["rms"] < numbers["before"]["rms"]


def test_what_check_finds_in_the_tuned_loop_decides_as_well(tmp_path: Path, c_compiler: str) -> None:
    """Relay gains with a derivative are quicker, but `check` finds that the loop swings: both commands say so."""
    example, how = EXAMPLES / "closed_loop.toml", ("--method", "relay", "--form", "pid")
    found = tuned(example, *how, "--out", tmp_path / "tuned.toml")
    assert found.exit_code == 1
    assert "WORSE: the tuned loop fails tests that the present loop passes (rms 0.43" in found.stdout.splitlines()[0]
    assert not list(tmp_path.iterdir())
    rows = [line.split() for line in found.stdout.splitlines() if line.strip().startswith("controller.K")]
    assert len(rows) == 3
    gains = [word for name, _, after, *_ in rows for word in ("--set", f"{name}={after}")]
    checked = CliRunner().invoke(app, ["check", str(example), *gains])
    assert checked.exit_code == 1
    for one in ("heating: it is unstable at 3 of 3 points", "cooling: it is unstable at 3 of 3 points"):
        assert one in " ".join(checked.stdout.split())
        assert one in " ".join(found.stdout.split())


def test_in_python_a_worse_result_says_so_and_is_not_saved(scenario: Path, tmp_path: Path, c_compiler: str) -> None:
    loaded, saved = load(scenario), tmp_path / "tuned.toml"
    assert loaded.bench is not None
    runs = LoopRuns(loaded.bench, loaded.duration, seed=loaded.seed)
    worse = compare_gains(runs, {"controllers.drive.Kp": 1.0})
    assert worse.worse
    with pytest.raises(InputError, match=r"Worse than before: rms .* Pass `anyway=True` to save it"):
        worse.save(loaded, saved)
    assert not saved.exists()
    worse.save(loaded, saved, anyway=True)
    better = compare_gains(runs, {"controllers.drive.Kp": 200.0})
    assert not better.worse
    better.save(loaded, saved)
    again = load(saved).bench
    assert again is not None
    assert again.value_of("controllers.drive.Kp") == 200.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--method", "rule"), "Did you mean `rules`?"),
        (("--plants", "4"), "`--plants` has no effect without --spread"),
        (("--rule", "simc"), "`--rule` has no effect with --method gradient"),
        (("--method", "rules", "--free", "Kp"), "`--free` has no effect with --method rules"),
        (("--method", "relay", "--rule", "simc"), "No rule for --method relay named `simc`"),
        (("--goal", "itea"), "Did you mean `itae`?"),
        (("--free", "Kq"), "There is no parameter `Kq`"),
        (("--spread", "diameter"), "write `PATH=SPREAD`"),
        (("--spread", "diamter=3 %"), "no parameter `diamter`. Did you mean"),
        (("--spread", "temperature=3 degC"), "is a difference"),
        (("--loop", "heater"), "No loop `heater`"),
        (("--duration", "0 s"), "must be above 0 s"),
        (("--level", "4 kg", "--method", "rules"), "cannot be converted"),
        (("--out", "tuned.nc"), "must end in .toml"),
    ],
)
def test_what_is_refused(scenario: Path, words: tuple[str, ...], said: str) -> None:
    found = tuned(scenario, *words)
    assert found.exit_code == 2
    assert said in found.stderr


def test_a_scenario_without_a_controller(tmp_path: Path) -> None:
    path = tmp_path / "open.toml"
    ahead, _, rest = SCENARIO.partition("[sensor]")
    run = rest[rest.index("[run]") :]
    path.write_text(f'{ahead}waveform = {{ kind = "constant", level = 0.5 }}\n{run}')
    found = tuned(path)
    assert found.exit_code == 2
    assert "has no [controller]" in found.stderr
