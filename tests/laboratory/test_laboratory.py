"""The accuracy that a run reports bounds its error; what was silently wrong is right or refused.

The truth is that of `laboratory.reference`; the many cases are in the documentation, written by
`laboratory.table`. Some run here.
"""

from __future__ import annotations

import math
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import LAW_A, SINE_A, problem_a, wire_a
from command import Command

from laboratory.measure_trials import COMPARED, try_trial
from laboratory.measures import ALLOWED, MeasureRecord
from laboratory.scenarios import DRIVES, make_scenario
from laboratory.structures import STRUCTURES, list_parts
from laboratory.table import PAGE, page, quantile, read_outcomes, try_case, try_layers
from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.mechanisms.base import MECHANISMS
from martensite.base.status import Status
from martensite.physics.electrical.base import SOURCES
from martensite.physics.laws.base import LAWS, AbstractLaw
from martensite.physics.laws.strip_laws import Elahinia, Tanaka
from martensite.physics.thermal.base import COOLING
from martensite.scenario.scenario import load
from martensite.signals.constant import Constant
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.sine import Sine
from martensite.simulate.adaptive import find_dip
from martensite.simulate.api import simulate

ROOT = Path(__file__).parents[2]
needs_c = pytest.mark.usefixtures("c_compiler")


# ---------------------------------------------------------------- the bound


@needs_c
@pytest.mark.parametrize("drive", DRIVES)
def test_the_accuracy_bounds_the_error(drive: str) -> None:
    found = try_case(1, 1e-4, drive)
    assert found.true <= found.claimed <= 1e-4


@needs_c
@pytest.mark.parametrize("drive", ["step", "pulses", "fast pwm"])
def test_the_accuracy_of_rates_bounds_the_error(drive: str) -> None:
    """Under pulses the rates of this case die out within a step."""
    found = try_layers(18, 1e-3, drive)
    assert found.true <= found.claimed <= 1e-3


@needs_c
def test_samples_of_a_fast_sine_are_not_read_from_too_few_points() -> None:
    """In one step of this run the ripple of temperature has no term of the fourth order at the points around."""
    found = try_case(58, 1e-4, "round sine")
    assert found.true <= found.claimed <= 1e-4


@pytest.mark.slow
@needs_c
@pytest.mark.parametrize("drive", DRIVES)
def test_the_accuracy_bounds_the_error_of_many(drive: str) -> None:
    ratios = [try_case(seed, 1e-4, drive).ratio for seed in range(2000, 2040)]
    assert sorted(ratios)[-2] <= 1.0
    assert max(ratios) <= 3.0


def test_the_page_is_of_its_numbers_and_they_are_good() -> None:
    rows = read_outcomes()
    assert PAGE.read_text(encoding="utf-8") == page(rows, MeasureRecord.read())
    ratios = [one.ratio for one in rows]
    assert len(rows) >= 1000
    assert quantile(ratios, 0.99) <= 1.0
    assert max(ratios) <= 3.0
    assert float(np.median(ratios)) >= 0.05


def test_measures_of_random_scenarios_are_within_their_bounds() -> None:
    """The reference is the same run at a tight tolerance, read from its steps and from many samples."""
    found = MeasureRecord.read()
    assert found.scenarios >= 1000
    assert found.measures[-1].most <= 1.0
    closed = {(seed, words) for seed, words, _ in found.closed}
    assert {(one[0], one[4]) for one in found.worst} <= closed


def test_random_scenarios_have_every_part() -> None:
    """Every structure is compared, and every law, element, mechanism, source and cooling is in a structure."""
    found = MeasureRecord.read()
    assert set(found.structures) == set(STRUCTURES)
    assert min(row[COMPARED] for row in found.structures.values()) > 0
    used = {type(one).__name__ for structure in STRUCTURES.values() for one in list_parts(structure.system)}
    for registry in (LAWS, ELEMENTS, MECHANISMS, SOURCES, COOLING):
        assert {registry[name].__name__ for name in registry.names()} <= used


@needs_c
def test_measures_are_within_their_bounds() -> None:
    """Some trials: a long step after a restart, a corner between steps, a prescribed course, and its jumps."""
    for seed in (26, 61, 70, 119, *sorted({seed for seed, *_ in MeasureRecord.read().closed})):
        rows = try_trial(seed).rows
        assert len(rows) > 5
        assert max(one.ratio for one in rows) <= ALLOWED, max(rows, key=lambda one: one.ratio)


