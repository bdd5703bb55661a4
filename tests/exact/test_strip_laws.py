"""What every law with one fraction and two strips must show: curves, directions, history, checks.

Liang–Rogers, Elahinia and Tanaka differ in what a process leaves and in Young's modulus only.
"""

import numpy as np
import pytest
from builders import ZERO, along, fraction_after, isobar, isotherm, problem_a, strain_of, through, wire_a
from closed_forms import A_F, A_S, BOTH_RULES, C_A, C_M, M_F, M_S, exact
from grids import over
from strip_cases import CASES, EVERY, KINETICS, NUMBERS, exponential

from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.base.errors import ParameterError
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.physics.laws.strip_laws import Elahinia, LiangRogers, Tanaka
from martensite.simulate.api import simulate

# ---------------------------------------------------------------- curves


@BOTH_RULES
@KINETICS
class TestCurves:
    @over("mpa", [0.0, 100.0, 200.0])
    @over("share", [0.0, 1e-9, 0.3, 1.0, 1.4])
    @over("xi", [0.0, 0.37, 1.0])
    def test_stress_shifts_all_lines(self, case, rule, mpa, share, xi):
        """At constant stress by σ/C_M (forward) and σ/C_A (reverse)."""
        hot = A_S + mpa / C_A + share * (A_F - A_S)
        path = isobar(20, hot, stress=mpa * 1e6)
        assert fraction_after(case.law(rule), path, xi) == exact(xi * case.left(share))
        cold = M_S + mpa / C_M - share * (M_S - M_F)
        path = isobar(150, cold, stress=mpa * 1e6)
        wanted = 1.0 - (1.0 - xi) * case.left(share)
        assert fraction_after(case.law(rule), path, xi) == exact(wanted)

    @over("celsius", [53.0, 60.0, 90.0])
    def test_loading_and_unloading(self, case, rule, celsius):
        law, top = case.law(rule), C_M * (celsius - M_S) + 50.0
        formed = 1.0 - case.cold(celsius, top)
        assert fraction_after(law, isotherm(celsius, 0, top), 0.0) == exact(formed)
        found = fraction_after(law, isotherm(celsius, 0, top, 0.0), 0.0)
        assert found == exact(formed * case.hot(celsius))

    @over("xi", [0.0, 0.4, 1.0])
    @over("line", [A_S, A_F, M_S, M_F])
    @over("mpa", [0.0, 37.0])
    @over("change", [5.0, -5.0, 1e-12, -1e-12, 0.0])
    def test_starts_on_a_line(self, case, rule, xi, line, mpa, change):
        """No 0/0: a process that goes on beyond its finish line does so from where it is."""
        start = line + mpa / (C_A if line in (A_S, A_F) else C_M)
        found = fraction_after(case.law(rule), isobar(start, start + change, stress=mpa * 1e6), xi)
        share, on = abs(change) / 10.0, case.left is exponential
        forward = change < 0 and (line == M_S or (line == M_F and on))
        reverse = change > 0 and (line == A_S or (line == A_F and on))
        wanted = 1.0 - (1.0 - xi) * case.left(share) if forward else xi
        assert found == exact(xi * case.left(share) if reverse else wanted)


@BOTH_RULES
class TestTail:
    """Tanaka's exponential never completes."""

    def test_99_percent_at_the_finish_lines(self, rule):
        law = CASES["tanaka austenite"].law(rule)
        assert fraction_after(law, isobar(100, M_F), 0.0) == pytest.approx(0.99, abs=1e-15)
        assert fraction_after(law, isobar(20, A_F), 1.0) == pytest.approx(0.01, abs=1e-15)

    @over("substeps", [1, 40])
    def test_every_five_kelvin_leave_a_tenth(self, rule, substeps):
        law, path = CASES["tanaka austenite"].law(rule), isobar(20, *range(68, 200, 5))
        found = [m.fraction for m in along(law, path, 1.0, substeps)][1:]
        assert found == pytest.approx([10.0**-k for k in range(len(found))], rel=1e-10, abs=0)

    def test_starts_in_the_tail(self, rule):
        assert fraction_after(CASES["tanaka austenite"].law(rule), isobar(900, 905), 0.6) == exact(0.06)

    def test_nothing_is_left_after_thousands_of_kelvin(self, rule):
        law = CASES["tanaka austenite"].law(rule)
        assert fraction_after(law, isobar(20, 5e3, 1e5, -270, 1e5), 1.0) == 0.0


