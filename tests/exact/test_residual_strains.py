"""Residual strains, thermal strain and loop work of the laws with two strips, in closed form."""

import math

import numpy as np
import pytest
from builders import ZERO, along, isobar, isotherm, strain_of
from closed_forms import A_F, A_S, BOTH_RULES, C_A, C_M, EPS_L, M_F, M_S, exact
from grids import over
from strip_cases import EVERY, cosine

from martensite.kernels import floats

# ---------------------------------------------------------------- residual strains


@BOTH_RULES
@EVERY
class TestResidualStrains:
    """Loading from unloaded austenite and back, strain less that of austenite there."""

    def residual(self, case, rule, celsius, top, xi=0.0):
        memories = along(case.law(rule), isotherm(celsius, 0, top, 0), xi, substeps=20)
        return strain_of(case.law(rule), memories[-1]) - strain_of(case.law(rule), memories[0])

    @over("celsius", [52.5, 60.0, 67.5, 69.0, 73.0, 77.0, 78.5, 90.0, 110.0])
    def test_full_loading(self, case, rule, celsius):
        """ε_L below A_s, a part of it up to A_f, nothing or a tail above."""
        top = C_M * (celsius - M_F) + 200.0
        left = EPS_L * (1.0 - case.cold(celsius, top)) * case.hot(celsius)
        assert self.residual(case, rule, celsius, top) == exact(left)
        if case.left is cosine and celsius > A_F:
            assert left == self.residual(case, rule, celsius, top) == 0.0

    def test_cold_martensite_is_elastic(self, case, rule):
        """Below M_f one fraction cannot detwin: no residual, and the slope of E."""
        law = case.law(rule)
        assert self.residual(case, rule, 20.0, 400.0, xi=1.0) == 0.0
        a, b = along(law, isotherm(20.0, 0, 100), 1.0)
        E = law.E_A if case.options.get("modulus") == "austenite" else law.E_M
        assert strain_of(law, b) - strain_of(law, a) == pytest.approx(100e6 / E, rel=1e-12, abs=0)

    def test_shape_memory_cycle_keeps_the_strain_of_all_martensite(self, case, rule):
        """Load and unload cold, heat, cool: one fraction comes back to ε_L, not to zero."""
        law = case.law(rule)
        path = [*isotherm(20, 0, 300, 0), *isobar(100, 20)]
        found = [strain_of(law, m) for m in along(law, path, 1.0)]
        hot = case.hot(100)
        ends = [1.0, hot, 1.0 - (1.0 - hot) * case.cold(20)]
        assert [found[k] for k in (0, 3, 4)] == [exact(EPS_L * xi) for xi in ends]
        assert found[2] == found[0]


@EVERY
@over("Theta", [0.055e6, -0.74e6])
def test_sign_of_the_thermal_strain(case, Theta):
    """A free bar expands on heating if and only if Θ < 0; and the law cautions against Θ > 0."""
    law = case.law(Theta=Theta)
    a, b = along(law, isobar(20, 60), 0.0)
    E = law.young(law.fractions(a))
    assert strain_of(law, b) - strain_of(law, a) == pytest.approx(-Theta * 40.0 / E, rel=1e-9)
    assert any("Theta" in sentence for sentence in law.cautions()) == (Theta > 0)


# ---------------------------------------------------------------- loop work


def loop(law, celsius, top, count=4001):
    """Mean stresses [Pa], strains [-] and compliances [1/Pa] along 0 → top → 0 MPa."""
    stresses = np.concatenate([np.linspace(0, top, count), np.linspace(top, 0, count)[1:]])
    memories = along(law, isotherm(celsius, *stresses.tolist()), 0.0)
    strains = np.array([strain_of(law, m) for m in memories])
    compliances = np.array([law.compliance(floats, law.fractions(m)) for m in memories])
    return 0.5e6 * (stresses[1:] + stresses[:-1]), strains, compliances


@EVERY
@over("Theta", [0.0, 0.055e6])
def test_work_of_a_full_isothermal_loop(case, Theta):
    """W = ε_L [C_M (T - u*) - C_A (T - w*)] + ½ ∮ σ² d(1/E), with the mean lines u* and w*.

    Cosines: halfway through the strips. Exponentials: one decay length, width/(2 ln 10), in.
    """
    law, celsius = case.law(Theta=Theta), 120.0
    mean, strains, compliances = loop(law, celsius, C_M * (celsius - M_F) + 200.0)
    inside = 0.5 if case.left is cosine else 1.0 / (2.0 * math.log(10.0))
    forward, reverse = M_S - inside * (M_S - M_F), A_S + inside * (A_F - A_S)
    steps = EPS_L * (C_M * (celsius - forward) - C_A * (celsius - reverse)) * 1e6
    elastic = 0.5 * np.sum(mean**2 * np.diff(compliances))
    thermal = Theta * (celsius + ZERO - law.T_ref) * np.sum(mean * np.diff(compliances))
    work = np.sum(mean * np.diff(strains))
    assert work == pytest.approx(steps + elastic - thermal, rel=1e-4)
