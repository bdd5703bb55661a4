"""Lagoudas law against closed forms: calibration, loops, starts, cuts, the march."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from builders import along, chamber, fraction_after, stepper, strain_of, through
from scipy.integrate import quad

from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.kernels.dual import value_and_slope
from martensite.physics.kinetics.hardening import (
    apply_waist,
    compute_hardening,
    hardening_integral,
    invert_hardening,
    remove_waist,
)
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.lagoudas import Lagoudas
from martensite.physics.materials.base import load_material
from martensite.simulate.api import simulate

MPA = 1e6
SECTION = 0.25 * math.pi * 0.381e-3**2
EXPONENTS = {"linear": (1.0, 1.0, 1.0, 1.0), "round": (0.17, 0.27, 0.25, 0.35), "roundest": (0.05, 0.05, 0.05, 0.05)}


def law_of(exponents=(0.95, 0.95, 0.95, 0.95), **changes):
    """The law with the numbers of the actuator material, some of them changed."""
    values = load_material("niti-lagoudas").values
    numbers: dict[str, Any] = {n: values[n].value for n in Lagoudas.declarations if n in values}
    names = ("n_1", "n_2", "n_3", "n_4")
    numbers |= dict(zip(names, exponents, strict=True))
    return Lagoudas(**(numbers | changes))


def cycle(initial: str, stress: float) -> Any:
    """A hanging wire through a whole cycle of temperature."""
    system = chamber(law_of(H_min=0.01), mass=stress * SECTION / 9.80665, initial=initial)
    return simulate(system, through([240.0, 420.0, 240.0], 10.0), 20.0, samples=201)


@pytest.mark.parametrize("stress", [20 * MPA, 150 * MPA])
def test_a_trained_wire_starts_where_its_cycles_end(stress):
    """ε_t = H(σ₀) at the start; one that was stretched cold starts with H_sat, and drifts to it."""
    law, trained, stretched = (law_of(H_min=0.01), cycle("trained", stress), cycle("oriented", stress))
    H = law.current(floats, stress)
    elastic = stress / law.E_M + law.alpha_M * (240.0 - law.T_ref)
    assert trained["strain"][0] == pytest.approx(H + elastic, rel=1e-12)
    assert stretched["strain"][0] == pytest.approx(law.H_sat + elastic, rel=1e-12)
    assert trained["strain"][-1] == pytest.approx(trained["strain"][0], rel=1e-9)
    assert stretched["strain"][-1] == pytest.approx(trained["strain"][0], rel=1e-9)
    assert [one.kind for one in trained.alarms] == []
    (drift,) = stretched.alarms
    assert drift.kind == "drift" and drift.sentence in stretched.warnings
    assert drift.limit == 1.0
    # The drift is read at the first accepted step at which the fraction is back, to 1e-3 of it.
    assert drift.worst == pytest.approx(H / law.H_sat, rel=1e-3)


def oriented_after(law, points, xi, substeps=1):
    return law.fractions(along(law, points, xi, substeps)[-1]).oriented


# ---------------------------------------------------------------- hardening


@pytest.mark.parametrize("m", [0.05, 0.2, 0.5, 0.95, 1.0])
@pytest.mark.parametrize("n", [0.05, 0.3, 0.8, 1.0])
def test_hardening_is_inverted_to_rounding(m, n):
    for xi in [*np.linspace(0.0, 1.0, 101).tolist(), 1e-9, 1.0 - 1e-9]:
        share = 0.5 * (1.0 + xi**m - (1.0 - xi) ** n)
        assert compute_hardening(floats, xi, m, n) == pytest.approx(share, abs=1e-15)
        assert invert_hardening(floats, share, m, n) == pytest.approx(xi, abs=1e-14)
    assert invert_hardening(floats, 0.0, m, n) == invert_hardening(floats, -1e30, m, n) == 0.0
    assert invert_hardening(floats, 1.0, m, n) == invert_hardening(floats, 1e30, m, n) == 1.0


def test_integral_of_hardening():
    """∫h dξ over everything is ½ [1 + 1/(m+1) - 1/(n+1)]."""
    whole = [hardening_integral(floats, xi, 0.3, 0.8) for xi in (0.0, 1.0)]
    assert whole[1] - whole[0] == pytest.approx(0.5 * (1 + 1 / 1.3 - 1 / 1.8), abs=1e-15)


# ---------------------------------------------------------------- waist

WAISTS = [0.0, 1e-300, 1e-12, 1e-4, 0.3, 0.9, 0.98]
WAISTED = {"hardening": "waisted", "waist_f": 0.9, "waist_r": 0.95}


@pytest.mark.parametrize("b", WAISTS)
def test_waist_is_inverted_to_rounding(b):
    for h in [*np.linspace(0.0, 1.0, 201).tolist(), 1e-9, 0.5 + 1e-12, 1.0 - 1e-9]:
        y = 2.0 * h - 1.0
        share = 0.5 * (1.0 + (1.0 - b) * y + b * y**3)
        assert apply_waist(h, b) == pytest.approx(share, abs=1e-15)
        assert remove_waist(floats, share, b) == pytest.approx(h, abs=1e-14)
        assert apply_waist(remove_waist(floats, h, b), b) == pytest.approx(h, abs=1e-14)
    assert remove_waist(floats, 0.0, b) == remove_waist(floats, -1e30, b) == 0.0
    assert remove_waist(floats, 1.0, b) == remove_waist(floats, 1e30, b) == 1.0


@pytest.mark.parametrize("b", WAISTS)
def test_slopes_through_a_waist(b):
    """dh/dh_w = 1/(1 - b + 3 b y²) and dh/db = ½ (y - y³) times it, exactly, also at b = 0."""
    for h in (0.0, 0.1, 0.5, 0.85, 1.0):
        y, share = 2.0 * h - 1.0, apply_waist(h, b)
        steep = 1.0 / (1.0 - b + 3.0 * b * y * y)
        inside = min(max(share, 1e-9), 1.0 - 1e-9)
        _, slope = value_and_slope(floats, lambda xp, x: remove_waist(xp, x, b), inside)
        assert slope == pytest.approx(steep, rel=1e-5)
        if 0.0 < h < 1.0:
            _, slope = value_and_slope(floats, lambda xp, x, s=share: remove_waist(xp, s, x), b)
            assert slope == pytest.approx(0.5 * (y - y**3) * steep, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("b", [0.0, 0.5, 0.98])
@pytest.mark.parametrize("m", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("n", [0.05, 0.3, 1.0])
def test_waisted_hardening_is_inverted(b, m, n):
    for xi in np.linspace(0.0, 1.0, 101).tolist():
        share = apply_waist(compute_hardening(floats, xi, m, n), b)
        found = invert_hardening(floats, remove_waist(floats, share, b), m, n)
        assert found == pytest.approx(xi, abs=1e-12)


@pytest.mark.parametrize("exponents", EXPONENTS.values(), ids=EXPONENTS)
def test_without_a_waist_waisted_is_smooth(exponents):
    smooth, none = law_of(exponents), law_of(exponents, hardening="waisted")
    for leg in LEGS.values():
        path = [*leg, (leg[-1][0], 400.0), *leg[::-1]]
        for a, b in zip(along(smooth, path, 0.0, 3), along(none, path, 0.0, 3), strict=True):
            assert a == pytest.approx(b, rel=1e-12, abs=1e-12)
    assert none.constants(floats) == pytest.approx(smooth.constants(floats), rel=1e-12)
    assert none.gap() == pytest.approx(smooth.gap(), rel=1e-12)


def test_constants_of_a_waisted_law_close_the_balances():
    """Equal hardening energy both ways, the integrals by quadrature."""
    law = law_of((0.2, 0.5, 0.9, 0.4), **WAISTED)
    c = law.constants(floats)
    shares = law.forward_hardening, law.reverse_hardening
    areas = [quad(lambda xi, h=h: h(floats, xi), 0.0, 1.0, epsabs=1e-12)[0] for h in shares]
    assert c.a_1 * areas[0] + c.a_3 == pytest.approx(c.a_2 * areas[1] - c.a_3, rel=1e-9)
    assert law_of((0.2, 0.5, 0.9, 0.4)).constants(floats).a_3 != pytest.approx(c.a_3, rel=1e-3)


def test_strain_through_a_waist_converges_with_the_cuts():
    """∫H dξ across the whole waist: little in a single step, less with more."""
    law, leg = law_of(EXPONENTS["round"], **WAISTED), LEGS["both"]
    exact = oriented_after(law, leg, 0.0, 1024)
    errors = [abs(oriented_after(law, leg, 0.0, cuts) - exact) for cuts in (1, 16, 256)]
    assert errors[0] < 2e-2
    assert errors[1] < 1e-4
    assert errors[2] < 1e-7


def test_strain_of_a_waisted_law_never_falls_with_stress():
    law = law_of(EXPONENTS["round"], **WAISTED)
    memory = along(law, [(50 * MPA, 400.0), (50 * MPA, 318.0)], 0.0)[-1]
    rows = [law.kinetics(floats, memory, s * MPA, 325.0, 0.0)[0] for s in range(0, 401, 2)]
    strain = np.array([strain_of(law, row) for row in rows])
    assert (np.diff(strain) >= 0.0).all()
    assert rows[-1].fraction - rows[0].fraction > 0.5


def test_waists_of_a_smooth_law_are_named():
    assert any("waist" in text for text in law_of(waist_f=0.5).cautions())
    assert not any("waist" in text for text in law_of(**WAISTED).cautions())


# ---------------------------------------------------------------- calibration


@pytest.mark.parametrize("exponents", EXPONENTS.values(), ids=EXPONENTS)
class TestZeroStress:
    def test_forward_runs_from_M_s_to_M_f(self, exponents):
        law = law_of(exponents)
        assert fraction_after(law, [(0.0, 400.0), (0.0, law.M_s)], 0.0) == 0.0
        assert fraction_after(law, [(0.0, 400.0), (0.0, law.M_f)], 0.0) == 1.0
        assert 0.0 < fraction_after(law, [(0.0, 400.0), (0.0, law.M_s - 5.0)], 0.0) < 1.0
        assert 0.0 < fraction_after(law, [(0.0, 400.0), (0.0, law.M_f + 5.0)], 0.0) < 1.0

    def test_reverse_runs_from_A_s_to_A_f(self, exponents):
        law = law_of(exponents)
        assert fraction_after(law, [(0.0, 250.0), (0.0, law.A_s)], 1.0) == 1.0
        assert fraction_after(law, [(0.0, 250.0), (0.0, law.A_f)], 1.0) == 0.0
        assert 0.0 < fraction_after(law, [(0.0, 250.0), (0.0, law.A_s + 3.0)], 1.0) < 1.0
        assert 0.0 < fraction_after(law, [(0.0, 250.0), (0.0, law.A_f - 3.0)], 1.0) < 1.0

    def test_between_the_curve_is_the_hardening(self, exponents):
        law, (n_1, n_2, n_3, n_4) = law_of(exponents), exponents
        for xi in (0.1, 0.5, 0.8):
            cold = law.M_s - (law.M_s - law.M_f) * 0.5 * (1 + xi**n_1 - (1 - xi) ** n_2)
            hot = law.A_f - (law.A_f - law.A_s) * 0.5 * (1 + xi**n_3 - (1 - xi) ** n_4)
            assert fraction_after(law, [(0.0, 400.0), (0.0, cold)], 0.0) == pytest.approx(xi)
            assert fraction_after(law, [(0.0, 250.0), (0.0, hot)], 1.0) == pytest.approx(xi)


def test_constants_close_the_balances():
    """Equal hardening energy both ways, and the sum and difference of the surfaces at σ = 0."""
    law = law_of((0.2, 0.5, 0.9, 0.4))
    c = law.constants(floats)
    forward = 0.5 * c.a_1 * (1 + 1 / 1.2 - 1 / 1.5) + c.a_3
    reverse = 0.5 * c.a_2 * (1 + 1 / 1.9 - 1 / 1.4) - c.a_3
    assert forward == pytest.approx(reverse, rel=1e-12)
    s, u, y = c.rho_Delta_s0, c.rho_Delta_u0, c.Y_0
    assert s * law.M_s == pytest.approx(u + c.a_3 + y)
    assert s * law.M_f == pytest.approx(u + c.a_1 + c.a_3 + y)
    assert s * law.A_f == pytest.approx(u - c.a_3 - y)
    assert s * law.A_s == pytest.approx(u + c.a_2 - c.a_3 - y)


# ---------------------------------------------------------------- loops


class TestSuperelasticLoop:
    """A virgin wire, austenitic above A_f: the loop that a start in martensite cannot have."""

    def loop(self, law, kelvin, top=800.0, steps=400):
        """Work [J/m³] of a loop, its remaining strain, and the largest fraction on it."""
        memory = law.init(floats, Fractions(0.0, 0.0), 0.0, kelvin)
        before, work, most = (0.0, strain_of(law, memory)), 0.0, 0.0
        first, advance = before[1], stepper(law)
        up = np.linspace(0.0, top * MPA, steps)
        for stress in [*up.tolist(), *up[::-1].tolist()]:
            memory = advance(memory, stress, kelvin, 0.0)
            now = stress, strain_of(law, memory)
            work += 0.5 * (now[0] + before[0]) * (now[1] - before[1])
            before, most = now, max(most, memory.fraction)
        return work, before[1] - first, most

    @pytest.mark.parametrize("kelvin", [331.0, 340.0, 350.0])
    def test_it_runs_closes_and_dissipates(self, kelvin):
        work, remains, most = self.loop(law_of(), kelvin)
        assert most == 1.0
        assert abs(remains) < 1e-15
        assert work > 1e6

    def test_work_of_a_loop_with_one_strain_and_equal_slopes(self):
        """D = 0: ∮σ dε = ∫(T_r - T_f) dξ (-ρΔs₀), the same at every temperature."""
        law = law_of((1.0, 1.0, 1.0, 1.0), H_min=0.048202422, C_A=8e6, C_M=8e6)
        gap = 0.5 * (law.A_s + law.A_f) - 0.5 * (law.M_s + law.M_f)
        wanted = -law.constants(floats).rho_Delta_s0 * gap
        for kelvin in (335.0, 350.0):
            assert self.loop(law, kelvin, steps=1000)[0] == pytest.approx(wanted, rel=1e-4)

    def test_below_A_s_the_strain_stays_until_it_is_heated(self):
        law = law_of()
        path = [(0.0, 312.0), (600 * MPA, 312.0), (0.0, 312.0), (0.0, 340.0)]
        *_, stretched, heated = along(law, path, 0.0, 20)
        assert stretched.fraction == 1.0
        assert stretched.ratio > 0.8
        assert heated.fraction == 0.0

    def test_the_material_of_the_superelastic_example(self):
        values = load_material("niti-superelastic-lagoudas").values
        numbers: dict[str, Any] = {n: values[n].value for n in Lagoudas.declarations if n in values}
        law = Lagoudas(**numbers)
        work, remains, most = self.loop(law, 298.15, 700.0)
        assert most == 1.0
        assert abs(remains) < 1e-15
        assert work > 1e6


QUICK = [("linear", "smooth"), ("round", "smooth"), ("roundest", "waisted")]
"""One of each; the others with the slow tests."""


@pytest.mark.parametrize(
    ("exponents", "changes"),
    [
        pytest.param(
            exponents, changes, id=f"{name}-{hardening}", marks=[] if (name, hardening) in QUICK else [pytest.mark.slow]
        )
        for name, exponents in EXPONENTS.items()
        for hardening, changes in (("smooth", {}), ("waisted", WAISTED))
    ],
)
def test_closed_isothermal_cycles_dissipate(exponents, changes):
    """From austenite through any turning points and back, where strain grows with stress."""
    law, rng = law_of(exponents, **changes), np.random.default_rng(4)
    advance = stepper(law)
    for _ in range(3):
        kelvin, turns = law.A_f + rng.uniform(0.0, 20.0), rng.uniform(0.0, 600e6, 5)
        memory = law.init(floats, Fractions(0.0, 0.0), 0.0, kelvin)
        before, work = (0.0, strain_of(law, memory)), 0.0
        for begin, end in pairwise([0.0, *turns.tolist(), 0.0]):
            for stress in np.linspace(begin, end, 60).tolist():
                memory = advance(memory, stress, kelvin, 0.0)
                now = stress, strain_of(law, memory)
                work += 0.5 * (now[0] + before[0]) * (now[1] - before[1])
                before = now
        assert memory.fraction == 0.0
        assert work > -1.0


# ---------------------------------------------------------------- any state, inner loops


def test_unoriented_martensite_recovers_unoriented():
    """Λ = 0 stays 0 on reverse: heated under load it gives no stroke beyond the elastic."""
    law = law_of()
    cold = law.init(floats, Fractions(1.0, 0.0), 0.0, 290.0)
    loaded, _ = law.kinetics(floats, cold, 30 * MPA, 290.0, 0.0)
    half, fractions = law.kinetics(floats, loaded, 30 * MPA, 322.0, 0.0)
    assert 0.0 < fractions.martensite < 1.0
    assert fractions.oriented == 0.0
    assert law.fractions(half).oriented == 0.0


def test_martensite_stays_where_it_would_form_again():
    """Unoriented, above A_f, under high stress: both surfaces are crossed, forward is stronger."""
    law = law_of()
    memory = law.init(floats, Fractions(1.0, 0.0), 0.0, 312.0)
    memory, fractions = law.kinetics(floats, memory, 700 * MPA, 312.0, 0.0)
    memory, fractions = law.kinetics(floats, memory, 700 * MPA, 340.0, 0.0)
    assert fractions == Fractions(1.0, 0.0)
    falling = [law.kinetics(floats, memory, s * MPA, 340.0, 0.0)[1] for s in range(700, -1, -10)]
    fractions = np.array([f.martensite for f in falling])
    assert (np.diff(fractions) <= 0.0).all()
    assert np.abs(np.diff(fractions)).max() < 0.06
    assert fractions[-1] == 0.0


# ---------------------------------------------------------------- cuts


LEGS = {
    "cooling": [(120 * MPA, 400.0), (120 * MPA, 311.0)],
    "loading": [(0.0, 345.0), (430 * MPA, 345.0)],
    "both": [(30 * MPA, 360.0), (260 * MPA, 322.0)],
    "loading and heating": [(0.0, 315.0), (560 * MPA, 350.0)],
    "unloading and cooling": [(400 * MPA, 385.0), (100 * MPA, 310.0)],
}


TURNING = {"E_M": 66.2e9, "H_k": 5e-8, "C_A": 8.34e6, "C_M": 8.34e6}
TURNS = [(20 * MPA, 307.0), (420 * MPA, 307.0 + 400 / 8.34 * 1.02)]
"""Along this leg the forward surface is crossed farthest at about a quarter of the way."""


def test_a_turn_of_the_forward_surface_inside_a_leg():
    law = law_of(**TURNING)
    whole = fraction_after(law, TURNS, 0.0)
    end = law.forward_share(floats, law.scale(floats), *TURNS[1])
    assert whole > invert_hardening(floats, end, law.n_1, law.n_2) + 0.01
    for substeps in (3, 64, 200):
        assert fraction_after(law, TURNS, 0.0, substeps) == pytest.approx(whole, abs=1e-12)
    back = TURNS[::-1]
    whole = fraction_after(law, back, 0.0)
    assert fraction_after(law, back, 0.0, 64) == pytest.approx(whole, abs=1e-12)


@pytest.mark.parametrize("exponents", list(EXPONENTS.values())[1:2], ids=list(EXPONENTS)[1:2])
@pytest.mark.parametrize("leg", list(LEGS.values())[1:], ids=list(LEGS)[1:])
def test_transformation_strain_converges_with_the_cuts(exponents, leg):
    """∫H dξ: at least third order, and within a hundredth in a single step."""
    law = law_of(exponents)
    exact = oriented_after(law, leg, 0.0, 256)
    errors = [abs(oriented_after(law, leg, 0.0, cuts) - exact) for cuts in (1, 16, 64)]
    assert errors[0] < 1e-2
    assert errors[2] < 2e-8
    assert errors[2] < errors[1] / 4**3 + 1e-11


def test_at_constant_stress_the_strain_does_not_depend_on_cuts():
    law, leg = law_of(EXPONENTS["round"]), LEGS["cooling"]
    whole = oriented_after(law, leg, 0.0)
    assert oriented_after(law, leg, 0.0, 33) == pytest.approx(whole, abs=1e-14)


# ---------------------------------------------------------------- extremes, checks, the march


def test_extremes_are_finite():
    law = law_of(EXPONENTS["roundest"])
    corners = [-1e9, 0.0, 1e-300, 1e12], [0.0, 1e-300, 300.0, 1e5]
    for xi in (0.0, 0.5, 1.0):
        for stress in corners[0]:
            for kelvin in corners[1]:
                memory = law.init(floats, Fractions(xi, xi), 1e8, 320.0)
                memory, fractions = law.kinetics(floats, memory, stress, kelvin, 0.0)
                numbers = *memory, *fractions, strain_of(law, memory)
                assert all(math.isfinite(number) for number in numbers)
                assert 0.0 <= fractions.martensite <= 1.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"M_f": 320.0}, "`M_f` of `lagoudas` must be below `M_s`"),
        ({"A_f": 309.0, "A_s": 300.0}, "`M_s` of `lagoudas` must be below `A_f`"),
        ({"H_min": 0.06}, "`H_min` of `lagoudas` must not exceed `H_sat`"),
        ({"sigma_cal": 0.0}, "`sigma_cal` of `lagoudas` must be a stress at which"),
        ({"E_M": 2e11, "E_A": 1e8}, "must give an entropy difference below 0"),
        ({"n_1": 1.0, "n_2": 0.05, "n_3": 0.05, "n_4": 1.0, "A_s": 286.0}, "let them cross by"),
    ],
)
def test_impossible_parameters_are_refused(changes, words):
    with pytest.raises(ParameterError, match=words):
        law_of(**changes)


def test_narrowing_loops_are_named():
    doubt = law_of(C_A=14e6).doubt()
    assert doubt is not None
    assert "meet above" in doubt.sentence
    assert law_of(C_A=8e6, C_M=8e6).cautions() == []


def test_in_a_system_the_law_is_the_law():
    """Prescribed temperature under a dead weight: ξ and stroke are those of the bare law."""
    law = law_of()
    kelvin = [293.15, 360.0, 311.0, 337.0, 305.0, 390.0]
    run = simulate(chamber(law, mass=1.5), through(kelvin), 5.0, step=0.01, samples=6)
    stress = run["stress"][0]
    start = run["martensite_fraction"][0]
    memories = along(law, [(stress, t) for t in kelvin], start)
    assert run["martensite_fraction"] == pytest.approx([m.fraction for m in memories], abs=1e-6)
    assert len({round(m.fraction, 3) for m in memories}) > 3
    strain = np.array([strain_of(law, m) for m in memories])
    assert run["strain"][1:] == pytest.approx(strain[1:], abs=1e-7)
