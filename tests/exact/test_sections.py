"""Sections of fibres: torsion, bending and the coil against closed forms of elasticity and of a plateau.

Sources of truth: Saint-Venant's torsion and Euler–Bernoulli bending, ∫ τ r dA of a shear plateau and ∫ σ y dA of a
stress plateau, and elements of one fibre.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from builders import example, example_environment, law_a, problem_a, raised_cosine
from coil_cases import COIL, TURNS, WIRE, platform_spring
from section_cases import BARS, WARM, bar, flat_law, held_at, moment_at, plateau_moment, plateau_torque, step

from martensite.actuators.elements.base import Heating
from martensite.actuators.elements.rows import Bundle
from martensite.actuators.elements.section import find_section_points
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.brinson import Brinson
from martensite.physics.laws.lagoudas import Lagoudas
from martensite.physics.laws.mas import MullerAchenbachSeelecke
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.simulate.api import simulate

R, r = 0.5e-3, 0.3e-3
E, LENGTH, WIDTH = 75e9, 0.1, 2e-3
STIFFNESS = {
    "wire": E / 3 * math.pi * R**4 / 2,
    "tube": E / 3 * math.pi * (R**4 - r**4) / 2,
    "bent ribbon": E * WIDTH * (2 * R) ** 3 / 12,
    "bent wire": E * math.pi * R**4 / 4,
    "bent tube": E * math.pi * (R**4 - r**4) / 4,
}
"""G J or E I [N m²]."""


@pytest.mark.parametrize("name", BARS)
def test_elastic_sections_are_those_of_the_textbook(name: str) -> None:
    for fibres in ("5", "20"):
        element = bar(name, fibres=fibres)
        state = element.init(floats, 0.01, WARM)
        spring = element.tangent(floats, state, 0.01)
        assert spring.free == 0.0
        assert 1.0 / spring.compliance == pytest.approx(STIFFNESS[name] / LENGTH, rel=1e-12)
        seen = element.condition(floats, state, 0.01, example_environment())
        across = (math.sqrt(3.0) if "bent" not in name else 1.0) * R
        inertia = STIFFNESS[name] / (E / 3 if "bent" not in name else E)
        assert seen.stress == pytest.approx(0.01 * across / inertia, rel=1e-12)
        assert seen.stress == pytest.approx(element.stress(floats, 0.01), rel=1e-12)
        assert element.elastic_energy(floats, state) == pytest.approx(0.5e-4 * spring.compliance, rel=1e-12)


def test_volumes_are_those_of_the_bars() -> None:
    for name in BARS:
        element = bar(name)
        assert sum(element.fibre_columns(floats)[1]) == pytest.approx(element.section() * LENGTH, rel=1e-12)
    assert bar("bent ribbon").surface() == pytest.approx(2 * (WIDTH + 2 * R) * LENGTH, rel=1e-12)


def test_points_of_the_rule_integrate_polynomials() -> None:
    for count in (5, 10, 80):
        points = find_section_points(count)
        assert points[-1][0] == 1.0 and min(w for _, w in points) > 0.0
        for power in range(min(count, 9)):
            assert sum(w * s**power for s, w in points) == pytest.approx(1.0 / (power + 1), abs=1e-13)


PLATEAU = flat_law().C_M * (WARM - flat_law().M_s + 1e-3)
"""[Pa]"""


@pytest.mark.parametrize(("name", "exact"), [("wire", plateau_torque), ("bent ribbon", plateau_moment)])
def test_a_plateau_gives_its_closed_form_with_more_fibres(name: str, exact: Any) -> None:
    """Error of the moment per that at the onset: below 1 % with 10 fibres, falling as the square of their number."""
    shares = [0.5, 1.2, 1.7, 2.6, 4.1]
    errors = {}
    for fibres in ("10", "40"):
        element = bar(name, law=flat_law(), fibres=fibres)
        lever = element.fibre_columns(floats)[0][-1]
        onset = element.compute_moments(floats)[1] * PLATEAU / lever
        found = moment_at(element, [share * PLATEAU / E / lever for share in shares])
        errors[fibres] = np.array([m / onset - exact(share) for m, share in zip(found, shares, strict=True)])
    assert abs(errors["10"][0]) < 1e-12
    assert np.abs(errors["10"]).max() < 1e-2
    assert np.abs(errors["40"]).max() < 1e-3
    assert np.abs(errors["40"]).mean() < 0.15 * np.abs(errors["10"]).mean()


def test_the_plateau_of_a_thin_tube_is_flat_and_that_of_a_wire_rises_by_a_third() -> None:
    law = flat_law(0.02)
    for inner, rise in ((0.999e-3, 1.0), (0.0, 4.0 / 3.0)):
        element = bar("wire", law=law, inner_diameter=inner, fibres="20")
        lever = element.fibre_columns(floats)[0][-1]
        onset = element.compute_moments(floats)[1] * PLATEAU / lever
        (found,) = moment_at(element, [5.0 * PLATEAU / E / lever])
        assert found / onset == pytest.approx(rise, rel=4e-3)


def test_a_thin_tube_is_one_fibre() -> None:
    """In a heated and cooled run against a spring, to 1e-9; a wall of 1e-10 of the diameter."""
    found, cold = [], example(Brinson, Theta=0.0)
    for model in ("fibres", "surface"):
        choices = {"initial_fraction": 1.0, "section_model": model, "fibres": "5", "law": cold, "latent_heat": 24e3}
        tube = bar("tube", inner_diameter=1e-3 * (1 - 1e-10), **choices)
        lever, heat = tube.fibre_columns(floats)[0][-1], tube.heat_capacity_total()
        second = tube.compute_moments(floats)[1]
        system = problem_a(
            element=tube,
            source=PowerSource(),
            environment=Environment(temperature=290.0, cooling=ConstantCooling(h=0.3 * heat / tube.surface())),
            mechanism=BiasSpring(preload=100e6 * second / lever, stiffness=5e9 * second),
        )
        run = simulate(system, raised_cosine(70.0 * heat, 16.0), 16.0, step=0.2, samples=17, runtime="floats")
        found.append([run[n] for n in ("temperature", "martensite_fraction", "stress", "strain", "resistance")])
    fibres, surface = np.array(found)
    assert np.ptp(surface[1]) > 0.9
    assert (np.abs(fibres - surface).max(axis=1) < 1e-9 * np.abs(surface).max(axis=1)).all()


# ---------------------------------------------------------------- the coil


def test_an_elastic_coil_has_the_rate_of_the_textbook_and_closes() -> None:
    spring = platform_spring(section_model="fibres", free_length=20e-3, law=law_a(modulus="austenite", Theta=0.0))
    rate = E / 3 * WIRE**4 / (8 * TURNS * COIL**3)
    spring = spring.rebuilt({"initial_fraction": 0.0})
    state = spring.init(floats, 3.0, WARM)
    assert 1.0 / spring.tangent(floats, state, 3.0).compliance == pytest.approx(rate, rel=1e-12)
    touch = (spring.solid_length() - 20e-3) * rate
    closed = spring.tangent(floats, state, touch - 1.0)
    assert closed.compliance == pytest.approx(1.0 / (rate * (1.0 + spring.contact)), rel=1e-9)
    assert spring.elongation(floats, state, touch - 1.0) == pytest.approx(
        (touch - 1.0 / (1.0 + spring.contact)) / rate, rel=1e-9
    )
    state, report = step(spring, state, lambda xp, s: touch - 1.0)
    assert report.residual == 0.0
    held = 0.5 * touch**2 / rate + (0.5 + abs(touch)) / (rate * (1.0 + spring.contact))
    assert spring.elastic_energy(floats, state) == pytest.approx(held, rel=1e-3)


# ---------------------------------------------------------------- what a section does


def test_a_bar_that_is_let_go_bears_stress_of_both_signs_and_no_moment() -> None:
    """Twinned martensite that was detwinned most at the surface: pressed there, drawn within."""
    element = bar("wire", law=example(Brinson, Theta=0.0), initial_fraction=1.0, initial_oriented=0.0)
    lever = element.fibre_columns(floats)[0][-1]
    state = element.init(floats, 0.0, 280.0)
    for e in (0.01 / lever, 0.02 / lever, 0.03 / lever):
        state, _ = step(element, state, held_at(e), 280.0)
    state, report = step(element, state, lambda xp, s: 0.0, 280.0)
    stresses = [memory.stress for memory in state.memories]
    levers, volumes = element.fibre_columns(floats)
    assert report.residual < 1e-12 and abs(state.force) < 1e-12
    assert stresses[-1] < -1e7 < 1e7 < max(stresses)
    sums = [v * w * s for v, w, s in zip(volumes, levers, stresses, strict=True)]
    assert abs(sum(sums)) < 1e-9 * sum(map(abs, sums))
    seen = element.condition(floats, state, 0.0, example_environment())
    assert seen.stress in (pytest.approx(min(stresses)), pytest.approx(max(stresses)))
    assert 0.3 < element.locate_surface(floats, state).elongation * lever / 0.03 < 1.0


LAWS = (example(Brinson), example(Lagoudas), flat_law(0.05))


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.registered_name)
def test_coarse_steps_are_solved(law: Any) -> None:
    """Heated or cooled by up to 300 K and loaded by up to several times the plateau within a step."""
    draw, around = np.random.default_rng(3), Environment(temperature=295.0, cooling=ConstantCooling(h=1.0))
    for k in range(5):
        element = bar(list(BARS)[k % len(BARS)], law=law, fibres="5", initial_fraction=float(k % 2))
        limit = element.compute_moments(floats)[1] / element.fibre_columns(floats)[0][-1]
        force = limit * draw.uniform(20e6, 300e6)
        state, heat = element.init(floats, force, 300.0), element.heat_capacity_total()
        place, soft = element.elongation(floats, state, force), element.tangent(floats, state, force).compliance
        stiff = [0.0, 0.1, 10.0][k % 3] / soft
        for _ in range(3):
            load = force * draw.uniform(0.2, 3.0)

            def pull(_: Any, s: Any, load: float = load, stiff: float = stiff, place: float = place) -> float:
                return (load + stiff * (place - s.free)) / (1.0 + stiff * s.compliance)

            wanted = draw.uniform(270.0, 420.0) - state.memories[-1].temperature
            state, report = element.advance(
                floats, state, Heating(around, PowerSource(), 0.0, wanted * heat), pull, 1.0
            )
            assert report.residual < 1e-9
            assert all(0.0 <= element.law.fractions(m).martensite <= 1.0 for m in state.memories)


# ---------------------------------------------------------------- refusals


def test_what_fibres_cannot_do_is_refused() -> None:
    cases: list[tuple[Any, str]] = [
        (lambda: bar("wire", law=example(MullerAchenbachSeelecke)), "without rates"),
        (lambda: bar("tube", inner_diameter=1e-3), "`inner_diameter` of `torsion-wire` must be below its diameter"),
        (lambda: bar("bent wire", inner_diameter=1e-4), "must be 0 unless `shape` is `tube`"),
        (lambda: platform_spring(section_model="fibres", deflection="large"), "those of flat turns"),
        (lambda: platform_spring(section_model="fibres", stress_factor="wahl"), "those of flat turns"),
        (lambda: Bundle(strand=bar("wire"), count=2), "`torsion-wire` has many"),
    ]
    for build, words in cases:
        with pytest.raises(ParameterError, match=words):
            build()
    element = bar("wire")
    with pytest.raises(ParameterError, match="not the same all over"):
        element.in_state(floats, element.init(floats, 0.0, WARM), Fractions(0.5, 0.5), 300.0, 0.0)
    assert "prefer law `brinson`" in " ".join(element.cautions())
    assert bar("wire", law=example(Brinson, Theta=0.0)).cautions() == bar("wire", section_model="surface").cautions()


# ---------------------------------------------------------------- runtimes
