"""Problem B by Kvaerno5 of diffrax: a second solver and a second array library.

All of it is slow: what the package computes is compared with the printed numbers in `test_problem_b_references.py`, and
that Kvaerno5 gives these changes with no line of the package.
"""

import mas_reference as reference
import numpy as np
import pytest
from benchmarks import problem_b
from benchmarks.problem_b import REFERENCE, Wire, lumped, stiff, system, waveform

from martensite.simulate.api import simulate

pytestmark = pytest.mark.slow

TIMES = np.linspace(0.0, problem_b.DURATION, 201)


def by_kvaerno(p, form):
    """x₊, T and the stroke [m] at the samples."""
    pytest.importorskip("diffrax")
    y = reference.kvaerno(p, lumped(p), form, (1.0, 0.0, 293.0), TIMES, problem_b.POWER)
    return y[0], y[2], reference.displacement(p, lumped(p), y)


@pytest.mark.parametrize(
    ("form", "wire", "step"),
    [("edge", Wire(), 10e-3), ("edge", stiff(Wire()), 10e-3), ("barrier", Wire(), 10e-3), ("well", Wire(), 5e-3)],
    ids=["edge", "edge-stiff", "barrier", "well"],
)
def test_the_package_agrees_with_kvaerno(form, wire, step):
    fraction, temperature, x = by_kvaerno(wire, form)
    run = simulate(system(wire, rates=form), waveform(), 20.0, step=step, samples=201)
    assert np.abs(run["position"] - x).max() / np.ptp(x) < 1e-4
    assert np.abs(np.array(run["martensite_fraction"]) - fraction).max() < 1e-4
    assert np.abs(run["temperature"] - temperature).max() / np.ptp(temperature) < 1e-4


def test_kvaerno_gives_the_printed_numbers():
    fraction, temperature, x = by_kvaerno(Wire(), "edge")
    for t, (mm, T, plus) in REFERENCE.items():
        k = round(10 * t)
        assert 1e3 * x[k] == pytest.approx(mm, abs=2e-5)
        assert temperature[k] == pytest.approx(T, abs=2e-5)
        assert fraction[k] == pytest.approx(plus, abs=1e-6)