@needs_c
def test_measures_of_loops_come_from_every_step_and_have_no_bound() -> None:
    runs = [load(ROOT / "examples/closed_loop.toml", {"run.samples": count}).run() for count in (11, 1001)]
    for words in ("max(power)", "stroke", "energy", "rise-time(temperature)"):
        assert runs[0].bound(words) is None
        assert runs[0].measure(words) == runs[1].measure(words)


def test_the_reference_is_that_of_another_method() -> None:
    case = make_scenario(3, "step")
    other = replace(case.equations, method="Radau", rows=[])
    meant, found = case.equations.run(case.times), other.run(case.times)
    assert np.abs(meant - found).max(axis=0) == pytest.approx([0, 0, 0], abs=1e-5 * 1e6)
    assert np.abs(meant - found)[:, :2].max() < 1e-6


# ---------------------------------------------------------------- what was silently wrong


def switched(**changes: Any) -> Any:
    """The example of a wire under PWM, with another drive and duration."""
    return load(ROOT / "examples/pwm_bias_spring.toml", changes)


def test_a_sine_that_divides_the_step_heats() -> None:
    """0 to 3 V at 50 Hz heat as 1.837 V rms do."""
    case = switched()
    sine = Sine(high=3.0, frequency=50.0)
    steady = Constant(level=1.5 * math.sqrt(1.5))
    runs = [simulate(case.system, wave, 40.0, samples=501, tolerance=1e-4) for wave in (sine, steady)]
    tops = [max(run["temperature"]) - 273.15 for run in runs]
    assert tops[0] == pytest.approx(97.7, abs=0.2)
    assert tops[0] == pytest.approx(tops[1], abs=0.1)


@needs_c
def test_sines_of_round_numbers_heat() -> None:
    """Compare twelve sines with the steady voltage of the same heat."""
    case, rng = switched(), np.random.default_rng(7)
    for _ in range(12):
        duration = float(rng.choice([5, 8, 10, 20]))
        samples = int(rng.choice([101, 201, 501, 1001, 2001]))
        frequency = float(rng.choice([10, 20, 25, 50, 100, 200, 500, 1000]))
        sine = Sine(low=-2.0, high=2.0, frequency=frequency)
        found = simulate(case.system, sine, duration, samples=samples, tolerance=1e-3, runtime="c")
        meant = simulate(
            case.system, Constant(level=math.sqrt(2.0)), duration, samples=samples, tolerance=1e-3, runtime="c"
        )
        apart = np.abs(np.subtract(found["temperature"], meant["temperature"])).max()
        assert apart < 0.5 + 4e-3 * meant.range("temperature"), (duration, samples, frequency)


@needs_c
def test_strong_pulses_are_within_what_is_claimed() -> None:
    """Compare pulses that transform nothing, all or a part with runs in steps of a 400th of a pulse."""
    case = switched()
    for width, joule in ((5e-3, 40.0), (0.03, 30.0), (0.05, 20.0), (0.08, 38.0)):
        pulse = PulseWidthModulation(high=math.sqrt(joule / width), frequency=0.2, duty=0.2 * width)
        found = simulate(case.system, pulse, 5.0, samples=31, runtime="c")
        meant = simulate(case.system, pulse, 5.0, samples=31, step=width / 400, runtime="c")
        assert found.accuracy is not None and not found.status.failed
        for name, least in case.system.convergence_scales().items():
            apart = np.abs(np.subtract(found[name], meant[name])).max()
            assert apart <= 3.0 * found.accuracy * max(meant.range(name), least)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"drive.waveform": {"kind": "constant", "high": "60 V"}}, "temperature"),
        ({"mechanism.preload": "400 N"}, "stress"),
    ],
)
def test_what_cannot_be_stops(changes: dict[str, Any], word: str) -> None:
    if "drive.waveform" in changes:
        changes = {"drive.waveform": {"kind": "constant", "level": "60 V"}}
    found = switched(**changes).run()
    assert found.status is Status.OUT_OF_ENVELOPE
    assert f"the {word} reached" in found.warnings[0]
    assert max(found["hottest"]) <= 1583.15
    assert len(found.times) == len(found["temperature"]) < 1001


