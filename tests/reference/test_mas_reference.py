"""The single crystal on prescribed paths against Radau on the printed equations.

Errors are shares of the range of the answer: strain where stress is prescribed, stress where
strain is.
"""

from functools import cache

import mas_reference as reference
import numpy as np
import pytest
from benchmarks.problem_b import Wire
from mas_paths import TABLE_1, follow, table_1, there_and_back
from scipy import special

from martensite.kernels import floats

CRYSTAL = Wire()._replace(**TABLE_1)
FORMS = ("barrier", "edge", "well")
PATHS = 1


def quick(*forms):
    """All forms; those not named with the slow tests."""
    return [f if f in forms else pytest.param(f, marks=pytest.mark.slow) for f in FORMS]


def column(corners, i):
    """Linear interpolation of column i between the corners."""
    table = np.array(corners)
    return lambda t: np.interp(t, table[:, 0], table[:, i])


def samples(corners):
    """Five per second, the corners included."""
    return np.linspace(0.0, corners[-1][0], int(corners[-1][0]) * 5 + 1)


def strain_by_radau(corners, start, form, p=CRYSTAL):
    """Strain at the samples of a path of stress and temperature."""
    stress, temperature = column(corners, 1), column(corners, 2)

    def at(t, plus, minus):
        return stress(t), temperature(t)

    times = samples(corners)
    x = reference.radau(reference.bare(p, form, at), start, times, [c[0] for c in corners])
    return p.eps_T * (x[0] - x[1]) + stress(times) * reference.compliance(p, *x)


def stress_by_radau(corners, start, form, p=CRYSTAL):
    """Stress [Pa] at the samples of a path of strain at constant temperature."""
    strain, times = column(corners, 1), samples(corners)
    at = reference.strained(p, strain, corners[0][2])
    x = reference.radau(reference.bare(p, form, at), start, times, [c[0] for c in corners])
    return (strain(times) - p.eps_T * (x[0] - x[1])) / reference.compliance(p, *x)


def at_samples(path, name):
    return np.interp(samples([(path.time[-1],)]), path.time, getattr(path, name))


def apart(found, exact):
    """rms and largest difference over the range."""
    gap = np.abs(found - exact) / np.ptp(exact)
    return np.sqrt((gap**2).mean()), gap.max()


# ---------------------------------------------------------------- rates


@pytest.mark.parametrize("form", FORMS)
def test_rates_are_those_of_the_printed_formulas(form):
    law = table_1(rates=form)
    compared = 0
    for T in (290.0, 321.0, 345.0, 380.0):
        for stress in np.linspace(-150e6, 350e6, 51):
            found = law.jump_rates(floats, float(stress), T)
            printed = reference.rates(np, special, CRYSTAL, stress, T, form)
            for a, b in zip(found, printed, strict=False):
                if b > 1e-250:
                    assert a == pytest.approx(b, rel=1e-9)
                    compared += 1
    assert compared > 150


# ---------------------------------------------------------------- stress prescribed


@cache
def random_case(k):
    """Corners of a path through all thresholds, both signs of stress, and x₊, x₋."""
    rng = np.random.default_rng([20, k])
    times = np.cumsum([0, *rng.integers(1, 6, 6)]).astype(float)
    stress, temperature = rng.uniform(-60e6, 220e6, 7), rng.uniform(300.0, 370.0, 7)
    corners = list(zip(times.tolist(), stress.tolist(), temperature.tolist(), strict=True))
    return corners, tuple(rng.dirichlet([1.0, 1.0, 1.0])[:2].tolist())


@pytest.mark.parametrize("form", quick("edge"))
def test_random_paths_converge_to_the_equations(form):
    """Up to 100 MPa/s and 30 K/s, turning in the middle of transformations."""
    errors = []
    for k in range(PATHS):
        corners, start = random_case(k)
        exact = strain_by_radau(corners, start, form)
        assert np.ptp(exact) > 0.03
        found = (follow(table_1(rates=form), start, corners, h) for h in (4e-3, 1e-3))
        errors.append([apart(at_samples(path, "strain"), exact)[1] for path in found])
    coarse, fine = np.array(errors).max(axis=0)
    assert fine < (2e-2 if form == "well" else 1e-3)
    assert fine < 0.4 * coarse


@pytest.mark.parametrize(
    ("mpa", "form"),
    [(2.0, "edge"), (2.0, "well"), (150.0, "barrier"), pytest.param(150.0, "well", marks=pytest.mark.slow)],
)
def test_heating_and_cooling_at_constant_stress(form, mpa):
    """At 1 K/s: complete transformations."""
    corners = [(0.0, mpa * 1e6, 290.0), (110.0, mpa * 1e6, 400.0), (220.0, mpa * 1e6, 290.0)]
    exact = strain_by_radau(corners, (1.0, 0.0), form)
    found = follow(table_1(rates=form), (1.0, 0.0), corners, 10e-3)
    assert apart(at_samples(found, "strain"), exact)[0] < 1e-4
    assert apart(at_samples(found, "strain"), exact)[1] < (1e-2 if form == "well" else 1e-3)


# ---------------------------------------------------------------- strain prescribed


STRETCHED = [(355.0, (0.0, 0.0)), (325.0, (0.0, 0.0)), (305.0, (0.5, 0.5))]
QUICK = [("edge", 355.0), ("edge", 305.0), ("barrier", 305.0)]
"""The others repeat them: with the slow tests."""


@pytest.mark.parametrize(
    ("form", "T", "start"),
    [
        pytest.param(form, *case, marks=[] if (form, case[0]) in QUICK else [pytest.mark.slow])
        for form in FORMS
        for case in STRETCHED
    ],
)
def test_stretching_at_constant_rate(form, T, start):
    corners = there_and_back(0.05, 1e-3, T)
    exact = stress_by_radau(corners, start, form)
    found = follow(table_1(rates=form), start, corners, 0.1, "strain")
    assert found.residual < 1e-12
    rms, largest = apart(at_samples(found, "stress"), exact)
    assert rms < 1e-4
    assert largest < 1e-3
