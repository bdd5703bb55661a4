"""Steps of order five of a wire with a strip law.

Source of truth: order of accuracy against the map in thousands of short steps, which shares neither stages nor drive
with them; and runs by the map alone.
"""

from __future__ import annotations

import numpy as np
import pytest
from builders import problem_a

import martensite as ms
from martensite.signals.reader import Reader
from martensite.simulate.adaptive import STIFF, AdaptiveMarch
from martensite.simulate.compiled import compile_march, feed_step
from martensite.simulate.envelope import envelope_of
from martensite.simulate.march import SOLVED
from martensite.simulate.marching import MarchPlan

WAVE = ms.Sine(low=0.3, high=3.4, frequency=0.1)
MODES = {"elastic": 3.0, "reverse": 14.3, "forward": 11.0}
"""Times [s] at which one process acts for at least half a second."""


@pytest.fixture(scope="module")
def wire():
    """Functions of problem A, the place of ξ and T in its state, and a reader of the drive."""
    whole = problem_a()
    compiled = compile_march(whole)
    functions = compiled.program.bind_floats(*compiled.values(whole))
    shown = functions["points"](*range(compiled.size))
    return functions, compiled.size, (int(shown[2]), int(shown[0])), Reader(WAVE)


def march(wire, state, begin, length, steps):
    """The state after a time by the map, in short steps of second order."""
    functions, size, _, reader = wire
    for k in range(steps):
        a, b = begin + length * k / steps, begin + length * (k + 1) / steps
        state = functions["step"](*state, *feed_step(reader.moments(a, b)), b - a)[:size]
    return state


def step_at_once(wire, state, begin, length):
    """All numbers of one step of order five."""
    functions, _, _, reader = wire
    middle = begin + 0.5 * length
    halves = reader.moments(begin, middle), reader.moments(middle, begin + length)
    return functions["surface"](*state, *(x for one in halves for x in feed_step(one)), length)


@pytest.mark.parametrize("mode", MODES)
def test_a_step_has_order_five_and_its_middle_order_four(wire, mode):
    functions, size, places, _ = wire
    begin = MODES[mode]
    start = march(wire, functions["init"](0.3), 0.0, begin, 3000)
    ends, middles = [], []
    for length in (0.4, 0.2):
        found = step_at_once(wire, start, begin, length)
        coarse, fine = (march(wire, start, begin, length, n) for n in (800, 1600))
        half = [march(wire, start, begin, 0.5 * length, n) for n in (400, 800)]
        exact, halfway = ([(4.0 * b[k] - a[k]) / 3.0 for k in places] for a, b in ((coarse, fine), half))
        ends.append([abs(found[k] - x) for k, x in zip(places, exact, strict=True)])
        middles.append([abs(found[size + k] - x) for k, x in zip(places, halfway, strict=True)])
    assert max(ends[1]) < 1e-6
    for at, order, least in ((ends, 5.5, 2e-9), (middles, 4.5, 2e-9)):
        first, second = max(at[0]), max(at[1])
        assert first > 2.0**order * second or first < least


def test_a_step_over_an_unseen_process_is_refused(wire):
    """Cooling from austenite through the whole forward strip in one step leaves a mismatch or a large error."""
    functions, size, (fraction, _), _ = wire
    hot = march(wire, functions["init"](0.3), 0.0, 8.0, 3000)
    assert hot[fraction] == 0.0
    found = step_at_once(wire, hot, 8.0, 3.0)
    residual, changed = found[-2], abs(found[fraction] - found[2 * size + fraction])
    assert residual > SOLVED or changed > 1e-3


def test_long_steps_at_rest_take_the_map():
    whole = problem_a()
    compiled = compile_march(whole)
    functions = compiled.program.bind_floats(*compiled.values(whole))
    times = [0.0, 3600.0]
    march = AdaptiveMarch(
        MarchPlan(compiled, [ms.Constant(level=1.0)], times, 1e-4, 0.1, envelope_of(whole)), functions
    )
    run = march.run()
    assert run.steps < 200
    assert march.decay * run.longest > STIFF


@pytest.mark.parametrize("rule", ["resume", "restart", "return-point"])
@pytest.mark.parametrize(("low", "frequency"), [(0.3, 0.1), (1.2, 0.7)])
def test_a_run_is_that_by_the_map(rule, low, frequency, monkeypatch):
    whole, tolerance = problem_a(rule), 3e-6
    compiled = compile_march(whole)
    functions = compiled.program.bind_floats(*compiled.values(whole))
    wave, times = ms.Sine(low=low, high=3.4, frequency=frequency), np.linspace(0.0, 30.0, 201).tolist()
    plan = MarchPlan(compiled, [wave], times, tolerance, 0.02, envelope_of(whole))
    fast = AdaptiveMarch(plan, functions).run()
    monkeypatch.setattr(MarchPlan, "order", 2)
    slow = AdaptiveMarch(plan, functions).run()
    assert fast.steps < 0.7 * slow.steps
    for name in whole.convergence_scales():
        place = compiled.outputs.index(name)
        first, second = (np.array([row[place] for row in run.rows]) for run in (fast, slow))
        assert np.abs(first - second).max() <= 40.0 * tolerance * np.ptp(second)