# ---------------------------------------------------------------- what only u and w decide


@BOTH_RULES
@KINETICS
class TestDirections:
    def test_heating_with_fast_loading_forms_martensite(self, case, rule):
        path = [(80e6, 64 + ZERO), (200e6, 68 + ZERO)]  # u from 54 to 43
        assert fraction_after(case.law(rule), path, 0.0) == exact(1.0 - case.cold(68, 200))

    def test_cooling_with_fast_unloading_forms_austenite(self, case, rule):
        path = [(200e6, 85 + ZERO), (50e6, 80 + ZERO)]  # w from 65 to 75
        assert fraction_after(case.law(rule), path, 1.0) == exact(case.hot(80, 50))

    @over("xi", [0.0, 0.4, 1.0])
    def test_neutral_paths_change_nothing(self, case, rule, xi):
        """Along u = const, w falls on loading; along w = const, u rises on unloading."""
        for u in (20.0, 43.0, 51.3):
            path = [(s, u + ZERO + s / 8e6) for s in (50e6, 120e6, 333.3e6)]
            assert fraction_after(case.law(rule), path, xi, substeps=37) == xi
        for w in (69.0, 77.7, 120.0):
            path = [(s, w + ZERO + s / 10e6) for s in (333.3e6, 120e6, 50e6)]
            assert fraction_after(case.law(rule), path, xi, substeps=37) == xi

    def test_order_of_heating_and_loading_matters(self, case, rule):
        start, end = (0.0, 60 + ZERO), (60e6, 76 + ZERO)
        heated_first = fraction_after(case.law(rule), [start, (0.0, end[1]), end], 1.0)
        loaded_first = fraction_after(case.law(rule), [start, (end[0], start[1]), end], 1.0)
        assert heated_first == exact(case.hot(76))
        assert loaded_first == exact(case.hot(76, 60))
        assert loaded_first - heated_first > 0.3


@KINETICS
def test_restrained_heating_never_outruns_the_strip(case):
    """Held by an all but rigid spring: while it transforms, σ rises slower than C_A."""
    system = problem_a(
        element=wire_a(case.law()), source=PrescribedTemperature(), mechanism=BiasSpring(stiffness=1e8, preload=5.0)
    )
    run = simulate(system, through([20 + ZERO, 150 + ZERO], 100.0), 100.0, step=0.05)
    xi, stress, T = (np.array(run[n]) for n in ("martensite_fraction", "stress", "temperature"))
    moving = np.diff(xi) < -1e-9
    slopes = np.diff(stress)[moving] / np.diff(T)[moving]
    assert moving.sum() > 100
    assert (slopes > 0.0).all()
    assert (slopes < 10e6).all()


# ---------------------------------------------------------------- history


