"""Single crystal: plateaus, residual strain, thermal thresholds, low bias, heat.

Unless it says otherwise with the numbers of Table 1 (`mas_paths`) and the barrier form of the
rates. Expected values were computed for this project with independent stiff solvers.
"""

import numpy as np
import pytest
from mas_paths import TABLE_1, follow, table_1, there_and_back

from martensite.base.errors import ParameterError
from martensite.kernels import floats

AUSTENITE, TWINNED, ORIENTED = (0.0, 0.0), (0.5, 0.5), (1.0, 0.0)


def stretched(T, start=AUSTENITE, rate=1e-3, law=None):
    """To 5 % strain and back; steps of 0.01 % strain."""
    return follow(law or table_1(), start, there_and_back(0.05, rate, T), 1e-4 / rate, "strain")


def plateaus(path, strain=0.02):
    """Stress [MPa] at a strain on loading and on unloading."""
    n = len(path.time) // 2 + 1
    up = np.interp(strain, path.strain[:n], path.stress[:n])
    down = np.interp(-strain, -path.strain[n:], path.stress[n:])
    return up / 1e6, down / 1e6


def residual_strain(path):
    """Strain where unloading reaches zero stress."""
    k = len(path.time) // 2
    while path.stress[k] > 1e3:
        k += 1
    share = path.stress[k - 1] / (path.stress[k - 1] - path.stress[k])
    return path.strain[k - 1] + share * (path.strain[k] - path.strain[k - 1])


# ---------------------------------------------------------------- plateaus


def test_between_the_temperatures_martensite_stays():
    path = stretched(325.0)
    assert plateaus(path)[0] == pytest.approx(19.7, abs=0.05)
    assert residual_strain(path) == pytest.approx(0.04, abs=2e-4)


# ---------------------------------------------------------------- the threshold never negative


def test_cold_austenite_is_gone_without_stress():
    """σ_A would be -99 MPa at 295 K; limited to zero, no plateau is negative."""
    law = table_1()
    assert law.linear_transition_stress(295.0) == pytest.approx(-99e6)
    up, down = plateaus(stretched(295.0, TWINNED, law=law))
    assert up == pytest.approx(50.7, abs=0.05)
    assert down == pytest.approx(-50.7, abs=0.1)  # symmetric: back to the other variant


# ---------------------------------------------------------------- heating and cooling


@pytest.mark.parametrize(
    ("form", "mpa", "minus"),
    [
        ("barrier", 0.0, 0.5),
        ("barrier", 0.25, 0.027),
        ("barrier", 0.5, 0.0),
        ("barrier", 1.0, 0.0),
        ("well", 0.0, 0.5),
        ("well", 0.25, 0.35),
        ("well", 0.5, 0.22),
        ("well", 1.0, 0.067),
        ("well", 2.0, 0.003),
    ],
)
def test_a_low_bias_leaves_the_other_variant(form, mpa, minus):
    corners = [(0.0, mpa * 1e6, 345.0), (55.0, mpa * 1e6, 290.0)]
    path = follow(table_1(rates=form), AUSTENITE, corners, 0.01)
    assert path.minus[-1] == pytest.approx(minus, abs=1e-3)
    assert path.plus[-1] + path.minus[-1] == pytest.approx(1.0, abs=1e-9)


# ---------------------------------------------------------------- fractions


def fractions_of(path):
    return np.array([path.plus, path.minus, 1 - path.plus - path.minus])


@pytest.mark.parametrize("form", ["barrier", "well", "edge"])
def test_fractions_stay_fractions_under_any_stress(form):
    """Random walks of 600 MPa and 100 K, in steps of any length."""
    rng = np.random.default_rng(5)
    for step in (1.0, 0.05):
        times = np.cumsum([0, *rng.integers(1, 5, 12)])
        walk = rng.uniform(-300e6, 300e6, 13), rng.uniform(285.0, 385.0, 13)
        path = follow(table_1(rates=form), (0.3, 0.2), list(zip(times, *walk, strict=True)), step)
        shares = fractions_of(path)
        assert shares.min() >= -1e-12
        assert np.ptp(shares, axis=1).min() > 0.9


@pytest.mark.parametrize(
    ("T", "form"),
    [
        (300.0, "barrier"),
        (300.0, "edge"),
        (360.0, "well"),
        pytest.param(300.0, "well", marks=pytest.mark.slow),
        pytest.param(360.0, "barrier", marks=pytest.mark.slow),
        pytest.param(360.0, "edge", marks=pytest.mark.slow),
    ],
)
def test_fractions_stay_fractions_under_any_strain(form, T):
    """Tension and compression to 5 % at 1e-3 per second, both variants in turn."""
    corners = [(0.0, 0.004, T), (46.0, 0.05, T), (146.0, -0.05, T)]
    path = follow(table_1(rates=form), (0.3, 0.2), corners, 0.2, "strain")
    assert path.residual < 1e-3  # a rigid machine is the hardest of all couplings
    assert fractions_of(path).min() >= -1e-9
    assert np.ptp(path.plus) > 0.9
    assert np.ptp(path.minus) > 0.9


# ---------------------------------------------------------------- heat


def test_heat_from_the_free_energy():
    """8.0 kJ/kg at T_L by T ε_T s/ρ; the published 25 kJ/kg does not follow from the wells."""
    law, density, T = table_1(heat_model="free-energy"), 6500.0, TABLE_1["T_L"]
    rough = T * TABLE_1["eps_T"] * TABLE_1["dsigma_dT"]
    found = law.heat(floats, density * 25e3, 0.0, T)
    assert rough / density == pytest.approx(8.0e3, rel=0.02)
    assert found == pytest.approx(rough, rel=0.02)
    assert density * 25e3 / found == pytest.approx(3.2, abs=0.1)
    rise = law.depth(floats, T + 0.01) - law.depth(floats, T - 0.01)
    assert found == pytest.approx(-T * rise / 0.02, rel=1e-7)


def test_depth_is_the_difference_of_the_wells():
    law = table_1()
    for T in (330.0, 350.0, 380.0):
        beyond = 0.5 * law.E_M * (0.06 - law.eps_T) ** 2  # on the parabola of M+
        bottom = law.free_energy(floats, 0.06, T) - beyond
        assert law.free_energy(floats, 0.0, T) == 0.0
        assert law.depth(floats, T) == pytest.approx(-bottom, rel=1e-9)


def test_heat_with_the_work_of_the_stress():
    law = table_1(heat_model="stress")
    for stress in (0.0, 50e6, 200e6):
        elastic = 0.5 * stress**2 * (1 / 50e9 - 1 / 30e9)
        found = law.heat(floats, 1.6e8, stress, 350.0)
        assert found == pytest.approx(1.6e8 + elastic + 0.04 * stress)
    assert table_1().heat(floats, 1.6e8, 2e8, 350.0) == 1.6e8


# ---------------------------------------------------------------- what is refused


def test_wells_that_would_touch_are_refused():
    with pytest.raises(ParameterError, match="below half of E_M eps_T = 1200 MPa, but is 650 MPa"):
        table_1(Delta_sigma=650e6)
