"""`design`: what it shows and writes, and how it refuses.

Sources of truth: the scenario that is saved, run again by itself.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command import Command
from design_cases import BUNDLE

from martensite.scenario.scenario import load

DESIGN = Command("design")
FREE = "--free", "element.count=2..3", "--free", "strand.diameter=0.08..0.14 mm"
POWER = "--free", "drive.peak=2..6 W"
LIMITS = ("--subject", "stroke >= 7.5 mm", "--subject", "rise-time <= 0.5 s", "--subject", "fall-time <= 1 s")
QUICK = "--sample", "16", "--descents", "1"
pytestmark = pytest.mark.usefixtures("c_compiler")


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "bundle.toml"
    path.write_text(BUNDLE.replace("[run]", '[run]\nstep = "25 ms"'), encoding="utf-8")
    return path


def test_the_scenario_that_is_saved_does_what_is_shown(scenario: Path) -> None:
    saved, figure = scenario.with_name("found.toml"), scenario.with_name("found.svg")
    files = "--out", str(saved), "--figure", str(figure)
    shown = DESIGN.report(str(scenario), *FREE, *POWER, *LIMITS, *QUICK, *files, "--no-limits")
    again = load(saved)
    run = again.run()
    assert shown["feasible"]
    for name, one in shown["free"].items():
        if name != "drive.peak":
            assert again.system.value_of(name) == pytest.approx(one["after"], rel=1e-12)
    assert max(run["drive"]) == pytest.approx(shown["free"]["drive.peak"]["after"], rel=1e-12)
    stroke = shown["measures"]["stroke"]["after"][0]
    assert np.ptp(run["position"]) == pytest.approx(stroke, rel=1e-4)
    assert stroke >= 7.5e-3 * (1.0 - 1e-4)
    assert "# subject to stroke >= 7.5 mm" in saved.read_text(encoding="utf-8")
    assert "keeps all" in figure.read_text(encoding="utf-8")


def test_a_design_that_misses_a_limit_is_not_saved_unless_forced(scenario: Path) -> None:
    """The truth: the scenario that is saved by force, run again, against the limits that the first line names."""
    saved = scenario.with_name("found.toml")
    words = str(scenario), *POWER, "--subject", "stroke >= 50 mm", *QUICK, "--out", str(saved)
    done = DESIGN(*words)
    assert done.exit_code == 1
    first = done.stdout.splitlines()[0]
    assert first.startswith("No design that keeps all limits was found: the nearest one misses stroke >= 50 mm")
    assert first.endswith("; not saved. --save-anyway saves it.")
    assert not saved.exists()
    assert DESIGN(*words, "--save-anyway").exit_code == 0
    again = load(saved)
    run = again.run()
    assert np.ptp(run["position"]) < 50e-3
    (one,) = again.system.actuators().values()
    lost = "max(stress)" in first
    assert (max(run["stress"]) > one.element.limits.stress_limit) == lost
    assert ("Life: limits that the elements declare are not kept" in done.stdout) == lost


def test_the_first_line_of_a_design_is_its_verdict(scenario: Path) -> None:
    shown = DESIGN.fine(str(scenario), *POWER, "--subject", "stroke >= 2 mm", *QUICK)
    assert shown.splitlines()[0].startswith("All limits are kept: least energy ")


def test_it_is_shown_in_words_beside_a_grid(scenario: Path) -> None:
    limits = *LIMITS[:2], "--life", "0 %", "--grid", "5"
    shown = DESIGN.fine(str(scenario), *FREE, *POWER, *QUICK, *limits)
    assert "least energy" in shown
    assert "Grid of 2 x 5 x 5 = 50 simulations" in shown
    assert "If nothing had to be whole" in shown
    assert "would gain" in shown
    assert "no number of cycles" in shown


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "Nothing is free"),
        ((*FREE, "--subject", "stroke"), "is no constraint"),
        ((*FREE, "--minimise", "energie"), "Did you mean `energy`"),
        ((*FREE, "--minimise", "energy", "--maximise", "stroke"), "one goal"),
        ((*FREE, "--sample", "60"), "power of 2"),
        ((*FREE, "--descents", "0"), "at least 1"),
        ((*FREE, "--grid", "1"), "at least 2"),
        ((*FREE, "--life", "120 %"), "margin of life"),
        ((*FREE, "--case", "environment.temperature"), "is no case"),
        ((*FREE, "--case", "drive.peak=3 W"), "level of a waveform"),
        ((*FREE, "--out", "found.json"), "must end in .toml"),
    ],
)
def test_it_refuses(scenario: Path, words: tuple[str, ...], sentence: str) -> None:
    assert sentence in DESIGN.refused(str(scenario), *words)


def test_a_closed_loop_is_refused() -> None:
    path = Path(__file__).parents[2] / "examples" / "closed_loop.toml"
    assert "tune its controller" in DESIGN.refused(str(path), "--free", "diameter=0.1..0.2 mm")
