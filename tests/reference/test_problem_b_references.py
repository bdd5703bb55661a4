"""Problem B: printed numbers, an independent stiff solver, and the package agree.

Errors are shares of the range of the stroke: rms over 201 samples as in the benchmark tables, or
the largest where it says so.
"""

import ctypes
from functools import cache

import mas_reference as reference
import numpy as np
import pytest
from benchmarks import problem_b
from benchmarks.peers import mas_lsoda_c, mas_ode
from benchmarks.problem_b import RANGE, REFERENCE, Wire, lumped, stiff, system, waveform

from martensite.kernels.compiler import find_compiler, load_library
from martensite.simulate.api import simulate

TIMES = np.linspace(0.0, problem_b.DURATION, 201)
START = (1.0, 0.0, 293.0)
WIRES = {"nominal": Wire(), "stiff": stiff(Wire())}


def watts(t):
    return np.interp(t, *problem_b.POWER)


def right_side(wire, form):
    p = WIRES[wire]
    return reference.actuator(p, lumped(p), form, watts)


@cache
def by_radau(wire="nominal", form="edge"):
    """Rows x₊, x₋, T and x [m] at the samples; tightest for the case whose numbers are printed."""
    rtol = 1e-11 if (wire, form) == ("nominal", "edge") else 1e-8
    y = reference.radau(right_side(wire, form), START, TIMES, problem_b.POWER[0], rtol)
    return np.array([*y, reference.displacement(WIRES[wire], lumped(WIRES[wire]), y)])


@cache
def ours(step, wire="nominal", form="edge"):
    """Rows x₊, x₋, T and x [m] at the samples."""
    run = simulate(system(WIRES[wire], rates=form), waveform(), 20.0, step=step, samples=201)
    assert not run.warnings
    total, oriented = (np.array(run[n]) for n in ("martensite_fraction", "oriented_fraction"))
    halves = 0.5 * (total + oriented), 0.5 * (total - oriented)
    return np.array([*halves, run["temperature"], run["position"]])


def apart(a, b):
    """rms and largest difference of the strokes over their range."""
    gap = np.abs(a[3] - b[3]) / np.ptp(b[3])
    return np.sqrt((gap**2).mean()), gap.max()


# ---------------------------------------------------------------- right-hand side in C


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
def test_rates_in_c_are_those_in_python():
    """The source of truth is the right-hand side in Python, on both sides of every threshold."""
    rates, rng, kink = load_library(mas_lsoda_c.SOURCE).rates, np.random.default_rng(1), (3.0, 0.5, 0.4)
    python, numbers = mas_ode.make_rhs(Wire(), "edge")(*kink), np.array([*mas_lsoda_c.list_numbers(Wire()), *kink])
    for plus, minus, T in rng.uniform((0.0, 0.0, 280.0), (0.5, 0.5, 400.0), (200, 3)):
        state, slope = np.array([plus, minus, T]), np.empty(3)
        rates(ctypes.c_double(4.0), *(ctypes.c_void_p(one.ctypes.data) for one in (state, slope, numbers)))
        assert slope == pytest.approx(python(4.0, state), rel=1e-9)


# ---------------------------------------------------------------- printed numbers


@pytest.mark.parametrize("t", REFERENCE)
def test_radau_gives_the_printed_numbers(t):
    x, T, plus = REFERENCE[t]
    found = by_radau()[:, round(10 * t)]
    assert 1e3 * found[3] == pytest.approx(x, abs=2e-6)
    assert found[2] == pytest.approx(T, abs=2e-6)
    assert found[0] == pytest.approx(plus, abs=3e-8)
    assert 1e3 * np.ptp(by_radau()[3]) == pytest.approx(RANGE, abs=2e-6)


def error_at(step):
    """Largest difference to the printed stroke, temperature and x₊ as shares of their ranges."""
    found = ours(step)[:, [round(10 * t) for t in REFERENCE]]
    x, T, plus = np.array(list(REFERENCE.values())).T
    return [
        np.abs(1e3 * found[3] - x).max() / RANGE,
        np.abs(found[2] - T).max() / np.ptp(ours(step)[2]),
        np.abs(found[0] - plus).max(),
    ]


def test_steps_of_20_ms_give_the_printed_numbers():
    assert max(error_at(20e-3)) < 1e-5


def test_half_the_step_leaves_a_quarter_of_the_error():
    coarse, middle, fine = (np.array(error_at(h)) for h in (20e-3, 10e-3, 5e-3))
    assert coarse / middle == pytest.approx(4.0, abs=0.3)
    assert middle / fine == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize(
    ("wire", "form", "tolerance"),
    [
        ("nominal", "edge", 1e-4),
        ("stiff", "edge", 1e-4),
        pytest.param("nominal", "barrier", 1e-4, marks=pytest.mark.slow),
        pytest.param("nominal", "well", 5e-4, marks=pytest.mark.slow),
    ],
)
def test_the_tolerance_is_met(wire, form, tolerance):
    run = simulate(system(WIRES[wire], rates=form), waveform(), 20.0, tolerance=tolerance, samples=201)
    columns = (run["martensite_fraction"], run["temperature"], run["position"])
    exact = by_radau(wire, form)
    for found, truth in zip(columns, (exact[0] + exact[1], *exact[2:]), strict=True):
        assert np.abs(found - truth).max() / np.ptp(truth) < tolerance
    assert run.accuracy is not None
    assert run.accuracy <= tolerance


# ---------------------------------------------------------------- the stiff solver


@pytest.mark.parametrize(
    ("wire", "form", "step", "rms", "largest"),
    [
        ("nominal", "edge", 20e-3, 1e-5, 1e-4),
        ("nominal", "barrier", 20e-3, 1e-5, 1e-4),
        ("nominal", "well", 20e-3, 1e-4, 1e-3),
        pytest.param("nominal", "well", 5e-3, 1e-5, 1e-4, marks=pytest.mark.slow),
        ("stiff", "edge", 20e-3, 1e-4, 2e-4),
        ("stiff", "edge", 10e-3, 1e-5, 1e-4),
        pytest.param("stiff", "barrier", 20e-3, 1e-4, 1e-4, marks=pytest.mark.slow),
        pytest.param("stiff", "well", 20e-3, 1e-4, 2e-4, marks=pytest.mark.slow),
    ],
)
def test_the_package_agrees_with_radau(wire, form, step, rms, largest):
    found = apart(ours(step, wire, form), by_radau(wire, form))
    assert found[0] < rms
    assert found[1] < largest


def test_the_forms_are_not_alike():
    assert apart(by_radau(form="barrier"), by_radau())[1] > 0.02
    assert apart(by_radau(form="well"), by_radau())[1] > 2e-3


def test_the_package_fails_in_no_case_within_reach():
    """Steps far too long for the transformation, thinner barriers still: never wrong by much."""
    for step in (50e-3, 100e-3):
        for wire in WIRES:
            assert apart(ours(step, wire), by_radau(wire))[0] < 2e-3
