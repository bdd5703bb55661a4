"""Liang–Rogers law against closed forms: curves, residual strains, minor loops, history rules.

Strips of problem A at zero stress: reverse 68 to 78 °C, forward 52 to 42 °C; C_A = 10 MPa/K and
C_M = 8 MPa/K. Everything expected here is written out from the published cosines.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from builders import (
    ZERO,
    along,
    chamber,
    fraction_after,
    isobar,
    isotherm,
    law_a,
    problem_a,
    strain_of,
    through,
    wire_a,
)

from martensite.electrical.temperature import PrescribedTemperature
from martensite.laws.liang_rogers import LiangRogers
from martensite.mechanisms.bias_spring import BiasSpring
from martensite.runtimes import floats
from martensite.simulate.api import simulate

CLOSE = pytest.approx
A_S, A_F, M_S, M_F, C_A, C_M, EPS_L = 68.0, 78.0, 52.0, 42.0, 10.0, 8.0, 0.04
BOTH = pytest.mark.parametrize("rule", ["resume", "restart"])


def exact(x):
    return pytest.approx(x, abs=1e-10, rel=0)


def forward(celsius, mpa=0.0, xi=0.0):
    """½ (1 - ξ₀) cos[a_M (T - M_f - σ/C_M)] + ½ (1 + ξ₀), the printed curve."""
    angle = math.pi / (M_S - M_F) * (celsius - M_F - mpa / C_M)
    return 0.5 * (1 - xi) * math.cos(angle) + 0.5 * (1 + xi)


def reverse(celsius, mpa=0.0, xi=1.0):
    """½ ξ₀ {cos[a_A (T - A_s - σ/C_A)] + 1}, the printed curve."""
    return 0.5 * xi * (math.cos(math.pi / (A_F - A_S) * (celsius - A_S - mpa / C_A)) + 1)


# ---------------------------------------------------------------- curves


@BOTH
class TestCurves:
    @pytest.mark.parametrize("xi", [1.0, 0.37])
    @pytest.mark.parametrize("celsius", [68.001, 70.0, 73.0, 77.999])
    def test_heating(self, rule, xi, celsius):
        assert fraction_after(law_a(rule), isobar(20, celsius), xi) == exact(
            reverse(celsius, xi=xi)
        )

    @pytest.mark.parametrize("xi", [0.0, 0.37])
    @pytest.mark.parametrize("celsius", [51.999, 50.0, 47.0, 42.001])
    def test_cooling(self, rule, xi, celsius):
        assert fraction_after(law_a(rule), isobar(100, celsius), xi) == exact(
            forward(celsius, xi=xi)
        )

    @pytest.mark.parametrize("mpa", [50.0, 100.0, 200.0])
    def test_stress_shifts_all_lines(self, rule, mpa):
        """At constant stress by σ/C_M (forward) and σ/C_A (reverse)."""
        for share in (0.0, 0.25, 0.5, 1.0):
            hot = A_S + mpa / C_A + share * (A_F - A_S)
            path = isobar(20, hot, stress=mpa * 1e6)
            assert fraction_after(law_a(rule), path, 1.0) == exact(reverse(hot, mpa))
            cold = M_S + mpa / C_M - share * (M_S - M_F)
            path = isobar(150, cold, stress=mpa * 1e6)
            assert fraction_after(law_a(rule), path, 0.0) == exact(forward(cold, mpa))

    @pytest.mark.parametrize("celsius", [53.0, 60.0, 90.0])
    def test_loading_and_unloading(self, rule, celsius):
        start, finish = C_M * (celsius - M_S), C_M * (celsius - M_F)
        half = 0.5 * (start + finish)
        law = law_a(rule)
        assert fraction_after(law, isotherm(celsius, 0, start), 0.0) == 0.0
        assert fraction_after(law, isotherm(celsius, 0, half), 0.0) == exact(0.5)
        assert fraction_after(law, isotherm(celsius, 0, finish + 1e-6), 0.0) == 1.0
        down = max(0.0, C_A * (celsius - A_F) + 30.0)
        path = isotherm(celsius, 0, finish + 50, down)
        assert fraction_after(law, path, 0.0) == exact(
            reverse(celsius, down) if celsius > A_S else 1.0
        )

    def test_stress_and_temperature_together(self, rule):
        """Only the end coordinate counts on a straight leg through one strip."""
        path = [(20e6, 100 + ZERO), (130e6, 62 + ZERO)]  # cooling and loading: u falls to 45.75
        assert fraction_after(law_a(rule), path, 0.2) == exact(forward(62, 130, 0.2))
        path = [(150e6, 60 + ZERO), (30e6, 75 + ZERO)]  # heating and unloading: w rises to 72
        assert fraction_after(law_a(rule), path, 0.8) == exact(reverse(75, 30, 0.8))

    def test_complete_transformations_are_complete(self, rule):
        assert fraction_after(law_a(rule), isobar(20, 100), 1.0) == 0.0
        assert fraction_after(law_a(rule), isobar(100, 20), 0.0) == 1.0
        assert fraction_after(law_a(rule), isobar(20, 100, 20, 100), 1.0, substeps=100) == 0.0


# ---------------------------------------------------------------- what only u and w decide


@BOTH
class TestDirections:
    def test_heating_with_fast_loading_forms_martensite(self, rule):
        path = [(80e6, 64 + ZERO), (200e6, 68 + ZERO)]  # u from 54 to 43
        assert fraction_after(law_a(rule), path, 0.0) == exact(forward(68, 200))

    def test_cooling_with_fast_unloading_forms_austenite(self, rule):
        path = [(200e6, 85 + ZERO), (50e6, 80 + ZERO)]  # w from 65 to 75
        assert fraction_after(law_a(rule), path, 1.0) == exact(reverse(80, 50))

    @pytest.mark.parametrize("xi", [0.0, 0.4, 1.0])
    def test_neutral_paths_change_nothing(self, rule, xi):
        """Along u = const, w falls on loading; along w = const, u rises on unloading."""
        law = law_a(rule)
        for u in (43.0, 47.0, 51.3):
            path = [(s, u + ZERO + s / 8e6) for s in (50e6, 120e6, 333.3e6)]
            assert fraction_after(law, path, xi, substeps=37) == xi
        for w in (69.0, 73.0, 77.7):
            path = [(s, w + ZERO + s / 10e6) for s in (333.3e6, 120e6, 50e6)]
            assert fraction_after(law, path, xi, substeps=37) == xi

    def test_outside_the_strips_nothing_happens(self, rule):
        path = isobar(53, 67, 53.5, 66, 52, 68)
        assert fraction_after(law_a(rule), path, 0.4, substeps=10) == 0.4
        path = isobar(20, 41, -10, 41.9)
        assert fraction_after(law_a(rule), path, 0.4, substeps=10) == 0.4  # kept as given

    def test_wrong_way_inside_a_strip_changes_nothing(self, rule):
        assert fraction_after(law_a(rule), isobar(47, 60), 0.4) == 0.4
        assert fraction_after(law_a(rule), isobar(73, 60), 0.4) == 0.4

    def test_order_of_heating_and_loading_matters(self, rule):
        start, end = (0.0, 60 + ZERO), (60e6, 76 + ZERO)
        law = law_a(rule)
        heated_first = fraction_after(law, [start, (0.0, end[1]), end], 1.0)
        loaded_first = fraction_after(law, [start, (end[0], start[1]), end], 1.0)
        assert heated_first == exact(reverse(76))
        assert loaded_first == exact(reverse(76, 60))
        assert loaded_first - heated_first > 0.5


# ---------------------------------------------------------------- lines, 0/0 points


@BOTH
@pytest.mark.parametrize("mpa", [0.0, 37.0])
class TestStartsOnALine:
    def path(self, line, C, mpa, change):
        start = line + mpa / C
        return isobar(start, start + change, stress=mpa * 1e6)

    @pytest.mark.parametrize("xi", [0.0, 0.4, 1.0])
    def test_reverse_start_line(self, rule, mpa, xi):
        law = law_a(rule)
        up = fraction_after(law, self.path(A_S, C_A, mpa, 4.0), xi)
        assert up == exact(reverse(A_S + 4.0, xi=xi))
        assert fraction_after(law, self.path(A_S, C_A, mpa, -4.0), xi) == xi

    @pytest.mark.parametrize("xi", [0.0, 0.4, 1.0])
    def test_forward_start_line(self, rule, mpa, xi):
        law = law_a(rule)
        down = fraction_after(law, self.path(M_S, C_M, mpa, -4.0), xi)
        assert down == exact(forward(M_S - 4.0, xi=xi))
        assert fraction_after(law, self.path(M_S, C_M, mpa, 4.0), xi) == xi

    @pytest.mark.parametrize("xi", [0.0, 0.4, 1.0])
    @pytest.mark.parametrize("change", [5.0, -5.0, 1e-12, -1e-12, 0.0])
    def test_finish_lines(self, rule, mpa, xi, change):
        """0/0: nothing is left of the strip, whatever is left to transform stays."""
        law = law_a(rule)
        assert fraction_after(law, self.path(A_F, C_A, mpa, change), xi) == xi
        assert fraction_after(law, self.path(M_F, C_M, mpa, change), xi) == xi


@BOTH
def test_nothing_left_to_transform_leaves_the_branch_alone(rule):
    memory = along(law_a(rule), isobar(50, 75, 90), 0.0)[-1]
    assert (memory.fraction, memory.branch) == (0.0, 0.0)
    memory = along(law_a(rule), isobar(75, 45, 20), 1.0)[-1]
    assert (memory.fraction, memory.branch) == (1.0, 0.0)


# ---------------------------------------------------------------- residual strains


@BOTH
@pytest.mark.parametrize("modulus", ["austenite", "martensite", "mixture"])
class TestResidualStrains:
    """Loading from unloaded austenite and back, strain less that of austenite there."""

    def residual(self, rule, modulus, celsius, top, xi=0.0):
        law = law_a(rule, modulus, Theta=0.0)
        memories = along(law, isotherm(celsius, 0, top, 0), xi, substeps=20)
        return strain_of(law, memories[-1]) - strain_of(law, memories[0])

    @pytest.mark.parametrize("celsius", [78.5, 90.0, 110.0])
    def test_above_A_f_loops_close(self, rule, modulus, celsius):
        for top in (C_M * (celsius - M_S) + 30, C_M * (celsius - M_F) + 100):
            assert self.residual(rule, modulus, celsius, top) == 0.0

    @pytest.mark.parametrize("celsius", [69.0, 73.0, 77.0])
    def test_between_A_s_and_A_f_a_part_remains(self, rule, modulus, celsius):
        left = 0.5 * EPS_L * (1 + math.cos(math.pi / (A_F - A_S) * (celsius - A_S)))
        assert self.residual(rule, modulus, celsius, 400.0) == exact(left)

    @pytest.mark.parametrize("celsius", [52.5, 60.0, 67.5])
    def test_between_M_s_and_A_s_all_remains(self, rule, modulus, celsius):
        assert self.residual(rule, modulus, celsius, 400.0) == exact(EPS_L)

    def test_cold_martensite_is_elastic(self, rule, modulus):
        """Below M_f one fraction cannot detwin: no residual, and the slope of E."""
        law = law_a(rule, modulus)
        assert self.residual(rule, modulus, 20.0, 400.0, xi=1.0) == 0.0
        a, b = along(law, isotherm(20.0, 0, 100), 1.0)
        E = law.E_A if modulus == "austenite" else law.E_M
        assert strain_of(law, b) - strain_of(law, a) == CLOSE(100e6 / E, rel=1e-12, abs=0)

    def test_stress_free_cooling_strains(self, rule, modulus):
        law = law_a(rule, modulus, Theta=0.0)
        for celsius in (60.0, 50.0, 47.0, 30.0):
            memory = along(law, isobar(100, celsius), 0.0)[-1]
            xi = 0.0 if celsius > M_S else 1.0 if celsius < M_F else forward(celsius)
            assert strain_of(law, memory) == exact(EPS_L * xi)

    def test_shape_memory_cycle_keeps_the_strain_of_all_martensite(self, rule, modulus):
        """Load and unload cold, heat, cool: one fraction comes back to ε_L, not to zero."""
        law = law_a(rule, modulus, Theta=0.0)
        path = [*isotherm(20, 0, 300, 0), *isobar(100, 20)]
        start, _, unloaded, hot, cold = (strain_of(law, m) for m in along(law, path, 1.0))
        assert (start, unloaded, cold) == (exact(EPS_L),) * 3
        assert hot == 0.0


@pytest.mark.parametrize("Theta", [0.055e6, -0.74e6])
def test_sign_of_the_thermal_strain(Theta):
    """A free bar expands on heating if and only if Θ < 0; and the law cautions against Θ > 0."""
    law = law_a(Theta=Theta, modulus="austenite")
    a, b = along(law, isobar(20, 60), 0.0)
    assert strain_of(law, b) - strain_of(law, a) == CLOSE(-Theta * 40.0 / law.E_A, rel=1e-10, abs=0)
    assert any("Theta" in sentence for sentence in law.cautions()) == (Theta > 0)


# ---------------------------------------------------------------- loop work


@BOTH
@pytest.mark.parametrize("celsius", [80.0, 95.0, 120.0])
@pytest.mark.parametrize("modulus", ["austenite", "mixture"])
def test_work_of_a_full_isothermal_loop(rule, celsius, modulus):
    """W = ε_L {C_M [T - ½(M_s + M_f)] - C_A [T - ½(A_s + A_f)]} + ½ ∮ σ² d(1/E)."""
    law = law_a(rule, modulus)
    top = C_M * (celsius - M_F) + 20.0
    stresses = np.concatenate([np.linspace(0, top, 4001), np.linspace(top, 0, 4001)[1:]])
    memories = along(law, isotherm(celsius, *stresses.tolist()), 0.0)
    strains = np.array([strain_of(law, m) for m in memories])
    flexibility = np.array([law.compliance(floats, law.fractions(m)) for m in memories])
    mean = 0.5e6 * (stresses[1:] + stresses[:-1])
    work = float(np.sum(mean * np.diff(strains)))
    elastic = 0.5 * float(np.sum(mean**2 * np.diff(flexibility)))
    steps = C_M * (celsius - 0.5 * (M_S + M_F)) - C_A * (celsius - 0.5 * (A_S + A_F))
    thermal = law.Theta * (celsius + ZERO - law.T_ref)  # shifts the stress that meets 1/E
    shift = thermal * float(np.sum(mean * np.diff(flexibility)))
    assert work == CLOSE(EPS_L * steps * 1e6 + elastic - shift, rel=1e-5)


# ---------------------------------------------------------------- history


def hot(celsius):
    return math.cos(0.5 * math.pi * (celsius - A_S) / (A_F - A_S)) ** 2


def cold(celsius):
    return math.sin(0.5 * math.pi * (celsius - M_F) / (M_S - M_F)) ** 2


class TestInterruptedTransformations:
    """ξ at the last point, zero stress; the numbers were computed for this project."""

    CASES = pytest.mark.parametrize(
        ("path", "xi", "rule", "printed", "closed"),
        [
            ((20, 73, 71, 74), 1.0, "resume", 0.3455, hot(74)),
            ((20, 73, 71, 74), 1.0, "restart", 0.2176, hot(73) * hot(74) / hot(71)),
            ((100, 46, 49, 45), 0.0, "resume", 0.7939, 1 - cold(45)),
            ((100, 46, 49, 45), 0.0, "restart", 0.9103, 1 - cold(46) * cold(45) / cold(49)),
            ((100, 46, 60, 44), 0.0, "resume", 0.9045, 1 - cold(44)),
            ((100, 46, 60, 44), 0.0, "restart", 0.9670, 1 - cold(46) * cold(44)),
        ],
    )

    @CASES
    @pytest.mark.parametrize("substeps", [1, 30])
    def test_table(self, path, xi, rule, printed, closed, substeps):
        found = fraction_after(law_a(rule), isobar(*path), xi, substeps)
        assert found == exact(closed)
        assert round(found, 4) == printed

    @pytest.mark.parametrize(
        ("high", "low", "resume", "restart"), [(74, 72, 0.3455, 0.0), (73.2, 72.8, 0.4686, 0.0010)]
    )
    def test_fifty_small_cycles(self, high, low, resume, restart):
        path = isobar(20, high, *[low, high] * 49)  # heated to `high` fifty times
        stays = fraction_after(law_a("resume"), path, 1.0)
        ratchets = fraction_after(law_a("restart"), path, 1.0)
        assert (round(stays, 4), round(ratchets, 4)) == (resume, restart)
        assert stays == exact(hot(high))
        assert ratchets == exact(hot(high) * (hot(high) / hot(low)) ** 49)

    @pytest.mark.parametrize("rule", ["resume", "restart"])
    def test_no_jumps(self, rule):
        """ξ is continuous: no step of 0.1 K moves it further than the steepest curve does."""
        path = isobar(20, 73, 71, 74, 45.5, 48, 44, 75)
        law, fractions = law_a(rule), [1.0]
        memory = law.init(floats, 1.0, *path[0])
        for (_, a), (_, b) in pairwise(path):
            for temperature in np.linspace(a, b, round(10 * abs(b - a)) + 1).tolist()[1:]:
                memory, now = law.kinetics(floats, memory, 0.0, temperature, 0.0)
                fractions.append(now.martensite)
        assert np.abs(np.diff(fractions)).max() == CLOSE(0.016, abs=5e-4)

    @pytest.mark.parametrize("rule", ["resume", "restart"])
    def test_memory_has_one_level(self, rule):
        """Inner loops 74 ↔ 47 °C do not close: each reversal anchors at the fraction it finds."""
        path = isobar(20, *[74, 47] * 4)
        found = [m.fraction for m in along(law_a(rule), path, 1.0)][1::2]
        assert found == CLOSE([0.346, 0.232, 0.213, 0.210], abs=6e-4)
        xi, expected = 1.0, []
        for _ in range(4):
            expected.append(hot(74) * xi)
            xi = 1 - cold(47) * (1 - expected[-1])
        assert found == [exact(x) for x in expected]

    def test_pauses_do_not_matter_to_resume(self):
        """Leaving the strip, unloading, partial cooling: then on along the same curve."""
        detour = [(0, 72), (0, 60), (40, 70), (0, 55), (0, 71), (0, 75)]
        path = [(0.0, 20 + ZERO), *((s * 1e6, t + ZERO) for s, t in detour)]
        assert fraction_after(law_a("resume"), path, 1.0) == exact(hot(75))

    def test_an_opposite_transformation_clears_the_memory(self):
        """A trace of martensite formed in between, and heating starts a new curve at A_s."""
        path = isobar(20, 73, 50, 70)
        between = 1 - cold(50) * (1 - hot(73))
        assert fraction_after(law_a("resume"), path, 1.0) == exact(between * hot(70))
        assert fraction_after(law_a("resume"), isobar(20, 73, 53, 70), 1.0) == exact(hot(73))


# ---------------------------------------------------------------- in a system


def test_restrained_heating_never_outruns_the_strip():
    """Held by an all but rigid spring: while it transforms, σ rises slower than C_A."""
    system = problem_a(
        element=wire_a(law_a(Theta=0.0)),
        source=PrescribedTemperature(),
        mechanism=BiasSpring(stiffness=1e8, preload=5.0),
    )
    run = simulate(system, through([20 + ZERO, 150 + ZERO], 100.0), 100.0, step=0.05)
    xi, stress, T = (np.array(run[n]) for n in ("martensite_fraction", "stress", "temperature"))
    moving = np.diff(xi) < -1e-9
    slopes = np.diff(stress)[moving] / np.diff(T)[moving]
    assert moving.sum() > 100
    assert (slopes > 0.0).all()
    assert (slopes < 10e6).all()


@BOTH
def test_a_chamber_run_is_the_bare_law(rule):
    """Prescribed temperature under a dead weight: ξ of the system = ξ of the law, to round-off."""
    law = law_a(rule)
    celsius = [20.0, 84.0, 60.0, 51.0, 88.0]
    run = simulate(
        chamber(law, mass=1.0), through([t + ZERO for t in celsius]), 4.0, step=0.01, samples=5
    )
    stress = run["stress"][0]
    expected = [m.fraction for m in along(law, isobar(*celsius, stress=stress), 1.0)]
    assert run["martensite_fraction"] == CLOSE(expected, abs=1e-6)
    assert len({round(x, 3) for x in expected}) > 3


# ---------------------------------------------------------------- the check can fail


class Printed(LiangRogers):
    """The most likely mistake: the printed formula with ξ₀ refreshed at every increment."""

    def select(self, xp, memory, stress, temperature):
        move = super().select(xp, memory, stress, temperature)
        left = xp.where(move.direction > 0.0, 1.0 - memory.fraction, memory.fraction)
        return move._replace(scale=left)


def test_the_printed_formula_with_refreshed_start_is_noticed():
    law = Printed(**{n: getattr(law_a("restart"), n) for n in LiangRogers.declarations})
    assert fraction_after(law, isobar(20, 73), 1.0) == exact(hot(73))
    assert abs(fraction_after(law, isobar(20, 73), 1.0, substeps=50) - hot(73)) > 0.1
    assert abs(fraction_after(law, isobar(20, 73, 71, 74), 1.0) - hot(74)) > 0.1
