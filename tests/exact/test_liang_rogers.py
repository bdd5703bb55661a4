"""Liang–Rogers law against closed forms: curves, directions, starts on a line, in a system."""

import numpy as np
import pytest
from builders import ZERO, along, chamber, fraction_after, isobar, isotherm, law_a, problem_a, through, wire_a
from closed_forms import A_F, A_S, BOTH_RULES, C_A, C_M, M_F, M_S, exact, forward, reverse
from grids import over

from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.simulate.api import simulate

# ---------------------------------------------------------------- curves


@BOTH_RULES
class TestCurves:
    @over("xi", [1.0, 0.37])
    @over("celsius", [68.001, 70.0, 73.0, 77.999])
    def test_heating(self, rule, xi, celsius):
        assert fraction_after(law_a(rule), isobar(20, celsius), xi) == exact(reverse(celsius, xi=xi))

    @over("xi", [0.0, 0.37])
    @over("celsius", [51.999, 50.0, 47.0, 42.001])
    def test_cooling(self, rule, xi, celsius):
        assert fraction_after(law_a(rule), isobar(100, celsius), xi) == exact(forward(celsius, xi=xi))

    @over("mpa", [50.0, 100.0, 200.0])
    def test_stress_shifts_all_lines(self, rule, mpa):
        """At constant stress by σ/C_M (forward) and σ/C_A (reverse)."""
        for share in (0.0, 0.25, 0.5, 1.0):
            hot = A_S + mpa / C_A + share * (A_F - A_S)
            path = isobar(20, hot, stress=mpa * 1e6)
            assert fraction_after(law_a(rule), path, 1.0) == exact(reverse(hot, mpa))
            cold = M_S + mpa / C_M - share * (M_S - M_F)
            path = isobar(150, cold, stress=mpa * 1e6)
            assert fraction_after(law_a(rule), path, 0.0) == exact(forward(cold, mpa))

    @over("celsius", [53.0, 60.0, 90.0])
    def test_loading_and_unloading(self, rule, celsius):
        start, finish = C_M * (celsius - M_S), C_M * (celsius - M_F)
        half = 0.5 * (start + finish)
        law = law_a(rule)
        assert fraction_after(law, isotherm(celsius, 0, start), 0.0) == 0.0
        assert fraction_after(law, isotherm(celsius, 0, half), 0.0) == exact(0.5)
        assert fraction_after(law, isotherm(celsius, 0, finish + 1e-6), 0.0) == 1.0
        down = max(0.0, C_A * (celsius - A_F) + 30.0)
        path = isotherm(celsius, 0, finish + 50, down)
        assert fraction_after(law, path, 0.0) == exact(reverse(celsius, down) if celsius > A_S else 1.0)

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


@BOTH_RULES
class TestDirections:
    def test_heating_with_fast_loading_forms_martensite(self, rule):
        path = [(80e6, 64 + ZERO), (200e6, 68 + ZERO)]  # u from 54 to 43
        assert fraction_after(law_a(rule), path, 0.0) == exact(forward(68, 200))

    def test_cooling_with_fast_unloading_forms_austenite(self, rule):
        path = [(200e6, 85 + ZERO), (50e6, 80 + ZERO)]  # w from 65 to 75
        assert fraction_after(law_a(rule), path, 1.0) == exact(reverse(80, 50))

    @over("xi", [0.0, 0.4, 1.0])
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


@BOTH_RULES
@pytest.mark.parametrize("mpa", [0.0, 37.0])
class TestStartsOnALine:
    def path(self, line, C, mpa, change):
        start = line + mpa / C
        return isobar(start, start + change, stress=mpa * 1e6)

    @over("xi", [0.0, 0.4, 1.0])
    def test_reverse_start_line(self, rule, mpa, xi):
        law = law_a(rule)
        up = fraction_after(law, self.path(A_S, C_A, mpa, 4.0), xi)
        assert up == exact(reverse(A_S + 4.0, xi=xi))
        assert fraction_after(law, self.path(A_S, C_A, mpa, -4.0), xi) == xi

    @over("xi", [0.0, 0.4, 1.0])
    def test_forward_start_line(self, rule, mpa, xi):
        law = law_a(rule)
        down = fraction_after(law, self.path(M_S, C_M, mpa, -4.0), xi)
        assert down == exact(forward(M_S - 4.0, xi=xi))
        assert fraction_after(law, self.path(M_S, C_M, mpa, 4.0), xi) == xi

    @over("xi", [0.0, 0.4, 1.0])
    @over("change", [5.0, -5.0, 1e-12, -1e-12, 0.0])
    def test_finish_lines(self, rule, mpa, xi, change):
        """0/0: nothing is left of the strip, whatever is left to transform stays."""
        law = law_a(rule)
        assert fraction_after(law, self.path(A_F, C_A, mpa, change), xi) == xi
        assert fraction_after(law, self.path(M_F, C_M, mpa, change), xi) == xi


@BOTH_RULES
def test_nothing_left_to_transform_leaves_the_branch_alone(rule):
    memory = along(law_a(rule), isobar(50, 75, 90), 0.0)[-1]
    assert (memory.fraction, memory.branch) == (0.0, 0.0)
    memory = along(law_a(rule), isobar(75, 45, 20), 1.0)[-1]
    assert (memory.fraction, memory.branch) == (1.0, 0.0)


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


@BOTH_RULES
def test_a_chamber_run_is_the_bare_law(rule):
    """Prescribed temperature under a dead weight: ξ of the system = ξ of the law, to round-off."""
    law = law_a(rule)
    celsius = [20.0, 84.0, 60.0, 51.0, 88.0]
    run = simulate(chamber(law, mass=1.0), through([t + ZERO for t in celsius]), 4.0, step=0.01, samples=5)
    stress = run["stress"][0]
    expected = [m.fraction for m in along(law, isobar(*celsius, stress=stress), 1.0)]
    assert run["martensite_fraction"] == pytest.approx(expected, abs=1e-6)
    assert len({round(x, 3) for x in expected}) > 3


def test_a_wrong_slope_is_noticed():
    """Stress shifts the lines by σ/C, not by more."""
    found = fraction_after(law_a(C_A=10.001e6), isobar(20, 83, stress=100e6), 1.0)
    assert found != exact(reverse(83, 100))
