"""Order of the step of the single crystal: second where rates grow, first where they fall.

Coupled with a spring and the heat balance the forms with a saddle are of second order: a plateau
is held by feedback, at a nearly constant rate; so are the models of variable heat. The form `well`,
whose prefactor counts at the end of a step, leaves a small term of first order.
"""

from functools import cache

import numpy as np
import pytest
from benchmarks.problem_b import Wire, stiff, system, waveform
from mas_paths import follow, table_1

from martensite.kernels.compiler import find_compiler
from martensite.simulate.api import simulate

STEPS = (20e-3, 10e-3, 5e-3, 2.5e-3)
FINE = {1.0: 0.1e-3, 2.0: 0.4e-3}
"""Step [s] whose error is below 4 % of those of `STEPS`, by the order."""


def slope(steps, errors):
    """Observed order: slope of log(error) over log(step)."""
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def rms(found, exact):
    return np.sqrt(np.mean((found - exact) ** 2)) / np.ptp(exact)


# ---------------------------------------------------------------- prescribed stress


def fractions_after(law, corners, step):
    """x₊ at every second."""
    path = follow(law, (0.0, 0.0), corners, step)
    seconds = np.arange(0.0, corners[-1][0] + 0.5)
    return np.interp(seconds, path.time, path.plus)


TOPS = {"barrier": 139e6, "edge": 127e6, "well": 127e6}
"""Stress [Pa] below the threshold of 141 MPa at which a tenth to a quarter transforms."""


def path_order(form, corners, order=1.0):
    law = table_1(rates=form, layer_volume=1e-23)
    exact = fractions_after(law, corners, FINE[order])[-1]
    assert 0.05 < exact < 0.9
    errors = [abs(fractions_after(law, corners, h)[-1] - exact) for h in STEPS]
    return slope(STEPS, errors)


def rising(form):
    """Loading and cooling at once: the roots of the barriers do not run quite straight."""
    return [(0.0, 0.0, 370.0), (10.0, TOPS[form] + 0.5e6, 355.0)]


@pytest.mark.parametrize(("form", "order"), [("barrier", 2.0), ("edge", 2.0), ("well", 1.0)])
def test_order_while_rates_grow(form, order):
    assert path_order(form, rising(form), order) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("form", TOPS)
def test_first_order_while_rates_fall(form):
    falling = [(0.0, TOPS[form], 355.0), (1.0, TOPS[form] - 10e6, 355.0)]
    assert path_order(form, falling) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("form", ["barrier", "edge"])
def test_loading_alone_is_exact_in_any_step(form):
    """At constant temperature the mean of a growing rate is a closed integral."""
    law = table_1(rates=form, layer_volume=1e-23)
    corners = [(0.0, 0.0, 355.0), (10.0, TOPS[form], 355.0)]
    fine, coarse = (fractions_after(law, corners, h)[-1] for h in (1e-3, 1.0))
    assert fine > 0.05
    assert coarse == pytest.approx(fine, abs=1e-9)


# ---------------------------------------------------------------- coupled


@cache
def stroke(step, wire="nominal", **options):
    p = stiff(Wire()) if wire == "stiff" else Wire()
    runtime = "c" if find_compiler() else "floats"
    run = simulate(system(p, **options), waveform(), 20.0, step=step, samples=201, runtime=runtime)
    return np.array(run["position"])


def coupled_order(**options):
    errors = [rms(stroke(h, **options), stroke(0.625e-3, **options)) for h in STEPS[:3]]
    return slope(STEPS[:3], errors)


@pytest.mark.parametrize(
    ("options", "least", "most"),
    [
        ({"rates": "edge"}, 1.9, 2.1),
        ({"rates": "edge", "wire": "stiff"}, 1.7, 2.4),
        ({"rates": "barrier"}, 1.7, 2.4),
        ({"rates": "well"}, 0.9, 1.3),
        ({"rates": "edge", "heat_model": "stress"}, 1.9, 2.1),
        ({"rates": "edge", "heat_model": "free-energy"}, 1.9, 2.1),
    ],
    ids=["edge", "edge-stiff", "barrier", "well", "stress", "free-energy"],
)
def test_order_on_problem_b(options, least, most):
    assert least < coupled_order(**options) < most
