"""Polycrystal: the single crystal at zero spread, slopes, minor loops, the lost variant.

With the numbers of Table 1 (`mas_paths`) unless it says problem B.
"""

from functools import cache
from statistics import NormalDist

import numpy as np
import pytest
from benchmarks.problem_b import Wire, system, waveform
from builders import FunctionWaveform
from mas_paths import follow, table_1

from martensite.actuators.assembly import System
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.physics.laws.mas_polycrystal import MullerAchenbachSeeleckePolycrystal
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.simulate.api import simulate

COLUMNS = ("temperature", "martensite_fraction", "oriented_fraction", "stress", "position")


def polycrystal(**changes):
    return table_1(MullerAchenbachSeeleckePolycrystal, **changes)


# ---------------------------------------------------------------- zero spread


def largest_gap(spread, distribution, runtime, step=50e-3):
    """Of problem B by the single crystal and by the polycrystal, as a share of range."""
    crystal = system(Wire(), rates="barrier")
    groups = system(Wire(), "mas-polycrystal", spread=spread, distribution=distribution, groups="15")
    a, b = (simulate(whole, waveform(), 20.0, step=step, samples=201, runtime=runtime) for whole in (crystal, groups))
    return max(np.abs(np.subtract(a[n], b[n])).max() / np.ptp(a[n]) for n in COLUMNS)


@pytest.mark.parametrize("distribution", ["barriers", pytest.param("internal-stress", marks=pytest.mark.slow)])
def test_zero_spread_is_the_single_crystal(distribution):
    assert largest_gap(0.0, distribution, "floats") < 1e-10


# ---------------------------------------------------------------- the distribution

LOADING = [(0.0, 0.0, 355.0), (250.0, 250e6, 355.0), (500.0, 0.0, 355.0)]


@cache
def loaded(groups, spread=20e6):
    """Fraction over time at 1 MPa/s up and down; without groups, the continuous distribution."""
    if groups != "continuous":
        path = follow(polycrystal(groups=groups, spread=spread), (0.0, 0.0), LOADING, 0.2)
        return path.plus
    shifts = [spread * NormalDist().inv_cdf((k + 0.5) / 61) for k in range(61)]
    crystals = (follow(table_1(sigma_L=1e6 + d), (0.0, 0.0), LOADING, 0.2) for d in shifts)
    return np.mean([path.plus for path in crystals], axis=0)


def test_groups_are_single_crystals_with_shifted_thresholds():
    """Up to the slope of the bridge, which is that of the mean threshold for all groups."""
    shifts = [20e6 * NormalDist().inv_cdf((k + 0.5) / 15) for k in range(15)]
    crystals = [follow(table_1(sigma_L=1e6 + d), (0.0, 0.0), LOADING, 0.2).plus for d in shifts]
    gap = np.abs(loaded("15") - np.mean(crystals, axis=0))
    assert gap.max() < 5e-3
    assert gap.mean() < 2e-4


SEVERAL = pytest.mark.slow
"""More spreads than one."""


def duration_of_plateau(spread):
    """From a tenth to nine tenths of the transformation [s]."""
    times = np.linspace(0.0, 500.0, 2501)[:1251]
    fraction = loaded("31", spread)[:1251]
    return float(np.interp(0.9, fraction, times) - np.interp(0.1, fraction, times))


@pytest.mark.parametrize(
    ("spread", "seconds"),
    [(20e6, 51.3), pytest.param(10e6, 25.6, marks=SEVERAL), pytest.param(30e6, 76.9, marks=SEVERAL)],
)
def test_plateaus_get_slopes(spread, seconds):
    """At 1 MPa/s: 2 x 1.28 standard deviations."""
    assert duration_of_plateau(spread) == pytest.approx(seconds, rel=0.06)


# ---------------------------------------------------------------- minor loops


def loop(law, temperatures, stress=100e6):
    """The law from austenite through temperatures at 1 K/s; indices of the corners."""
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(temperatures)))])
    corners = [(t, stress, T) for t, T in zip(times.tolist(), temperatures, strict=True)]
    path = follow(law, (0.0, 0.0), corners, 0.05)
    return path, [int(np.argmin(np.abs(path.time - t))) for t in times]


INNER = [385.0, 344.0, 363.0, 344.0, 363.0, 300.0]


def test_minor_loops_are_smooth_and_close():
    path, at = loop(polycrystal(), INNER)
    assert np.abs(np.diff(path.plus)).max() < 1.05 / 31
    turning, again = path.plus[at[1:4:2]]
    assert 0.3 < turning < 0.9
    assert again == pytest.approx(turning, abs=2e-3)
    assert path.plus[at[4]] == pytest.approx(path.plus[at[2]], abs=2e-3)
    assert path.plus[at[2]] < turning - 0.2
    assert path.plus[-1] == pytest.approx(1.0, abs=1e-6)


def test_a_single_crystal_has_no_minor_loops():
    path, at = loop(table_1(), INNER)
    assert np.abs(np.diff(path.plus)).max() > 0.2
    assert set(np.round(path.plus[at], 3)) <= {0.0, 1.0}


# ---------------------------------------------------------------- internal stress loses stroke


def on_a_weak_spring(distribution):
    """Strain [%] before and after heating and cooling, and x₋ then; about 20 MPa when cold."""
    problem = system(Wire(), "mas-polycrystal", groups="15")
    law = polycrystal(groups="15", distribution=distribution)
    element = problem.element
    wire = type(element)(
        diameter=element.diameter,
        length=element.length,
        density=6500.0,
        heat_capacity=500.0,
        latent_heat=25e3,
        law=law,
        resistance=element.resistance,
    )
    actuator = System(
        element=wire,
        source=problem.source,
        mechanism=BiasSpring(stiffness=10.0, preload=0.157),
        environment=Environment(temperature=295.0, cooling=ConstantCooling(h=200.0)),
    )
    watts = FunctionWaveform(function=lambda t: 2.6 * max(0.0, 1 - abs(t - 5) / 4), kinks=(1, 5, 9))
    run = simulate(actuator, watts, 14.0, step=50e-3, samples=141)
    assert min(run["martensite_fraction"]) < 0.01
    minus = 0.5 * (run["martensite_fraction"][-1] - run["oriented_fraction"][-1])
    return 100 * run["strain"][0], 100 * run["strain"][-1], minus


def test_a_wire_with_internal_stresses_does_not():
    """Groups with σ + σᵢ < 0 turned into M-: a weak spring cannot turn them back."""
    before, after, minus = on_a_weak_spring("internal-stress")
    assert before == pytest.approx(4.07, abs=0.005)
    assert after == pytest.approx(3.07, abs=0.02)  # 2 ε_T x₋ is lost
    assert minus == pytest.approx(0.127, abs=0.005)
