"""The law with an R-phase: closed forms of its strips, order of the phases, heat, and the coupled step.

Sources of truth: cos² and sin² of the two strips by hand; Liang–Rogers for the martensite; the balance of heat.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from builders import ZERO, along, example, hanging_wire, isobar, isotherm, strain_of
from kernels import KERNELS, disagreement, on_c, on_kernel_itself
from one_wire import cool, hang, write_wire
from rphase_cases import VALUES, of_material, rphase_law, rphase_system, two_phase_model

from martensite.actuators.elements.ribbon import Ribbon
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.physics.electrical.base import Conductor
from martensite.physics.electrical.resistances import ThreePhaseResistance
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.r_phase import RPhase
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.scenario.scenario import read_scenario
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate

LAW = rphase_law()
R_S, R_F, M_S, M_F = (VALUES[name] - ZERO for name in ("R_s", "R_f", "M_s", "M_f"))
C_R, C_M = VALUES["C_R"], VALUES["C_M"]


def phases(law: Any, points: list[tuple[float, float]], start: float = 0.0, substeps: int = 1) -> Any:
    return law.fractions(along(law, points, start, substeps)[-1])


# ---------------------------------------------------------------- the two transformations


@pytest.mark.parametrize("stress", [0.0, 100e6])
def test_cooling_is_two_cosines(stress: float) -> None:
    for celsius in np.linspace(20.0, 70.0, 41):
        share = np.clip((celsius - stress / C_R - R_F) / (R_S - R_F), 0.0, 1.0)
        rest = np.clip((celsius - stress / C_M - M_F) / (M_S - M_F), 0.0, 1.0)
        rho, xi = math.cos(0.5 * math.pi * share) ** 2, math.cos(0.5 * math.pi * rest) ** 2
        found = phases(LAW, isobar(120.0, celsius, stress=stress))
        assert found == pytest.approx((xi, xi, rho), abs=1e-12)
        assert found.rphase_fraction == pytest.approx(rho * (1.0 - xi), abs=1e-12)
        modulus = LAW.E_A + xi * (LAW.E_M - LAW.E_A) + rho * (1.0 - xi) * (LAW.E_R - LAW.E_A)
        wanted = stress / modulus + LAW.eps_L * xi + LAW.eps_R * rho * (1.0 - xi)
        assert LAW.strain(floats, found, stress, celsius + ZERO) == pytest.approx(wanted, abs=1e-12)


def test_the_r_phase_goes_back_within_its_own_hysteresis() -> None:
    """What there is of it, from R_f + dT_R to R_s + dT_R; half is gone in the middle."""
    middle = 0.5 * (R_S + R_F)
    for turn, formed in ((45.0, 1.0), (middle, 0.5)):
        for celsius, left in ((R_F + LAW.dT_R, 1.0), (middle + LAW.dT_R, 0.5), (R_S + LAW.dT_R, 0.0)):
            found = phases(LAW, isobar(90.0, turn, celsius))
            assert found == pytest.approx((0.0, 0.0, left * formed), abs=1e-12)


def test_a_loop_within_the_strip_stays_where_it_began_under_return_point() -> None:
    law, middle = rphase_law("return-point"), 0.5 * (R_S + R_F)
    inner = [middle - 0.5, middle + LAW.dT_R, middle - 0.5]
    once = phases(law, isobar(90.0, *inner))
    assert 0.3 < once.rphase < 0.9
    assert phases(law, isobar(90.0, *inner, *inner[1:])).rphase == pytest.approx(once.rphase, abs=1e-12)


def test_martensite_is_that_of_liang_rogers() -> None:
    plain, rng = of_material(LiangRogers, modulus="mixture"), np.random.default_rng(3)
    for _ in range(30):
        points = list(zip(rng.uniform(0.0, 400e6, 6).tolist(), rng.uniform(280.0, 400.0, 6).tolist(), strict=True))
        here, there = phases(LAW, points, 0.5), phases(plain, points, 0.5)
        assert here[:2] == there


def test_martensite_reverts_into_the_phase_that_is_stable_there() -> None:
    """Below the strips of the R-phase into R, above them into austenite, within by their hysteresis."""
    usual = phases(LAW, isobar(90.0, 20.0, 72.0))
    assert 0.0 < usual.martensite < 1.0
    assert usual.rphase_fraction == 0.0
    low = rphase_law(A_s=40.0 + ZERO, A_f=48.0 + ZERO)
    assert phases(low, isobar(90.0, 20.0, 49.0)) == (0.0, 0.0, 1.0)
    assert phases(low, isobar(90.0, 20.0, 60.0)) == (0.0, 0.0, 0.0)


# ---------------------------------------------------------------- stress


def seen_on_cooling(law: RPhase, stress: float) -> Any:
    """Fractions, and strains, on the way from hot to cold."""
    memories = along(law, isobar(*np.arange(150.0, 10.0, -0.5), stress=stress), 0.0)
    return [law.fractions(one) for one in memories], np.array([strain_of(law, one) for one in memories])


def test_two_stages_under_low_stress_and_one_beyond() -> None:
    """The start lines meet at `highest_stress`; where the strip of martensite ends above, there is no R at all."""
    meet = LAW.highest_stress()
    assert LAW.R_s + meet / C_R == pytest.approx(LAW.M_s + meet / C_M)
    none = (LAW.R_s - LAW.M_f) / (1.0 / C_M - 1.0 / C_R)
    most = [max(f.rphase_fraction for f in seen_on_cooling(LAW, s)[0]) for s in (0.0, 0.5 * meet, meet, none)]
    assert most[0] == 1.0
    assert most[1] > 0.8
    assert 0.0 < most[2] < 0.7
    assert most[3] == 0.0
    for stress, stages in ((50e6, 2), (none, 1)):
        rate = -np.diff(seen_on_cooling(LAW, stress)[1])
        moving = np.abs(rate) > 1e-5
        assert np.count_nonzero(np.diff(moving.astype(int)) == 1) == stages


def test_a_superelastic_loop_begins_with_the_r_phase() -> None:
    found = phases(LAW, isotherm(R_S + 2.0, 0.0, 140.0))
    assert found.martensite == 0.0
    assert found.rphase == 1.0
    assert phases(LAW, isotherm(R_S + 30.0, 0.0, 600.0, 0.0)) == (0.0, 0.0, 0.0)


# ---------------------------------------------------------------- resistance


def ohms(xi: float, rphase: float, strain: float, celsius: float) -> float:
    model = of_material(ThreePhaseResistance)
    return model.mix_phases(floats, xi, rphase, strain, celsius + ZERO, Conductor(1e-7, 0.2))


def test_three_phases_are_mixed_by_hand() -> None:
    for xi, r, strain, celsius in ((0.2, 0.3, 0.01, 60.0), (0.0, 1.0, 0.0, 20.0), (1.0, 0.0, 0.04, 90.0)):
        rise, width = celsius - 20.0, 1.0 - VALUES["nu"] * strain
        parts = ((xi, "M"), (r, "R"), (1.0 - xi - r, "A"))
        rho = sum(x * VALUES[f"rho_{n}"] * (1.0 + VALUES[f"a_rho_{n}"] * rise) for x, n in parts)
        assert ohms(xi, r, strain, celsius) == pytest.approx(rho * 0.2 * (1.0 + strain) / (1e-7 * width**2), rel=1e-13)
    bare = of_material(ThreePhaseResistance).resistance(floats, 0.3, 0.01, 330.0, Conductor(1e-7, 0.2))
    assert bare == pytest.approx(ohms(0.3, 0.0, 0.01, 330.0 - ZERO), rel=1e-14)


def test_resistance_rises_and_falls_on_cooling_and_only_falls_on_heating() -> None:
    """The bump; on heating martensite reverts above the R-phase, so there is none."""
    down = simulate(chilled(), {"drive": Sine(low=0.0, high=2.4, frequency=0.01)}, 200.0, samples=801)
    warm, cold = np.array(down.times) < 50.0, (np.array(down.times) > 50.0) & (np.array(down.times) < 108.0)
    ohm, xi = down["resistance"], down["martensite_fraction"]
    before, after = ohm[cold][np.argmin(ohm[cold])], ohm[cold][-1]
    assert ohm[cold].max() > 1.15 * before
    assert ohm[cold].max() > 1.08 * after
    assert xi[cold][np.argmax(ohm[cold])] < 0.01
    assert (np.diff(ohm[warm & (xi < 1.0) & (xi > 0.0)]) < 0.0).all()
    assert down["rphase_fraction"][warm].max() == 0.0


def chilled(**parts: Any) -> Any:
    """The wire under 50 MPa, heated by a given power."""
    system = hanging_wire(mass=0.6, source=PowerSource(), h=80.0)
    return system.with_parts(element=rphase_system().element, **parts)


# ---------------------------------------------------------------- the coupled step


def test_heat_of_both_transformations_is_accounted_for() -> None:
    """C ΔT less latent heat is what came in less what was lost; a quarter of the heat is that of the R-phase."""
    result = simulate(chilled(), {"drive": Sine(low=0.0, high=2.4, frequency=0.01)}, 200.0, tolerance=1e-5)
    assert (result.energy["heat"].residual or 1.0) < 1e-6
    element = chilled().element.with_values({"initial_fraction": 0.0})
    state = element.init(floats, 5.884, 120.0 + ZERO)
    between = element.in_state(floats, state, Fractions(0.0, 0.0), 44.0 + ZERO, 5.884)
    assert element.law.fractions(between.memory).rphase == 1.0
    released = element.heat_content(floats, state) - element.heat_content(floats, between)
    latent = element.latent_heat_total(floats, 0.0, 300.0)
    assert released == pytest.approx(76.0 * element.heat_capacity_total() + VALUES["latent_R"] * latent, rel=1e-12)


def test_the_step_is_of_second_order() -> None:
    waves = {"drive": Sine(low=0.02, high=0.2, frequency=0.05)}
    runs = {h: simulate(rphase_system(), waves, 20.0, step=h, samples=101) for h in (0.04, 0.02, 0.01, 6.25e-4)}
    names = ("temperature", "martensite_fraction", "rphase_fraction", "position")
    for name in names:
        meant = np.array(runs[6.25e-4][name])
        errors = [np.sqrt(np.mean((np.array(runs[h][name]) - meant) ** 2)) for h in (0.04, 0.02, 0.01)]
        assert np.polyfit(np.log([0.04, 0.02, 0.01]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.3), name


def test_steps_of_any_length_are_solved() -> None:
    """Hot and cold, stiff and soft, with heat of the R-phase from none to all of it."""
    rng = np.random.default_rng(5)
    for _ in range(12):
        law = rphase_law(latent_R=rng.uniform(0.0, 1.0), dT_R=rng.uniform(0.0, 6.0), eps_R=rng.uniform(0.0, 0.02))
        system = rphase_system(
            law, mechanism=rphase_system().mechanism.with_values({"stiffness": 10 ** rng.uniform(1, 5)})
        )
        state = system.init(floats, 0.0)
        for duty, dt in zip(rng.uniform(0.0, 0.5, 40), 10 ** rng.uniform(-2, 1, 40), strict=True):
            state, report = system.step(floats, state, duty, dt=dt)
            assert report.residual < 1e-12


def test_an_element_of_three_phases_is_the_same_in_c(c_compiler: str) -> None:
    element, kernel = rphase_system().element, KERNELS["element"]["step"]
    inputs = kernel.inputs()
    meant = on_kernel_itself(element, kernel, inputs)
    assert disagreement(meant, on_c(element, kernel, inputs)) < 1e-12


# ---------------------------------------------------------------- what is refused, and what is said


def test_numbers_that_make_no_sense_are_refused() -> None:
    with pytest.raises(ParameterError, match="`R_f` of `r-phase` must be below `R_s`"):
        rphase_law(R_f=60.0 + ZERO)
    with pytest.raises(ParameterError, match="`eps_R` of `r-phase` must be below `eps_L`"):
        rphase_law(eps_R=0.045)
    assert "M_s is not below R_s" in rphase_law(M_s=57.0 + ZERO).cautions()[-1]
    with pytest.raises(ParameterError, match="Law `r-phase` has three phases, but the cells of a `ribbon`"):
        example(Ribbon, wire=rphase_system().element)


SCENARIO = write_wire(
    element='material = "niti-r-phase"\nresistance = "RESISTANCE"',
    law='{ kind = "LAW" }',
    diameter="0.2 mm",
    cooling=cool(80),
    mechanism=hang("0.2 kg"),
    drive='kind = "current"\nwaveform = { kind = "step", high = "0.3 A" }',
    run='duration = "1 s"',
)


def test_a_resistance_that_does_not_know_the_r_phase_of_its_material_is_said() -> None:
    def cautions(law: str, resistance: str, material: str = "niti-r-phase") -> list[str]:
        text = SCENARIO.replace("LAW", law).replace("RESISTANCE", resistance).replace("niti-r-phase", material)
        return [one for one in read_scenario(text).cautions if "R-phase" in one]

    (found,) = cautions("r-phase", "furst-seelecke")
    assert "`niti-r-phase` has an R-phase (from 56 degC on cooling), which resistance `furst-seelecke`" in found
    (found,) = cautions("liang-rogers", "mixture")
    assert "law `liang-rogers` and resistance `mixture` do not know" in found
    assert cautions("r-phase", "three-phase") == []
    assert cautions("liang-rogers", "mixture", "flexinol-90") == []


def test_only_what_knows_the_r_phase_shows_it() -> None:
    assert "rphase_fraction" in rphase_system().outputs()
    assert "rphase_fraction" not in two_phase_model().outputs()
