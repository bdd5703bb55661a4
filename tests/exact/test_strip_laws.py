"""What every law with one fraction and two strips must show: curves, directions, history, checks.

Liang–Rogers, Elahinia and Tanaka differ in what a process leaves and in Young's modulus only.
"""

import numpy as np
import pytest
from builders import ZERO, fraction_after, isobar, problem_a, through, wire_a
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

    def test_nothing_is_left_after_thousands_of_kelvin(self, rule):
        law = CASES["tanaka austenite"].law(rule)
        assert fraction_after(law, isobar(20, 5e3, 1e5, -270, 1e5), 1.0) == 0.0


# ---------------------------------------------------------------- what only u and w decide


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
    def test_fifty_small_cycles(self, case):
        """Restart ratchets, resume stays."""
        path = isobar(20, 74, *[72, 74] * 49)
        assert fraction_after(case.law("resume"), path, 1.0) == exact(case.hot(74))
        ratchets = case.hot(74) * (case.hot(74) / case.hot(72)) ** 49
        assert fraction_after(case.law("restart"), path, 1.0) == exact(ratchets)
        assert ratchets < 1e-3 < case.hot(74)

    def test_the_memory_is_cleared_by_an_opposite_transformation_only(self, case):
        law, (hot, cold) = case.law("resume"), (case.hot, case.cold)
        between = 1 - cold(50) * (1 - hot(73))
        found = fraction_after(law, isobar(20, 73, 50, 70), 1.0)
        assert found == exact(between * hot(70))
        for turn in (53.0, M_S):  # not below M_s, not even when rounding puts 52 °C there
            assert fraction_after(law, isobar(20, 73, turn, 70), 1.0) == exact(hot(73))


# ---------------------------------------------------------------- laws compared, values checked


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
