"""What `check` says of loops: faults that a run would show too late, cautions, and what it could not test.

Sources of truth: the examples, which work, and changes of them that cannot.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import Command

from martensite.base.errors import InputError
from martensite.control.loop.findings import LoopFinding, check_guard, check_signals
from martensite.control.loop.held_readings import iterate_signals
from martensite.control.margins.loop_case import LoopCase
from martensite.control.margins.loop_check import LoopReport, check_loop, check_reach, check_sign
from martensite.control.margins.loop_points import linearise_case
from martensite.control.margins.loop_tests import check_band, check_derivative, check_offset, judge_margins
from martensite.control.margins.observability import check_observability, find_slopes
from martensite.control.margins.pace import check_pace, follow_fastest
from martensite.control.synthesis.rest_curves import read_at_rest
from martensite.kernels import floats
from martensite.scenario.scenario import load
from martensite.simulate.drive_waveforms import by_name

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
check = Command("check")
pytestmark = pytest.mark.usefixtures("c_compiler")


@cache
def build_example(example: str) -> LoopCase:
    """The first loop of an example."""
    return build_case(example)


def build_case(example: str = "closed_loop", **values: Any) -> LoopCase:
    """The same with some values changed; the plant of the example is that of all its changes within its limits."""
    changed = {name.replace("__", "."): value for name, value in values.items()}
    scenario = load(EXAMPLES / f"{example}.toml", changed)
    assert scenario.bench is not None
    drive, one = next(iter(scenario.bench.controllers.members().items()))
    case = LoopCase(scenario.bench, drive, one, scenario.duration)
    if values and "driver" not in values and case.limits == (first := build_example(example)).limits:
        case.__dict__["heating"] = first.heating
    return case


def report_loop(example: str) -> LoopReport:
    """What is found in the loops of an example."""
    scenario = load(EXAMPLES / f"{example}.toml")
    assert scenario.bench is not None
    played = by_name(scenario.system, scenario.waveform)
    return check_loop(scenario.bench, scenario.duration, waveforms=played)


def find_only(found: Any) -> LoopFinding:
    """The only finding."""
    (one,) = found
    return one


def test_a_healthy_loop_is_sound_and_every_row_of_its_margins_is_there() -> None:
    whole = check.report(str(EXAMPLES / "closed_loop.toml"))
    assert (whole["period"], whole["steps"]) == (pytest.approx(0.02), 1200)
    report = whole["loops"]
    assert (report["verdict"], report["findings"], report["untested"]) == ("sound", [], {})
    assert [row["branch"] for row in report["margins"]] == ["heating"] * 3 + ["cooling"] * 3 + ["dead band"]
    assert all(row["stable"] and 1.0 <= row["sensitivity"] < 1.2 for row in report["margins"])


def test_gains_of_the_wrong_sign_end_with_one_sentence_and_with_1() -> None:
    done = check(str(EXAMPLES / "closed_loop.toml"), "--set", "controller.Kp=-150")
    assert done.exit_code == 1
    words = " ".join(done.stdout.split())
    assert words.count("Not sound:") == 1
    assert "A higher signal raises `position`" in words
    assert "drives away from its reference" in words
    assert "the loop has 1 fault" in words


@pytest.mark.parametrize(
    ("gains", "words"), [((-150.0, 1.5), "at once"), ((150.0, -15.0), "in the end"), ((-150.0, -1.5), "10.3 mm:")]
)
def test_the_sign_is_that_of_the_first_and_of_the_last_answer(gains: tuple[float, float], words: str) -> None:
    values = {"controller__Kp": gains[0], "controller__Ki": gains[1], "controller__gains_are": "per-sample"}
    found = find_only(check_sign(build_case(**values)))
    assert found.fault
    assert words in found.sentence


def test_signals_under_held_readings_are_those_of_the_controller() -> None:
    """Traced samples, against the controller itself on floats."""
    case = build_example("closed_loop")
    one, readings = case.controller, read_at_rest(case.bench, case.heating.point(9).outputs)
    reference = readings[one.measured] + 1e-3
    found = list(iterate_signals(one, readings, reference, case.bench.period, 5))
    memory = one.rest(floats, reference, readings)
    for signal in found:
        own, memory = one.answer(floats, memory, reference, readings, case.bench.period)
        assert signal == pytest.approx(own, rel=1e-12)
    assert len(set(found)) == 5


def test_a_controller_that_answers_the_right_way_has_no_finding() -> None:
    assert list(check_sign(build_example("closed_loop"))) == []
    assert list(check_reach(build_example("closed_loop"))) == []


WITHOUT_GAINS: dict[str, dict[str, Any]] = {
    "pid": {"Kp": 0.0, "Ki": 0.0},
    "derivative alone": {"kind": "pid", "Kp": 0.0, "Kd": 20.0},
    "scheduled-pid": {"kind": "scheduled-pid", "rising": {"p1": {"at": "1 mm", "Kp": 0.0, "Ki": 0.0}}},
    "sliding-mode": {"kind": "sliding-mode", "gain": 0.0, "slope": "2 1/s", "layer": "10 mm/s", "offset": 0.4},
}
"""Controllers whose signal is constant, wherever their gains stand."""


@pytest.mark.parametrize("name", list(WITHOUT_GAINS))
def test_a_controller_without_gains_is_not_sound(name: str) -> None:
    table = {"kind": "pid", "measured": "position", "period": "20 ms"} | WITHOUT_GAINS[name]
    found = find_only(check_sign(build_case(controller=table)))
    assert found.fault
    assert "it has no gain, so nothing is controlled" in found.sentence


def test_two_levels_that_are_the_same_are_a_fault() -> None:
    table = {"kind": "on-off", "measured": "position", "period": "20 ms", "low": 0.3, "high": 0.3}
    scenario = load(EXAMPLES / "closed_loop.toml", {"controller": table})
    assert scenario.bench is not None
    assert find_only(check_signals(scenario.bench)).sentence.endswith("are both 0.3: nothing is controlled.")


def test_a_controller_that_answers_its_reference_alone_is_not_tested() -> None:
    table = WITHOUT_GAINS["sliding-mode"] | {"measured": "position", "period": "20 ms", "per_reference": 40.0}
    with pytest.raises(InputError, match="does not answer what it reads"):
        list(check_sign(build_case(controller=table)))


def test_a_limit_of_the_guard_above_that_of_the_element_is_not_sound_and_warned_of() -> None:
    """The element of the example bears 140 degC, by its material."""
    path = "supervisor.checks.bound_drive.limit"
    for limit, fault in (("1e6 K", True), ("141 degC", True), ("140 degC", False), ("110 degC", False)):
        scenario = load(EXAMPLES / "closed_loop.toml", {path: limit, "run.duration": "0.1 s"})
        assert scenario.bench is not None
        found = check_guard(scenario.bench)
        assert [one.fault for one in found] == [True] * fault
        assert [one.where for one in found] == [path] * fault
        assert any("above the limit of the element, 140 degC" in one for one in scenario.run().warnings) == fault
    done = check(str(EXAMPLES / "closed_loop.toml"), "--set", f"{path}=1e6 K")
    assert done.exit_code == 1
    assert "the loop has 1 fault" in " ".join(done.stdout.split())


def test_one_of_a_pair_reaches_what_it_leads_to() -> None:
    pair = build_example("closed_loop_antagonistic")
    assert list(check_reach(pair)) == []
    assert pair.list_reached().min() == pytest.approx(-pair.list_reached().max(), rel=1e-6)
    with pytest.raises(InputError, match="several signals"):
        list(check_sign(pair))


def test_a_reference_beyond_the_stroke_is_out_of_reach() -> None:
    found = find_only(check_reach(build_case(reference__increment="29 mm", reference__count=2)))
    assert (found.fault, found.number, found.unit) == (True, pytest.approx(0.03), "m")
    assert 0.0102 < found.allowed < 0.0105
    assert list(check_reach(build_case(reference__increment="9 mm", reference__count=2))) == []


@pytest.mark.parametrize(("path", "value", "allowed"), [("high", 2, 1.0), ("low", -0.2, 0.0)])
def test_a_duty_that_there_is_not_is_a_fault(path: str, value: float, allowed: float) -> None:
    found = find_only(check_signals(build_case("closed_loop", **{f"controller__{path}": value}).bench))
    assert (found.fault, found.number, found.allowed) == (True, value, allowed)
    assert found.where == f"controllers.drive.law.{path}"


def test_a_run_warns_of_such_a_duty() -> None:
    values = {"controller.high": 2, "run.duration": "0.1 s"}
    warnings = load(EXAMPLES / "closed_loop.toml", values).run().warnings
    assert [one for one in warnings if "`mosfet` can be given 1 at most" in one]


def test_a_signal_below_zero_that_heats_turns_the_loop() -> None:
    case = build_case(
        driver={"kind": "current", "current_limit": "0.4 A"}, controller__low="-0.3 A", controller__high="0.6 A"
    )
    low, high = check_signals(case.bench)
    assert (low.fault, high.fault) == (True, False)
    assert "heated again" in low.sentence
    assert high.allowed == pytest.approx(0.4)


def test_a_reference_faster_than_the_air_is_a_caution_with_its_numbers() -> None:
    quick = {"kind": "sine", "low": "1 mm", "high": "9 mm", "frequency": "0.5 Hz"}
    found = list(check_pace(build_case(reference=quick)))
    assert found
    assert not any(one.fault for one in found)
    assert "falls faster than the element cools" in found[0].sentence
    assert list(check_pace(build_example("closed_loop"))) == []


def test_the_fastest_way_is_followed_no_faster() -> None:
    up, down = (np.array([0.0, 1.0]), np.array([0.0, 2.0])), (np.array([0.0, 4.0]), np.array([2.0, 0.0]))
    wanted = np.array([0.0, 2.0, 2.0, 2.0, 0.0, 0.0, 1.5])
    np.testing.assert_allclose(follow_fastest(wanted, up, down, 0.5), [0.0, 1.0, 2.0, 2.0, 1.75, 1.5, 1.5])


def test_a_derivative_without_filter_is_a_kick() -> None:
    case = build_case(controller__Kd=20_000, controller__Ki=1.5, controller__gains_are="per-sample")
    found = find_only(one for one in check_derivative(case) if one.test == "derivative")
    assert found.number > 100.0
    assert list(check_derivative(build_example("closed_loop"))) == []


def test_a_band_within_the_noise_is_told() -> None:
    switch = {"kind": "on-off", "measured": "position", "high": 0.9, "band": "1 um", "period": "20 ms"}
    found = find_only(check_band(build_case(controller=switch, sensor__noise="5 um")))
    assert (found.number, found.allowed) == (pytest.approx(1e-6), pytest.approx(1e-5))
    assert list(check_sign(build_case(controller=switch))) == []


def test_a_loop_without_an_integral_rests_beside_its_reference() -> None:
    """By u/K_p, whatever the plant."""
    case = build_case(controller__Ki=0)
    loops = linearise_case(case)
    found = find_only(check_offset(case, loops))
    assert found.number == pytest.approx(max(one.point.signal for one in loops) / 150.0, rel=1e-6)
    assert not found.fault


def test_margins_that_are_small_are_told_and_an_unstable_branch_is_a_fault() -> None:
    row = {"branch": "heating", "reading": 1e-3, "stable": True, "sensitivity": 2.5, "gain": 1.8, "phase": 0.4}
    rows = [{**row, "delay": 0.1}, {**row, "branch": "cooling", "stable": False, "delay": 0.0}]
    near, swinging = judge_margins(build_example("closed_loop"), rows)
    assert (near.fault, swinging.fault) == (False, True)
    assert "M_s 2.50" in near.sentence


def test_a_resistance_is_judged_by_its_change_with_the_fraction_and_by_its_noise() -> None:
    case = build_example("closed_loop_sensorless")
    assert list(check_observability(case)) == []
    _, slopes, ohms = find_slopes(case, case.heating, "element")
    assert np.all(slopes > 0.05)
    assert ohms.min() > 11.0
    noisy = build_case("closed_loop_sensorless", sensor__relative_noise=0.05)
    assert {one.test for one in check_observability(noisy)} == {"observability"}
    blind = find_only(check_observability(build_case("closed_loop_sensorless", controller__low=0)))
    assert "nothing is read" in blind.sentence


@pytest.mark.parametrize(
    ("example", "verdict", "untested"),
    [
        ("closed_loop_power", "not all tested", {"loop of drive"}),
        ("closed_loop_beam", "not all tested", {"loop of drive"}),
        ("closed_loop_predictive", "not all tested", {"margins", "offset", "sampling", "noise", "derivative"}),
    ],
)
def test_every_example_has_its_verdict(example: str, verdict: str, untested: set[str]) -> None:
    report = report_loop(example)
    assert (report.verdict, set(report.untested)) == (verdict, untested)
    assert report.findings == ()


def test_what_cannot_be_tested_says_why() -> None:
    first = build_example("closed_loop")
    still = LoopCase(first.bench, "drive", first.controller, 1.0)
    still.__dict__["limits"] = (0.0, 1e-3)
    with pytest.raises(InputError, match="moves `position`"):
        list(check_sign(still))


def test_a_figure_needs_a_loop(tmp_path: Path) -> None:
    done = check(str(EXAMPLES / "isobaric.toml"), "--figure", str(tmp_path / "margins.png"))
    assert done.exit_code == 2
    assert "the scenario has no loop" in done.stderr