@KINETICS
class TestHistory:
    @over("substeps", [1, 30])
    def test_interrupted_heating(self, case, substeps):
        """20 → 73 → 71 → 74 °C: waits until 73 °C is passed, or starts again at 71 °C."""
        path, hot = isobar(20, 73, 71, 74), case.hot
        assert fraction_after(case.law("resume"), path, 1.0, substeps) == exact(hot(74))
        again = hot(73) * hot(74) / hot(71)
        assert fraction_after(case.law("restart"), path, 1.0, substeps) == exact(again)

    @over("substeps", [1, 30])
    def test_interrupted_cooling(self, case, substeps):
        path, cold = isobar(100, 46, 49, 45), case.cold
        assert fraction_after(case.law("resume"), path, 0.0, substeps) == exact(1 - cold(45))
        again = 1 - cold(46) * cold(45) / cold(49)
        assert fraction_after(case.law("restart"), path, 0.0, substeps) == exact(again)

    def test_fifty_small_cycles(self, case):
        """Restart ratchets, resume stays."""
        path = isobar(20, 74, *[72, 74] * 49)
        assert fraction_after(case.law("resume"), path, 1.0) == exact(case.hot(74))
        ratchets = case.hot(74) * (case.hot(74) / case.hot(72)) ** 49
        assert fraction_after(case.law("restart"), path, 1.0) == exact(ratchets)
        assert ratchets < 1e-3 < case.hot(74)

    def test_pauses_do_not_matter_to_resume(self, case):
        """Leaving the strip, unloading, partial cooling: then on along the same curve."""
        detour = [(0, 72), (0, 60), (40, 70), (0, 55), (0, 71), (0, 75)]
        path = [(0.0, 20 + ZERO), *((s * 1e6, t + ZERO) for s, t in detour)]
        assert fraction_after(case.law("resume"), path, 1.0) == exact(case.hot(75))

    def test_the_memory_is_cleared_by_an_opposite_transformation_only(self, case):
        law, (hot, cold) = case.law("resume"), (case.hot, case.cold)
        between = 1 - cold(50) * (1 - hot(73))
        found = fraction_after(law, isobar(20, 73, 50, 70), 1.0)
        assert found == exact(between * hot(70))
        for turn in (53.0, M_S):  # not below M_s, not even when rounding puts 52 °C there
            assert fraction_after(law, isobar(20, 73, turn, 70), 1.0) == exact(hot(73))

    @BOTH_RULES
    def test_substeps_do_not_matter(self, case, rule):
        points = [(0, 20), (150, 89), (20, 71), (300, 84), (90, 58), (0, 72), (50, 54), (0, 74)]
        path = [(s * 1e6, t + ZERO) for s, t in points]
        whole, cut = (along(case.law(rule), path, 0.7, n) for n in (1, 97))
        assert [m.fraction for m in cut] == pytest.approx([m.fraction for m in whole], abs=1e-12)
        assert len({round(m.fraction, 3) for m in whole}) > 4


# ---------------------------------------------------------------- laws compared, values checked


@BOTH_RULES
@over("mpa", [0.0, 80.0, 172.0])
def test_elahinia_is_liang_rogers_at_constant_stress(rule, mpa):
    """Fractions equal exactly; strains with the mixture modulus only."""
    shifts = mpa / C_A, mpa / C_M
    turns = [20, *(t + shifts[k % 2] for k, t in enumerate((74, 46, 71, 49, 73, 48)))]
    path = isobar(*turns, stress=mpa * 1e6)
    enhanced = along(CASES["elahinia"].law(rule), path, 1.0, 7)
    for modulus in ("austenite", "mixture"):
        case = CASES[f"liang-rogers {modulus}"]
        usual = along(case.law(rule), path, 1.0, 7)
        assert usual == enhanced
        strains, wanted = ([strain_of(law, m) for m in usual] for law in (case.law(), CASES["elahinia"].law()))
        assert (strains == wanted) == (modulus == "mixture" or mpa == 0.0)
    assert len({m.fraction for m in enhanced}) > 3


@EVERY
def test_overlapping_strips_are_a_caution(case):
    """From σ* = (A_s - M_s)/(1/C_M - 1/C_A) on, which is where both start lines meet."""
    assert case.law(C_A=8e6, C_M=8e6).doubt() is None
    doubt = case.law(C_A=10e6, C_M=8e6).doubt()
    assert doubt.stress == pytest.approx(640e6)
    assert "overlap above 640 MPa" in doubt.sentence
    assert "overlap at zero stress" in " ".join(case.law(A_s=320.0, C_A=8e6).cautions())


@EVERY
@pytest.mark.parametrize(("low", "high"), [("M_f", "M_s"), ("A_s", "A_f")])
def test_a_strip_without_width_is_refused_in_the_name_of_the_law(case, low, high):
    name = case.cls.registered_name
    with pytest.raises(ParameterError, match=f"`{low}` of `{name}` must be below `{high}`"):
        case.law(**{low: NUMBERS[high]})


@pytest.mark.parametrize(("cls", "word"), [(Elahinia, "mixture"), (Tanaka, "mixture")])
def test_only_liang_rogers_offers_the_mixture_modulus(cls, word):
    with pytest.raises(ParameterError, match="modulus"):
        cls(**NUMBERS, modulus=word)
    assert LiangRogers(**NUMBERS, modulus=word).modulus == word
