"""Elahinia–Ashrafiuon law: kinetics and strain against the one-page references."""

from functools import partial
from itertools import pairwise
from typing import Any

import elahinia_reference
import liang_rogers_reference as kinetics
import numpy as np
import pytest
import strip_paths
from builders import LAW_A, ZERO, along, strain_of
from strip_paths import CASES, RULES, random_case

from martensite.physics.laws.strip_laws import Elahinia

NUMBERS: dict[str, Any] = LAW_A
worst = partial(strip_paths.worst, kinetics, Elahinia)
SOLID = elahinia_reference.Solid(**{n: LAW_A[n] for n in ("E_A", "E_M", "eps_L", "Theta", "T_ref")})
STRIPS = kinetics.Parameters(**{n: LAW_A[n] for n in kinetics.Parameters.__dataclass_fields__})
LOOP = [(s * 1e6, t + ZERO) for s, t in [(0, 90), (400, 90), (150, 70), (0, 70), (0, 90)]]


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
def test_fractions_equal_reference(kind, rule):
    assert worst(kind, rule, 100) <= 1e-10


@pytest.mark.parametrize("rule", RULES)
def test_strains_equal_reference(rule):
    for seed in range(200):
        numbers, path, xi = random_case(seed, CASES["usual"])
        law = Elahinia(**(LAW_A | numbers), history=rule)
        for memory in along(law, path, xi):
            wanted = SOLID.strain(memory.fraction, memory.stress, memory.temperature)
            assert strain_of(law, memory) == pytest.approx(wanted, rel=1e-13, abs=1e-17)


def rows(points, xi, cuts):
    """(ξ, σ, T) along a path by the reference kinetics."""
    state = kinetics.State(xi, points[0][1], points[0][0])
    found = [(xi, *points[0])]
    for start, end in pairwise(points):
        for point in np.linspace(start, end, cuts + 1)[1:].tolist():
            state = kinetics.advance(STRIPS, "resume", state, *point)
            found.append((state.xi, *point))
    return found


def test_integrated_form_is_the_integral_of_the_full_rate_form():
    law = Elahinia(**NUMBERS)
    start = strain_of(law, along(law, LOOP, 0.0)[0])
    errors = []
    for cuts in (500, 1000):
        path = rows(LOOP, 0.0, cuts)
        found = SOLID.strains(path, start)[::cuts]
        wanted = [strain_of(law, m) for m in along(law, LOOP, 0.0)]
        errors.append(np.abs(found - wanted).max())
    assert errors[1] < 4e-7
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)  # of second order
    assert max(xi for xi, _, _ in path) == 1.0


@pytest.mark.parametrize("xi", [0.0, 0.4, 1.0])
def test_elastic_loops_close(xi):
    """Between the strips nothing transforms, whatever the loop in stress and temperature."""
    law = Elahinia(**NUMBERS)
    points = [(s * 1e6, t + ZERO) for s, t in [(0, 60), (60, 62), (20, 69), (0, 55), (0, 60)]]
    memories = along(law, points, xi, substeps=10)
    assert [m.fraction for m in memories] == [xi] * 5
    assert strain_of(law, memories[-1]) == strain_of(law, memories[0])
    E = law.young(law.fractions(memories[0]))
    assert E == law.E_A + xi * (law.E_M - law.E_A)
    change = strain_of(law, memories[0]._replace(stress=1e6)) - strain_of(law, memories[0])
    assert change == pytest.approx(1e6 / E, rel=1e-9)