@pytest.mark.parametrize(
    ("setting", "command", "code"),
    [
        ('drive.waveform={kind="constant",level="60 V"}', "run", 1),
        ('drive.waveform={kind="constant",level="60 V"}', "check", 1),
        ("mechanism.preload=400 N", "check", 1),
        ("run.samples=101", "check", 0),
    ],
)
def test_the_command_line_says_so(setting: str, command: str, code: int, tmp_path: Path) -> None:
    arguments = [str(ROOT / "examples/pwm_bias_spring.toml"), "--set", setting]
    more = ["--out", str(tmp_path / "x.nc"), "--no-figure"] if command == "run" else []
    done = Command(command)(*arguments, *more)
    assert done.exit_code == code, done.output
    assert ("The run stopped at t = " in done.output) == (code > 0)


# ---------------------------------------------------------------- cost


@needs_c
def test_a_train_of_pulses_costs_as_many_pulses() -> None:
    """36 short pulses in 18 minutes take at most 40 times the steps of one."""
    system = problem_a()
    one = PulseWidthModulation(high=6.0, frequency=1.0 / 30.0, duty=0.01)
    steps = [simulate(system, one, 30.0 * count, samples=101, runtime="c").steps for count in (1, 36)]
    assert steps[1] <= 40 * steps[0]


@needs_c
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc on this system")
def test_memory_grows_with_what_is_kept_alone() -> None:
    """A single run keeps the record of its steps and their outputs: below 600 bytes for each of 300,000 steps."""
    code = (
        "import re, sys; sys.path.insert(0, {tests!r})\n"
        "from builders import SINE_A, problem_a\n"
        "from martensite.simulate.api import simulate\n"
        "run = simulate("
        "problem_a(), SINE_A, 60.0, step=60.0 / {steps}, samples=1000, runtime='c')\n"
        "print(run.steps, re.search('VmHWM:.* ([0-9]+) kB', open('/proc/self/status').read())[1])\n"
    )
    found = []
    for steps in (10_000, 300_000):
        text = code.format(tests=str(ROOT / "tests"), steps=steps)
        done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        taken, kilobytes = map(int, done.stdout.split())
        assert taken >= steps
        found.append(kilobytes)
    assert found[0] < 200_000
    assert found[1] < found[0] + 180_000


def test_a_budget_is_kept_to() -> None:
    begin = time.process_time()
    with pytest.raises(Exception, match=r"budget of 0.2 s of CPU time was spent at"):
        simulate(problem_a(), Sine(high=3.0, frequency=5.0), 1000.0, tolerance=1e-9, budget=0.2, runtime="floats")
    assert time.process_time() - begin < 5.0


# ---------------------------------------------------------------- crests


@pytest.mark.parametrize("depth, dips", [(-0.01, True), (0.01, True), (0.05, False), (-0.2, False)])
def test_a_crest_between_points_is_met(depth: float, dips: bool) -> None:
    """Where a parabola may pass 0 that is above it at both ends and in the middle."""
    first, middle, last = (depth + (x - 0.7) ** 2 for x in (0.0, 0.5, 1.0))
    assert find_dip(first, middle, last) == pytest.approx(0.7 if dips else 1.0)
    assert find_dip(-first, -middle, -last) == 1.0


# ---------------------------------------------------------------- narrow strips


@needs_c
@pytest.mark.parametrize("law", [Tanaka, Elahinia], ids=lambda law: law.__name__)
def test_runtimes_agree_on_narrow_strips(law: type[AbstractLaw]) -> None:
    """Strips of 10 mK to 3 K, jumped by every step that crosses them."""
    rng = np.random.default_rng(11)
    for width in 10.0 ** rng.uniform(-2.0, 0.5, 3):
        narrow = LAW_A | {"A_f": LAW_A["A_s"] + width, "M_f": LAW_A["M_s"] - width}
        system = problem_a(element=wire_a(law(**narrow)))
        meant, found = (
            simulate(system, SINE_A, 30.0, step=0.02, samples=101, runtime=name) for name in ("floats", "c")
        )
        assert meant.range("martensite_fraction") > 0.9
        for name in system.convergence_scales():
            apart = np.abs(np.subtract(found[name], meant[name])).max()
            assert apart <= 1e-12 * meant.range(name)
