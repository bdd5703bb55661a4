"""`tune`: what it shows and writes, and how it refuses.

Sources of truth: the scenario that is saved, which must hold the numbers that are shown.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from thin_wire import THIN_WIRE
from typer.testing import CliRunner

from martensite.cli import app
from martensite.scenario.scenario import load

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
    found = tuned(scenario, *how, "--save", saved, "--figure", figure, "--json")
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
    assert shown["other_plants"]["count"] == 4
    assert shown["other_plants"]["itae_ratio_median"] < 1.0


def test_what_people_read(scenario: Path, c_compiler: str) -> None:
    found = tuned(scenario, "--method", "relay", "--rule", "ziegler-nichols")
    assert found.exit_code == 0, found.output
    for words in ("pid by rule ziegler-nichols", "K_u", "controller.Kp [1/m]", "mm s^2", "degC"):
        assert words in found.stdout


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
        (("--spread", "diamter=3 %"), "`diamter` is no number of the plant"),
        (("--spread", "temperature=3 degC"), "is a difference"),
        (("--loop", "heater"), "No loop `heater`"),
        (("--duration", "0 s"), "must be above 0 s"),
        (("--level", "4 kg", "--method", "rules"), "cannot be converted"),
        (("--save", "tuned.nc"), "must end in .toml"),
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
