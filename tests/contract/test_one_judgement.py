"""One judgement per scenario: run, check, steady and wire report the same exceeded limits.

Source of truth: the limits that the scenario declares, and the peaks of its run against them, computed here.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import Command
from one_wire import write_wire

import martensite as ms
from martensite.base.status import Status
from martensite.physics.electrical.resistances import CONTRADICTION
from martensite.scenario.scenario import read_scenario
from martensite.simulate import judgement
from martensite.simulate.result import Result

WIRE = write_wire(
    "wire",
    drive='kind = "current"\nwaveform = { kind = "constant", level = "0.5 A" }',
    run='duration = "60 s"\nsamples = 601',
)
HELD = [
    ({}, set[str]()),
    ({"drive.waveform.level": "2 A"}, {"temperature"}),
    ({"mechanism.preload": "10 N"}, {"stress"}),
    ({"element.limits": {"strain_limit": "3 %"}}, {"strain"}),
    ({"drive": {"kind": "power", "waveform": {"kind": "constant", "level": "-1 W"}}}, {"supply"}),
    ({"drive.waveform.level": "5 A"}, {"temperature", "envelope"}),
]
"""A drive that is held, changes of the scenario, and the limits that are exceeded then."""
EXAMPLE_LOOP = Path(__file__).resolve().parents[2] / "examples" / "closed_loop.toml"
RUN, CHECK, STEADY, ONE_WIRE = (Command(name) for name in ("run", "check", "steady", "wire"))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "wire.toml"
    path.write_text(WIRE, encoding="utf-8")
    return path


def collect_verdicts(file: Path, *settings: str) -> dict[str, tuple[int, set[str]]]:
    """Exit code and kinds of exceeded limits, by command."""
    out = "--no-figure", "--force", "--out", str(file.with_suffix(".nc"))
    called = {
        "run": RUN(str(file), *settings, *out, "--json"),
        "check": CHECK(str(file), *settings, "--json"),
        "steady": STEADY(str(file), *settings, "--json"),
    }
    found = {name: (one.exit_code, json.loads(one.stdout)) for name, one in called.items()}
    return {name: (code, list_kinds(data, name)) for name, (code, data) in found.items()}


def list_kinds(data: dict[str, Any], name: str) -> set[str]:
    if name == "run":
        beyond = {"envelope"} if data["status"] == "OUT_OF_ENVELOPE" else set[str]()
        return beyond | {one["kind"] for one in data["alarms"]}
    limits = data["limits"]
    return {one["kind"] for one in limits["exceeded"]} | ({"envelope"} if limits["outside"] else set[str]())


def write_settings(change: dict[str, Any]) -> list[str]:
    found: list[str] = []
    for path, value in change.items():
        inner = {f"{path}.{k}": v for k, v in value.items()} if isinstance(value, dict) else {path: value}
        for name, one in inner.items():
            text = "{" + ", ".join(f'{k}="{v}"' for k, v in one.items()) + "}" if isinstance(one, dict) else str(one)
            found += ["--set", f"{name}={text}"]
    return found


@pytest.mark.parametrize(("change", "exceeded"), HELD, ids=lambda one: "+".join(sorted(one)) or "none")
def test_run_check_and_steady_agree_about_a_held_drive(
    file: Path, change: dict[str, Any], exceeded: set[str], c_compiler: str
) -> None:
    found = collect_verdicts(file, *write_settings(change))
    assert {name: kinds for name, (_, kinds) in found.items()} == dict.fromkeys(found, exceeded)
    assert (found["check"][0], found["steady"][0]) == (int(bool(exceeded)),) * 2
    assert found["run"][0] == int("envelope" in exceeded)


def test_check_judges_pulses_and_not_their_peak(file: Path) -> None:
    """A duty of 7.5 % stays cool, though the same current held exceeds the limit."""
    pulses = 'drive.waveform={kind="pwm", high="1.5 A", frequency="1 Hz", duty=0.075}'
    result = ms.load(file, {"drive.waveform": {"kind": "pwm", "high": "1.5 A", "frequency": "1 Hz", "duty": 0.075}})
    assert max(result.run()["hottest"]) < 413.15
    assert "All limits are kept." in CHECK.fine(str(file), "--set", pulses)
    held = CHECK(str(file), "--set", "drive.waveform.level=1.5 A").stdout.splitlines()
    assert "LIMIT EXCEEDED: temperature reaches" in held[0] and not any("valid" in line for line in held)


LOOPS = [
    ({}, set[str]()),
    (
        {"supervisor.kind": "none", "reference": '{kind="constant", level="10.45 mm"}', "run.duration": "120 s"},
        {"temperature"},
    ),
]
"""A loop that is sound, and one whose integral heats the wire while the reading stays below the reference."""


@pytest.mark.parametrize(("change", "exceeded"), LOOPS, ids=("cool", "hot"))
def test_run_and_check_agree_about_a_loop(
    tmp_path: Path, change: dict[str, Any], exceeded: set[str], c_compiler: str
) -> None:
    words = [str(EXAMPLE_LOOP), *write_settings(change)]
    checked, out = CHECK(*words, "--json"), ("--no-figure", "--out", str(tmp_path / "loop.nc"))
    data = json.loads(checked.stdout)
    assert data["loops"]["verdict"] == "sound"
    made = RUN.report(*words, *out)
    assert list_kinds(data, "check") == list_kinds(made, "run") == exceeded
    assert checked.exit_code == int(bool(exceeded))
    assert (made["columns"]["temperature"]["highest"] > 413.15) == bool(exceeded)


def test_a_run_that_takes_too_long_is_reported_as_not_judged(monkeypatch: pytest.MonkeyPatch, c_compiler: str) -> None:
    monkeypatch.setattr("martensite.cli.commands.check.TRIED", 0.0)
    verdict = CHECK.fine(str(EXAMPLE_LOOP)).splitlines()[0]
    assert "the loop passes all tests. Limits not checked: the run takes more than 0 s" in verdict
    assert "CPU time was spent" in RUN(str(EXAMPLE_LOOP), "--no-figure", "--time-box", "1 us").output


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_a_budget_changes_nothing_in_a_run_in_periods(runtime: str, c_compiler: str) -> None:
    scenario = ms.load(EXAMPLE_LOOP, {"run.duration": "2.34 s", "run.restart": ["1 s"]})
    plain, limited = (scenario.run(runtime=runtime, budget=one) for one in (None, 1e3))
    np.testing.assert_equal(plain.columns, limited.columns)
    assert plain.restarts == limited.restarts
    assert [one.time for one in limited.restarts] == [1.0, 2.34]


def test_check_agrees_with_the_scenario_that_wire_saves(tmp_path: Path) -> None:
    file = tmp_path / "w.toml"
    words = ("--diameter", "0.15 mm", "--length", "20 cm", "--supply", "6 V")
    assert ONE_WIRE.fine(*words, "--out", str(file)).startswith("Flexinol 0.15 mm")
    assert "All limits are kept." in CHECK.fine(str(file))
    assert RUN.report(str(file), "--no-figure", "--out", str(tmp_path / "w.nc"))["warnings"] == []


TOO_HOT = {"drive.kind": "power", "drive.waveform.level": "20 W"}


@cache
def find_end(text: str) -> float:
    """Return the end of a run that leaves the envelope [s], from many samples."""
    return float(read_scenario(text, overrides=TOO_HOT | {"run.samples": 5001}).run().times[-1])


@pytest.mark.parametrize("samples", [51, 1001])
@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_a_run_that_leaves_the_envelope_has_one_end(file: Path, runtime: str, samples: int, c_compiler: str) -> None:
    """The heat put in is that of the constant power until the end of the table."""
    result = ms.load(file, TOO_HOT | {"run.samples": samples}).run(runtime=runtime)
    end, stop = result.times[-1], float(result.warnings[0].split("t = ")[1].split(" s")[0])
    assert result.status is Status.OUT_OF_ENVELOPE and result.status_time == end
    assert stop == pytest.approx(end, rel=1e-5)
    assert result.heat is not None and result.heat.put_in == pytest.approx(20.0 * end, rel=1e-4)
    assert max(result["hottest"]) == pytest.approx(1583.15, abs=2.0)
    assert end == pytest.approx(find_end(WIRE), rel=1e-4)
    (hot,) = (alarm for alarm in result.alarms if alarm.kind == "temperature")
    assert hot.first + hot.duration == pytest.approx(end, rel=1e-3)


@pytest.mark.parametrize(("ohms", "reported"), [(10.0, True), (1.05, True), (0.95, False), (0.1, True)])
def test_a_resistance_that_contradicts_the_wire_is_reported(file: Path, ohms: float, reported: bool) -> None:
    """Times `CONTRADICTION` the resistance of a resistivity of 0.84 µΩ m; the same by `check`, `run` and `wire`."""
    factor = ohms * CONTRADICTION
    per_metre = factor * 8.4e-7 / (0.25 * math.pi * 0.25e-3**2)
    change = f'element.resistance={{kind="per-length", r_A="{per_metre} ohm/m", r_M="{per_metre} ohm/m"}}'
    settings = "--set", change, "--set", "drive.waveform.level=0.05 A"
    said = CHECK.fine(str(file), *settings).replace("\n", " ")
    out = "--no-figure", "--out", str(file.with_suffix(".nc"))
    assert ("contradict" in said, "contradict" in RUN.fine(str(file), *settings, *out)) == (reported, reported)
    listed = ms.data.load_wires("flexinol")["0.25 mm"].resistance.value
    wire = ONE_WIRE(
        "--diameter", "0.25mm", "--length", "200mm", "--supply", "50V", "--resistance", f"{factor * listed * 0.2} ohm"
    )
    verdict = wire.stdout.splitlines()[0]
    assert ("DOES NOT WORK" in verdict, "contradict" in wire.stdout) == (reported, reported)


@pytest.mark.parametrize(
    "words",
    [
        ("wire", "--resistance", "0 ohm"),
        ("wire", "--load", "0 N"),
        ("wire", "--coil", "--solid", "25 mm", "--turns", "0"),
        ("wire", "--coil", "--solid", "0 mm", "--turns", "20"),
        ("wire", "--coil", "--solid", "25 mm", "--outer", "0 mm"),
    ],
)
def test_zero_is_a_value(words: tuple[str, ...]) -> None:
    """It is refused where it has no meaning, never taken as not given."""
    given = ("--diameter", "0.5 mm", "--length", "20 cm", "--supply", "5 V")
    assert "above 0" in Command(words[0]).refused(*given, *words[1:])


def test_a_tolerance_of_zero_is_refused(file: Path) -> None:
    out = "--no-figure", "--out", str(file.with_suffix(".nc"))
    assert "`tolerance` must be above 0" in RUN.refused(str(file), "--tolerance", "0", *out)


def test_the_supply_that_a_verdict_names_does() -> None:
    """0.455 A are needed, and 0.455 A driven: what the sentence offers is tried."""
    words = [
        "--diameter",
        "0.15 mm",
        "--length",
        "20 cm",
        "--supply",
        "5 V",
        "--spring",
        "0.1 N/mm",
        "--preload",
        "1 N",
    ]
    screen = " ".join(ONE_WIRE(*words).stdout.split())  # without the ends of wrapped lines
    assert "DOES NOT WORK" in screen and "0.11 % less" in screen
    pulse, supply = screen.split('--pulse "')[1].split('"')[0], screen.split('--supply "')[1].split('"')[0]
    assert ONE_WIRE.fine(*words, "--pulse", pulse).startswith("Flexinol 0.15 mm")
    assert ONE_WIRE.fine(*words[:5], supply, *words[6:]).startswith("Flexinol 0.15 mm")


def test_holding_needs_no_more_than_contracting() -> None:
    found = ONE_WIRE("--diameter", "0.025 mm", "--length", "100 mm", "--supply", "24 V", "--json")
    data = json.loads(found.stdout)
    assert (
        data["holding_current"] <= data["cycle"]["current"] and data["holding_temperature"] <= data["cycle"]["hottest"]
    )


def test_the_comparison_of_commands_can_fail(file: Path, monkeypatch: pytest.MonkeyPatch, c_compiler: str) -> None:
    """A command that forgets the temperature differs from the others."""
    true = judgement.judge_run

    def forgetful(result: Result) -> judgement.Judgement:
        found = true(result)
        return replace(found, alarms=tuple(one for one in found.alarms if one.kind != "temperature"))

    monkeypatch.setattr(judgement, "judge_run", forgetful)
    found = collect_verdicts(file, "--set", "drive.waveform.level=2 A")
    assert found["check"] == (0, set()) and found["run"][1] == found["steady"][1] == {"temperature"}
