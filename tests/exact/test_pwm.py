"""History rules under pulse-width modulation and ripple: `restart` ratchets, `resume` does not.

Strokes of the wire of problem A at 10 Hz and 5 V were computed for this project with steps of
1 ms; near the threshold a uniform grid of 10 ms reads 0.0696 and 0.872 mm at 60 s instead.
"""

import math

import pytest
from builders import ZERO, FunctionWaveform, chamber, law_a, problem_a, through

from martensite.signals.pwm import PulseWidthModulation
from martensite.simulate.api import simulate
from martensite.studies.readings import choose_runtime


def strokes(rule, duty, step=1e-3):
    """Stroke [mm] after 20 and 60 s, at the end of a period."""
    wave = PulseWidthModulation(high=5.0, frequency=10.0, duty=duty)
    run = simulate(problem_a(rule), wave, 60.0, step=step, samples=601, runtime=choose_runtime())
    return [1e3 * run["position"][k] for k in (200, 600)]


PRINTED = {
    (0.15, "resume"): (0.022, 0.022),
    (0.15, "restart"): (0.022, 0.022),
    (0.16, "resume"): (0.075, 0.086),
    (0.16, "restart"): (0.27, 1.04),
    (0.17, "resume"): (1.34, 2.21),
    (0.17, "restart"): (2.82, 9.09),
}


@pytest.mark.parametrize(("duty", "rule"), PRINTED)
def test_printed_strokes(duty, rule):
    at_20, at_60 = PRINTED[duty, rule]
    found = strokes(rule, duty)
    assert found == pytest.approx([at_20, at_60], rel=0.01, abs=6e-4)


def test_resume_settles_and_restart_creeps():
    wave = PulseWidthModulation(high=5.0, frequency=10.0, duty=0.16)
    for rule, creeps in (("resume", False), ("restart", True)):
        run = simulate(problem_a(rule), wave, 60.0, step=1e-3, samples=601, runtime=choose_runtime())
        late = 1e3 * (run["position"][600] - run["position"][500])
        assert (late > 0.1) == creeps
        assert (late < 0.005) != creeps


@pytest.mark.parametrize("rule", ["resume", "restart"])
def test_steps_on_the_edges_need_not_be_short(rule):
    """The grid follows the jumps: 10 ms steps read what 1 ms steps read."""
    assert strokes(rule, 0.16, step=10e-3) == pytest.approx(strokes(rule, 0.16), rel=0.02)


# ---------------------------------------------------------------- ripple of the temperature


def ripple(rule, cycles=30):
    """ξ after heating to 73 °C, and after each whole cycle of ±1 °C around it."""

    def kelvin(t):
        return 73 + ZERO + (t - 1.0) * 53.0 if t < 1.0 else (73 + ZERO + math.sin(2 * math.pi * (t - 1.0)))

    wave = FunctionWaveform(function=kelvin, kinks=(1.0,))
    duration = float(cycles + 1)
    run = simulate(chamber(law_a(rule)), wave, duration, step=2e-3, samples=cycles + 2)
    return run["martensite_fraction"][1:]


def hot(celsius):
    return math.cos(0.05 * math.pi * (celsius - 68.0)) ** 2


def test_resume_does_not_ratchet_under_ripple():
    found = ripple("resume")
    assert found[0] == pytest.approx(0.5, abs=1e-7)
    assert found[1:] == pytest.approx([hot(74)] * 30, abs=1e-5)


def test_restart_ratchets_under_ripple():
    """Every cycle multiplies ξ by w_A(74)/w_A(72)."""
    found = ripple("restart")
    # first up to 74, then 74 → 72 → 74 per cycle, and back at 73 on the way down
    for n in range(1, 31):
        per_cycle = hot(74) / hot(72)
        expected = 0.5 * (hot(74) / hot(73)) * per_cycle ** (n - 1) * (hot(73) / hot(72))
        assert found[n] == pytest.approx(expected, rel=1e-3, abs=0), n
    assert found[30] < 1e-8


@pytest.mark.parametrize("rule", ["resume", "restart"])
def test_triangles_of_the_same_size(rule):
    """The same with straight lines: exact in a single step per leg."""
    points = [20.0, 74.0, *[72.0, 74.0] * 20]
    wave = through([p + ZERO for p in points])
    run = simulate(chamber(law_a(rule)), wave, float(len(points) - 1), step=1.0, samples=42)
    stays = hot(74)
    expected = stays if rule == "resume" else stays * (hot(74) / hot(72)) ** 20
    assert run["martensite_fraction"][-1] == pytest.approx(expected, rel=1e-6, abs=0)
