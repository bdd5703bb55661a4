"""Finger cycle: hybrid law, rate law and an independent stiff solver of the rate law.

The reference solves the three equations of `mas_reference` with the finger's balance written
anew; its angle is a root by SciPy. Geometry and numbers: `finger`.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import mas_reference as reference
import numpy as np
import pytest
from finger import DURATION, NUMBERS, finger, finger_law, trapezoid
from scipy.optimize import brentq

from martensite.simulate.api import simulate

P = SimpleNamespace(**NUMBERS)
AREA, LENGTH, AMBIENT, FILM = np.pi * 0.05e-3**2, 0.44, 295.0, 200.0
MASS, SURFACE = P.density * AREA * LENGTH, np.pi * 0.1e-3 * LENGTH
G, RATE, EXTENSION = 10.6e-3, 50.0, 1e-3
KINKS = (0.0, 3.0, 5.0, 13.0, 15.0, DURATION)
TIMES = np.linspace(0.0, DURATION, 251)
AT_13_S = 130
FULL = {1.5: 92.75, 3.5: 75.44, 5.5: 62.19}
"""Angle [deg] of the whole stroke for r [mm], a = 8 mm; computed for this project."""
SLOW = pytest.mark.slow
QUICK = [(1.5, 8.0), (5.5, 6.0)]
CYCLES = [pytest.param(r, a, marks=[] if (r, a) in QUICK else [SLOW]) for r in FULL for a in (8.0, 6.0)]
TWO = [(1.5, 8.0), pytest.param(3.5, 6.0, marks=SLOW)]


def angle_and_stress(r, a, plus, minus):
    """Where bowed wire and spring are in balance: 2 F dL/dθ = torque of the spring.

    The stiff solver tries fractions beyond their limits; the mechanics stays at them.
    """
    plus, minus = np.clip(plus, 0.0, 1.0), np.clip(minus, 0.0, 1.0)
    phi, radius = np.arctan2(G, r), np.hypot(r, G)
    soft = reference.compliance(P, plus, minus)
    cold = P.eps_T + stress_at(r, a, phi, radius, 0.0) / P.E_M

    def gap(theta):
        shorter = 2 * radius * (np.sin(phi) - np.sin(phi - theta / 2)) / (LENGTH / 2)
        stress = stress_at(r, a, phi, radius, theta)
        return P.eps_T * (plus - minus) + soft * stress - (cold - shorter)

    root: Any = brentq(gap, -0.1, 2 * phi, xtol=1e-13)
    theta = float(root)
    return theta, stress_at(r, a, phi, radius, theta)


def stress_at(r, a, phi, radius, theta):
    """Stress [Pa] of both half wires that balances the spring."""
    torque = RATE * a * (EXTENSION + a * theta)
    return torque / (2 * AREA * radius * np.cos(phi - theta / 2))


@cache
def by_radau(r, a, watts=2.0, rtol=1e-7):
    """Angle [deg], stress, strain, temperature and martensite fraction at the samples."""
    r, a = 1e-3 * r, 1e-3 * a
    levels = (0.0, 0.0, watts, watts, 0.0, 0.0)

    def f(t, y):
        plus, minus, T = y
        _, stress = angle_and_stress(r, a, plus, minus)
        flow = reference.flow(np, reference.special, P, plus, minus, stress, T, "barrier")
        heat = np.interp(t, KINKS, levels) - FILM * SURFACE * (T - AMBIENT)
        return np.array([*flow, (heat / MASS + P.latent_heat * sum(flow)) / P.heat_capacity])

    y = reference.radau(f, (1.0, 0.0, AMBIENT), TIMES, KINKS, rtol)
    angle, stress = np.array([angle_and_stress(r, a, *x) for x in y[:2].T]).T
    strain = P.eps_T * (y[0] - y[1]) + stress * reference.compliance(P, y[0], y[1])
    return columns(np.degrees(angle), stress, strain, y[2], y[0] + y[1])


@cache
def ours(law, r, a, watts=2.0, step=0.02, transit=None):
    """The same by the package."""
    changes = {} if transit is None else {"transit_time": transit}
    system = finger(finger_law(law, **changes), 1e-3 * r, 1e-3 * a)
    run = simulate(system, trapezoid(watts), DURATION, step=step, samples=len(TIMES))
    assert not run.status.failed
    names = ("angle", "stress", "strain", "temperature", "martensite_fraction")
    angle, *others = (np.array(run[name]) for name in names)
    return columns(np.degrees(angle), *others)


def columns(angle, stress, strain, temperature, fraction):
    return SimpleNamespace(angle=angle, stress=stress, strain=strain, temperature=temperature, fraction=fraction)


def apart(a, b):
    """Largest differences over the cycle: degrees, Pa, strain, K."""
    names = ("angle", "stress", "strain", "temperature")
    return [float(np.abs(getattr(a, n) - getattr(b, n)).max()) for n in names]


# ---------------------------------------------------------------- the rate law


@pytest.mark.parametrize("r", [1.5, *(pytest.param(r, marks=SLOW) for r in (3.5, 5.5))])
def test_full_stroke(r):
    """The root of the geometry alone, at the temperature that 2 W holds."""
    found = by_radau(r, 8.0)
    for run in (found, ours("mas", r, 8.0, step=0.1), ours("mas-hybrid", r, 8.0)):
        assert run.angle[AT_13_S] == pytest.approx(FULL[r], abs=0.01)
        assert run.temperature[AT_13_S] == pytest.approx(AMBIENT + 2 / (FILM * SURFACE), abs=0.1)
        assert run.angle[-1] == pytest.approx(0.0, abs=1e-6)
        assert run.fraction[0] == run.fraction[-1] == pytest.approx(1.0)


@pytest.mark.parametrize(("r", "a"), TWO)
def test_the_rate_law_agrees_with_radau(r, a):
    degrees, stress, strain, kelvin = apart(ours("mas", r, a), by_radau(r, a))
    assert degrees < 0.03
    assert stress < 0.02e6
    assert strain < 1e-5
    assert kelvin < 0.02


# ---------------------------------------------------------------- the hybrid law


@pytest.mark.parametrize(("r", "a"), CYCLES)
def test_the_hybrid_law_follows_the_rate_law(r, a):
    degrees, stress, strain, kelvin = apart(ours("mas-hybrid", r, a), by_radau(r, a))
    assert stress < 0.5e6
    assert strain < 5e-4
    assert degrees < 0.5
    assert kelvin < 0.2


@pytest.mark.parametrize(("r", "a"), TWO)
def test_the_hybrid_law_at_the_step_of_the_rate_law(r, a):
    degrees, stress, strain, _ = apart(ours("mas-hybrid", r, a), ours("mas", r, a))
    assert stress < 0.2e6
    assert strain < 2e-4
    assert degrees < 0.5


def test_the_hybrid_law_where_the_stroke_hardly_ends():
    degrees, stress, strain, _ = apart(ours("mas-hybrid", 1.5, 8.0, 1.4), by_radau(1.5, 8.0, 1.4))
    assert stress < 0.5e6
    assert strain < 5e-4
    assert degrees < 0.5


def test_half_the_step_changes_little():
    coarse, fine = (ours("mas-hybrid", 3.5, 8.0, step=h) for h in (0.04, 0.01))
    degrees, stress, _, kelvin = apart(coarse, fine)
    assert degrees < 0.03
    assert stress < 0.02e6
    assert kelvin < 0.01
