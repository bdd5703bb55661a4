"""Hybrid single crystal against the rate law and closed forms; loops, cold start, step size.

Bare material with the numbers of Table 1 (`mas_paths`); wire on a spring as in problem B.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from benchmarks.problem_b import Wire, system, waveform
from mas_paths import TABLE_1, follow, table_1, there_and_back

from martensite.kernels import floats
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.mas_hybrid import MullerAchenbachSeeleckeHybrid as Hybrid
from martensite.simulate.api import simulate

AUSTENITE, TWINNED, ORIENTED = (0.0, 0.0), (0.5, 0.5), (1.0, 0.0)
RAMP = 1e5
TRANSIT = 0.04 / 1e-3
"""Time [s] in which a strain rate of 1e-3 per second uses up ε_T."""
NO_ACTIVATION = TABLE_1["layer_time"]
ROUNDING = 1e-11


def hybrid(**changes):
    return table_1(Hybrid, **changes)


def stretched(law, T, start=AUSTENITE, rate=1e-3):
    """To 5 % strain and back; steps of 0.01 % strain."""
    path = follow(law, start, there_and_back(0.05, rate, T), 1e-4 / rate, "strain")
    assert path.residual < 1e-10
    return path


def plateaus(path, strain=0.02):
    """Stress [MPa] at a strain on loading and on unloading."""
    n = len(path.time) // 2 + 1
    up = np.interp(strain, path.strain[:n], path.stress[:n])
    return up / 1e6, np.interp(-strain, -path.strain[n:], path.stress[n:]) / 1e6


def inside(transit_time, modulus):
    """Distance [Pa] of a plateau from its threshold, from the formula on paper."""
    p = TABLE_1
    sigma_M = p["sigma_L"] - p["Delta_sigma"]
    per_bridge = (p["eps_T"] + sigma_M / p["E_M"] - p["sigma_L"] / p["E_A"]) / p["Delta_sigma"]
    energies = p["layer_volume"] / (1.380649e-23 * p["T_L"])
    slow = np.log(transit_time / p["layer_time"])
    return float(np.sqrt(slow / (0.5 * energies * (1 / modulus + per_bridge))))


# ---------------------------------------------------------------- the rate law


@cache
def wire(law, step, volume=1.0, **options):
    """The cycle of problem B; layers `volume` times larger and as much faster."""
    numbers = Wire(layer_volume=5e-23 * volume, layer_time=5e-3 / volume)
    run = simulate(system(numbers, law, **options), waveform(), 20.0, step=step, samples=201)
    assert not run.status.failed
    names = ("stress", "strain", "temperature", "martensite_fraction")
    return {name: np.array(run[name]) for name in names}


def apart(a, b, name):
    """Largest difference of a column over the whole cycle."""
    return float(np.abs(a[name] - b[name]).max())


def test_the_rate_law_on_a_spring():
    found, exact = wire("mas-hybrid", 0.02), wire("mas", 0.005, rates="barrier")
    assert np.ptp(exact["stress"]) > 100e6
    assert apart(found, exact, "stress") < 0.25e6
    assert apart(found, exact, "strain") < 1e-4
    assert apart(found, exact, "temperature") < 0.1


@pytest.mark.parametrize("seconds", [pytest.param(1.0, marks=pytest.mark.slow), 1e-9])
def test_the_rate_law_tends_to_it_with_ever_larger_layers(seconds):
    """Four times the volume halves the thermal width; with or without activation."""
    options = {"ramp": 1e4, "transit_time": seconds}
    gaps = [
        apart(wire("mas-hybrid", 0.01, size, **options), wire("mas", 0.01, size, rates="barrier"), "stress")
        for size in (1.0, 4.0, 16.0, 64.0)
    ]
    assert all(larger > 1.6 * smaller for larger, smaller in pairwise(gaps))
    assert gaps[-1] < (0.02e6 if seconds == 1.0 else 0.2e6)


@pytest.mark.parametrize(
    ("T", "rate"),
    [
        pytest.param(T, rate, marks=[] if (T, rate) in ((340.0, 1e-3), (370.0, 1e-1)) else [pytest.mark.slow])
        for T in (340.0, 355.0, 370.0)
        for rate in (1e-4, 1e-3, 1e-2, 1e-1)
    ],
)
def test_plateaus_of_the_rate_law(T, rate):
    """With the time in which ε_T is used up as the transit time."""
    found = plateaus(stretched(hybrid(transit_time=0.04 / rate), T, rate=rate))
    assert found == pytest.approx(plateaus(stretched(table_1(), T, rate=rate)), abs=0.1)


# ---------------------------------------------------------------- thresholds


@pytest.mark.parametrize("seconds", [NO_ACTIVATION, 1e-9])
def test_plateaus_without_activation_are_nominal(seconds):
    path = stretched(hybrid(transit_time=seconds), 355.0)
    n = len(path.time) // 2
    up, down = slice(60, n - 100), slice(n + 100, 2 * n - 60)
    ramp = RAMP * (path.plus - 0.5)
    assert path.stress[up] == pytest.approx(141e6 + ramp[up], abs=1e-3)
    assert path.stress[down] == pytest.approx(89e6 + ramp[down], abs=1e-3)


@pytest.mark.parametrize("seconds", [0.1, 1.0, 10.0, 100.0])
def test_activation_is_the_formula_on_paper(seconds):
    up, down = plateaus(stretched(hybrid(transit_time=seconds), 355.0))
    assert up == pytest.approx(141 - inside(seconds, 50e9) / 1e6, abs=0.01)
    assert down == pytest.approx(89 + inside(seconds, 30e9) / 1e6, abs=0.01)


# ---------------------------------------------------------------- minor loops

PARTIAL = [(0.0, 0.0, 355.0), (20.0, 0.02, 355.0)]


def looped(law, count, rate=1e-3):
    """Stretched to 2 % strain, then `count` times to 1.2 % and back, and at last to 3 %."""
    corners = [*PARTIAL]
    for _ in range(count):
        last = corners[-1][0]
        corners += [(last + 8e-3 / rate, 0.012, 355.0), (last + 16e-3 / rate, 0.02, 355.0)]
    corners.append((corners[-1][0] + 0.01 / rate, 0.03, 355.0))
    path = follow(law, AUSTENITE, corners, 1e-4 / rate, "strain")
    at = [int(np.argmin(np.abs(path.time - c[0]))) for c in corners]
    return path, at


@pytest.mark.parametrize("count", [1, 2, 10])
def test_minor_loops_close(count):
    """Unloading within the loop: the same state at the return point, and the same way on."""
    path, at = looped(hybrid(), count)
    tops, bottoms = at[1:-1:2], at[2:-1:2]
    assert path.stress[tops[0]] - path.stress[bottoms[0]] > 40e6
    assert path.plus[tops[0]] - path.plus[bottoms[0]] > 0.1
    for column in (path.plus, path.minus, path.stress / 1e8):
        assert np.ptp(column[tops]) < ROUNDING
        assert np.ptp(column[bottoms]) < ROUNDING
    direct, _ = looped(hybrid(), 0)
    assert path.stress[-60:] == pytest.approx(direct.stress[-60:], rel=ROUNDING)


def returned(law, memory, corners, cuts):
    """Memories at the corners of a way of (stress, temperature)."""
    memories = [memory]
    for (s0, t0), (s1, t1) in pairwise([(memory.stress, memory.temperature), *corners]):
        for k in range(1, cuts + 1):
            share = k / cuts
            s, t = (s1, t1) if k == cuts else (s0 + share * (s1 - s0), t0 + share * (t1 - t0))
            memory, _ = law.kinetics(floats, memory, s, t, 0.1)
        memories.append(memory)
    return memories


@pytest.mark.parametrize("cuts", [1, 7])
def test_nothing_moves_between_the_thresholds(cuts):
    """Cycles of stress and temperature that reach neither: exactly the same state."""
    law = hybrid()
    start = law.init(floats, Fractions(0.4, 0.4), 115e6, 355.0)
    corners = [(135e6, 355.0), (95e6, 355.0), (115e6, 349.5), (115e6, 360.5), (115e6, 355.0)]
    memories = returned(law, start, corners * 10, cuts)
    assert {m.present for m in memories} == {start.present}


@pytest.mark.parametrize("cuts", [1, 7])
def test_return_points_under_stress(cuts):
    """Partly through a plateau by stress and by temperature: loops in a loop, all closed."""
    law = hybrid(transit_time=NO_ACTIVATION, ramp=10e6)
    start = law.init(floats, Fractions(0.0, 0.0), 100e6, 355.0)
    high, low, inner = (143e6, 355.0), (92e6, 355.0), (141e6, 355.0)
    by_heat = (inner[0], 355.0 + (inner[0] - 92e6) / 4e6)
    memories = returned(law, start, [high, low, inner, low, inner, by_heat, inner, high, low], cuts)
    formed = [m.present.plus for m in memories]
    assert formed[1] == pytest.approx(0.7)  # ½ + (143 - 141)/10
    assert formed[2] == pytest.approx(0.7)  # 92 MPa would leave 0.8
    deeper = [(87e6, 355.0), high, (87e6, 355.0), high]
    deep = [m.present.plus for m in returned(law, memories[-1], deeper, cuts)]
    assert deep[1:] == pytest.approx([0.3, 0.7, 0.3, 0.7])
    assert formed[3:] == pytest.approx([0.7] * 7)


# ---------------------------------------------------------------- low bias and quasi-plasticity


def cooled(stress, step=0.1):
    path = follow(hybrid(), AUSTENITE, [(0.0, stress, 345.0), (55.0, stress, 290.0)], step)
    return path.plus[-1], path.minus[-1]


@pytest.mark.parametrize("step", [55.0, 10.0, 0.1])
@pytest.mark.parametrize(("stress", "plus"), [(0.0, 0.5), (2e4, 0.7), (-2e4, 0.3), (5e4, 1.0), (1e6, 1.0), (-5e4, 0.0)])
def test_what_forms_in_the_cold(stress, plus, step):
    """Half and half without stress, one variant from half a ramp of stress on."""
    assert cooled(stress, step) == pytest.approx((plus, 1.0 - plus), abs=1e-9)


@pytest.mark.parametrize("T", [295.0, 310.0])
def test_twinned_martensite_is_stretched(T):
    """M- to M+ where |σ| = Δσ less the activation; the strain stays."""
    path = stretched(hybrid(transit_time=TRANSIT), T, TWINNED)
    up, _ = plateaus(path)
    assert up == pytest.approx(52 - inside(TRANSIT, 30e9) / 1e6, abs=0.05)
    assert up == pytest.approx(plateaus(stretched(table_1(), T, TWINNED))[0], abs=0.1)
    assert path.plus.max() == pytest.approx(1.0, abs=1e-12)
    n = len(path.time) // 2
    unloaded = np.interp(0.0, -path.stress[n:], path.strain[n:])
    assert unloaded == pytest.approx(0.04, abs=1e-6)


def test_stretched_martensite_recovers_by_heat():
    law = hybrid()
    path = follow(law, ORIENTED, [(0.0, 1e6, 295.0), (100.0, 1e6, 395.0)], 0.1)
    rest = 319.75 + (1 + 52 - inside(1.0, 30e9) / 1e6) / 4
    half = path.temperature[int(np.argmax(path.plus < 0.5))]
    assert half == pytest.approx(rest, abs=0.1)
    assert path.strain[-1] == pytest.approx(1e6 / 50e9, abs=1e-12)


# ---------------------------------------------------------------- independent of the step


@pytest.mark.parametrize("control", ["stress", "strain"])
def test_the_bare_law_does_not_depend_on_the_cuts(control):
    reach = {"stress": 200e6, "strain": 0.035}[control]
    corners = [(0.0, 0.0, 350.0), (10.0, reach, 360.0), (20.0, 0.3 * reach, 340.0)]
    steps = {"stress": (10.0, 1.0, 0.05), "strain": (1.0, 0.25, 0.05)}[control]
    ends = [follow(hybrid(), AUSTENITE, corners, step, control) for step in steps]
    for path in ends:
        assert path.residual < 1e-10
        assert path.plus[-1] == pytest.approx(ends[0].plus[-1], abs=ROUNDING)
        assert path.stress[-1] == pytest.approx(ends[0].stress[-1], abs=1.0)


def test_a_coarse_step_is_second_to_the_rate_law():
    """Steps of 0.1 s are off by less than a fifth of what the two laws are apart."""
    step = apart(wire("mas-hybrid", 0.1), wire("mas-hybrid", 0.1 / 64), "stress")
    law = apart(wire("mas-hybrid", 0.1 / 64), wire("mas", 0.005, rates="barrier"), "stress")
    assert step < 0.2 * law
