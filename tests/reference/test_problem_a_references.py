"""The independent solvers of benchmark problem A give its printed reference numbers.

Two solvers that share no code (a return map for rule P, LSODA on the rate form for rule R) and
the return map with re-anchored memories (rule R again) stand behind every error in the benchmark
tables; here they are held to the printed digits, to each other and to their order.
"""

import ctypes

import numpy as np
import pytest
from benchmarks.inputs import aligned, pulses, pwm, random_steps, sine, split, uniform
from benchmarks.objective import differences, objective
from benchmarks.peers import lsoda_c, ode, return_map, return_map_numpy
from benchmarks.peers.rate_form import make_rates
from benchmarks.problem_a import (
    GRADIENT_P,
    OBJECTIVE_P,
    RANGE_P,
    REFERENCE_P,
    REFERENCE_R,
    Wire,
    displacement,
    lumped,
    one_set,
    parameter_sets,
    rms_error,
    scaled,
    thin_wire,
)

from martensite.kernels.compiler import find_compiler, load_library


def rate_form(drive, setting):
    """x [mm] by LSODA on the rate form."""
    return ode.record(ode.by_odeint, Wire(), drive, setting)


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_rates_in_c_are_those_in_python():
    """The source of truth is the rate form in Python, in both zones, before, in and behind them."""
    rates, rng, count = load_library(lsoda_c.SOURCE).rates, np.random.default_rng(1), 200
    wire = one_set(parameter_sets(1), 0)
    python, numbers = make_rates(wire), np.array(lsoda_c.list_numbers(wire))
    states = np.column_stack([rng.uniform(20.0, 120.0, count), rng.random(count)])
    found = np.empty(2)
    for state, numbers[-1] in zip(states, rng.uniform(0.0, 25.0, count), strict=True):
        arrays = (ctypes.c_void_p(one.ctypes.data) for one in (state, found, numbers))
        rates(ctypes.c_double(0.0), *arrays)
        assert found == pytest.approx(python(state[0], state[1], numbers[-1]), rel=1e-9)


@pytest.fixture(scope="module")
def fine_map():
    """States by rule P with steps of 0.2 ms."""
    return return_map.march(Wire(), uniform(sine(), 500))


@pytest.fixture(scope="module")
def fine_x(fine_map):
    """x [mm] of the fine map."""
    d = lumped(Wire())
    return np.array([displacement(Wire(), d, T, xi) for T, xi, _, _ in fine_map])


@pytest.mark.parametrize("t", REFERENCE_P)
def test_return_map_gives_the_printed_numbers_of_rule_p(t, fine_map, fine_x):
    x, T, xi = REFERENCE_P[t]
    k = round(10 * t)
    assert fine_x[k] == pytest.approx(x, abs=6e-7)
    assert fine_map[k][0] == pytest.approx(T, abs=6e-7)
    assert fine_map[k][1] == pytest.approx(xi, abs=6e-9)


def test_range_of_the_stroke(fine_x):
    assert np.ptp(fine_x) == pytest.approx(RANGE_P, abs=6e-7)


@pytest.fixture(scope="module")
def tight_rate_form():
    """x [mm] by rule R, LSODA with tight tolerances."""
    return rate_form(sine(), ode.TIGHT)


@pytest.mark.parametrize("t", REFERENCE_R)
def test_lsoda_gives_the_printed_numbers_of_rule_r(t, tight_rate_form):
    assert tight_rate_form[round(10 * t)] == pytest.approx(REFERENCE_R[t], abs=6e-7)


def test_re_anchored_return_map_is_rule_r(tight_rate_form, fine_x):
    re_anchored = return_map.displacements(Wire(), uniform(sine(), 100), restart=True)
    assert rms_error(re_anchored, tight_rate_form) < 1e-6  # the cap of the rate form
    assert rms_error(fine_x, tight_rate_form) > 5e-3  # the two rules do differ
    uncapped = rate_form(sine(), ode.Setting(1e-10, 5e-3, beyond=True))
    assert rms_error(re_anchored, uncapped) < 2e-8


def test_numpy_lanes_equal_the_branched_floats():
    sets = parameter_sets(2)
    lanes = return_map_numpy.batch(sets, random_steps(), (20e-3, 40))()
    for i in range(2):
        alone = return_map.displacements(one_set(sets, i), aligned(random_steps(), 20e-3))
        assert rms_error(lanes[i], alone) < 1e-12


def test_printed_objective_and_gradient():
    rows = uniform(sine(), 10)

    def simulate(q):
        return return_map.displacements(scaled(Wire(), q), rows)

    assert objective(simulate) == pytest.approx(OBJECTIVE_P, rel=3e-6)
    assert differences(simulate)() == pytest.approx(GRADIENT_P, abs=1e-6)


@pytest.mark.parametrize("drive", [pwm(), pwm(0.16), random_steps(), pulses(thin_wire())])
def test_steps_carry_the_energy_of_the_input(drive):
    ends = [*drive.edges[1:], drive.duration]
    parts = zip(drive.levels, drive.edges, ends, strict=True)
    energy = sum(held * (b - a) for held, a, b in parts)
    for rows in (uniform(drive, 7), aligned(drive, 3e-3), split(drive, 2, 3)):
        assert len(rows) == 600
        assert sum(dt for row in rows for _, dt in row) == pytest.approx(drive.duration)
        assert sum(U * dt for row in rows for U, dt in row) == pytest.approx(energy)
