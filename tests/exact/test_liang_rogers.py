"""Liang–Rogers law: its printed curves and a system. Tests of all strip laws are in `test_strip_laws`."""

import pytest
from builders import ZERO, along, chamber, fraction_after, isobar, law_a, through
from closed_forms import BOTH_RULES, exact, forward, reverse

from martensite.simulate.api import simulate


@BOTH_RULES
class TestCurves:
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


@BOTH_RULES
class TestDirections:
    def test_outside_the_strips_nothing_happens(self, rule):
        path = isobar(53, 67, 53.5, 66, 52, 68)
        assert fraction_after(law_a(rule), path, 0.4, substeps=10) == 0.4
        path = isobar(20, 41, -10, 41.9)
        assert fraction_after(law_a(rule), path, 0.4, substeps=10) == 0.4  # kept as given

    def test_wrong_way_inside_a_strip_changes_nothing(self, rule):
        assert fraction_after(law_a(rule), isobar(47, 60), 0.4) == 0.4
        assert fraction_after(law_a(rule), isobar(73, 60), 0.4) == 0.4


@BOTH_RULES
def test_nothing_left_to_transform_leaves_the_branch_alone(rule):
    memory = along(law_a(rule), isobar(50, 75, 90), 0.0)[-1]
    assert (memory.fraction, memory.branch) == (0.0, 0.0)
    memory = along(law_a(rule), isobar(75, 45, 20), 1.0)[-1]
    assert (memory.fraction, memory.branch) == (1.0, 0.0)


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
