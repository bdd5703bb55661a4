"""Residual strains, thermal strain and loop work of the Liang–Rogers law, in closed form."""

import math

import numpy as np
import pytest
from builders import ZERO, along, isobar, isotherm, law_a, strain_of
from closed_forms import A_F, A_S, BOTH_RULES, C_A, C_M, EPS_L, M_F, M_S, exact, forward

from martensite.runtimes import floats

# ---------------------------------------------------------------- residual strains


@BOTH_RULES
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
        assert strain_of(law, b) - strain_of(law, a) == pytest.approx(100e6 / E, rel=1e-12, abs=0)

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
    assert strain_of(law, b) - strain_of(law, a) == pytest.approx(
        -Theta * 40.0 / law.E_A, rel=1e-10, abs=0
    )
    assert any("Theta" in sentence for sentence in law.cautions()) == (Theta > 0)


# ---------------------------------------------------------------- loop work


@BOTH_RULES
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
    assert work == pytest.approx(EPS_L * steps * 1e6 + elastic - shift, rel=1e-5)


def test_a_wrong_maximum_strain_is_noticed():
    law = law_a(eps_L=0.04001, Theta=0.0)
    memory = along(law, isobar(100, 20), 0.0)[-1]
    assert strain_of(law, memory) != exact(EPS_L)
