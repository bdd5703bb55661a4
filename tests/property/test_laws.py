"""What every registered law promises, on random paths: bounds, cuts, monotony, dissipation."""

from functools import cache
from itertools import pairwise
from typing import Any

import builders
import numpy as np
import pytest
from builders import along, examples, label, stepper, strain_of
from hypothesis import given, settings
from hypothesis import strategies as st

from martensite.laws.base import AbstractLaw, Fractions
from martensite.laws.liang_rogers import LiangRogers
from martensite.runtimes import floats
from martensite.runtimes.arrays import ArrayNamespace
from martensite.runtimes.dual import value_and_slope

LAWS = examples("law")
SECOND = ("lagoudas-waisted", "mas-polycrystal-constant-15-internal-stress")
"""Second forms of the laws that take longest: with the slow tests."""
EVERY = pytest.mark.parametrize(
    "law",
    [pytest.param(law, marks=[pytest.mark.slow] if label(law) in SECOND else []) for law in LAWS],
    ids=label,
)
LONG = (*SECOND, "lagoudas-smooth", "mas-polycrystal-constant-15-barriers")
"""Laws whose differences take long."""
MOST = pytest.mark.parametrize(
    "law",
    [pytest.param(law, marks=[pytest.mark.slow] if label(law) in LONG else []) for law in LAWS],
    ids=label,
)
FEW = settings(max_examples=25)

stress = st.floats(0.0, 500e6)
temperature = st.floats(270.0, 420.0)
fraction = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0))
point = st.tuples(stress, temperature)
path = st.lists(point, min_size=2, max_size=5)


def close(a, b, tolerance=1e-12):
    """Fractions agree."""
    return abs(a.martensite - b.martensite) <= tolerance and abs(a.oriented - b.oriented) <= (
        tolerance
    )


def end(law, points, xi, substeps=1, dt=1.0):
    """Fractions at the end of a path."""
    return law.fractions(along(law, points, xi, substeps, dt)[-1])


def depends_on_time(law: AbstractLaw) -> bool:
    """True for rate laws; those with a history rule must never be."""
    legs = [(0.0, 290.0), (0.0, 360.0), (300e6, 330.0), (50e6, 330.0)]
    slow, fast = (end(law, legs, 0.5, dt=dt) for dt in (1e3, 1e-3))
    return slow != fast


# ---------------------------------------------------------------- bounds, no-ops, cuts


@EVERY
@given(path, fraction)
@settings(max_examples=100)
def test_fractions_stay_in_bounds(law, points, xi):
    for memory in along(law, points, xi):
        found = law.fractions(memory)
        assert 0.0 <= found.martensite <= 1.0
        assert -1e-12 <= found.martensite - abs(found.oriented)


@EVERY
@given(path, fraction)
@FEW
def test_a_move_to_the_same_point_in_no_time_changes_nothing(law, points, xi):
    memory = along(law, points, xi)[-1]
    again, found = law.kinetics(floats, memory, *points[-1], 0.0)
    assert again == memory
    assert found == law.fractions(memory)


@EVERY
def test_laws_with_a_history_rule_do_not_read_the_clock(law):
    assert not (depends_on_time(law) and "history" in law.declarations)


def check_cuts(law, points, xi):
    whole = end(law, points, xi)
    assert close(whole, end(law, points, xi, 7))
    assert close(whole, end(law, points, xi, 100))


@EVERY
@given(path, fraction)
@FEW
def test_cutting_legs_into_substeps_changes_nothing(law, points, xi):
    if depends_on_time(law):
        pytest.skip("a rate law converges with the step instead")
    check_cuts(law, points, xi)


def test_a_law_that_depends_on_cuts_is_noticed():
    naive = builders.example(builders.PrintedFormula, history="restart")
    with pytest.raises(AssertionError):
        check_cuts(naive, builders.isobar(20, 70), 1.0)


# ---------------------------------------------------------------- strain


def strains_after(law, points, xi, celsius=None):
    """Strains after moves from the end of a path to many stresses at one temperature."""
    memory, advance = along(law, points, xi)[-1], stepper(law)
    target = memory.temperature if celsius is None else celsius
    ends = [advance(memory, sigma, target, 1.0) for sigma in np.linspace(0, 500e6, 101).tolist()]
    return np.array([strain_of(law, end) for end in ends])


@EVERY
@given(path, fraction)
@FEW
def test_strain_does_not_fall_with_stress(law, points, xi):
    assert (np.diff(strains_after(law, points, xi)) >= -1e-15).all()


@EVERY
@given(path, fraction, temperature)
@FEW
def test_strain_does_not_fall_with_stress_at_another_temperature(law, points, xi, target):
    assert (np.diff(strains_after(law, points, xi, target)) >= -1e-15).all()


# ---------------------------------------------------------------- dissipation


TAIL = 0.01
"""Martensite [-] that laws with exponential kinetics keep at their nominal finish line."""


@cache
def austenitic(law) -> float:
    """The lowest whole temperature [K] at which unloaded martensite is gone."""
    for kelvin in range(280, 480):
        if end(law, [(0.0, 250.0), (0.0, float(kelvin))], 1.0, dt=1e3).martensite <= TAIL:
            return float(kelvin)
    raise AssertionError("no austenite below 480 K")


def work(law, celsius, stresses):
    """∮ σ dε [J/m³] along an isotherm, in steps of about 2 MPa."""
    points = [(s, celsius) for s in stresses]
    memory, advance = law.init(floats, Fractions(0.0, 0.0), *points[0]), stepper(law)
    total, last_stress, last_strain = 0.0, points[0][0], strain_of(law, memory)
    for (a, t), (b, _) in pairwise(points):
        for sigma in np.linspace(a, b, 2 + int(abs(b - a) / 2e6)).tolist()[1:]:
            memory = advance(memory, sigma, t, 1.0)
            strain = strain_of(law, memory)
            total += 0.5 * (sigma + last_stress) * (strain - last_strain)
            last_stress, last_strain = sigma, strain
    return total, law.fractions(memory).martensite


@EVERY
@given(st.lists(st.floats(0.0, 500e6), min_size=1, max_size=6), st.floats(0.0, 5.0))
@FEW
def test_closed_isothermal_cycles_dissipate(law, turns, above):
    """From austenite through any turning points back to zero stress, at T > A_f."""
    total, left = work(law, austenitic(law) + 1.0 + above, [0.0, *turns, 0.0])
    assert left <= TAIL
    assert total >= -1e-6 * 500e6 * 0.1


@EVERY
def test_a_large_cycle_does_dissipate(law):
    total, _ = work(law, austenitic(law) + 2.0, [0.0, 600e6, 0.0])
    assert total > 1e5


def test_a_law_that_creates_work_is_noticed():
    """C_A far above C_M: hot loops run the wrong way round."""
    law = builders.example(LiangRogers, C_A=20e6, C_M=5e6)
    assert work(law, 380.0, [0.0, 1500e6, 0.0])[0] < -1e6


# ---------------------------------------------------------------- slopes


def differenced(function, x, h=1e-4):
    """Slope by central differences of fourth order; None near a kink or a jump."""
    near = [function(floats, x + k * h) for k in (-2, -1, 0, 1, 2)]
    second, third = (np.abs(np.diff(near, order)).max() for order in (2, 3))
    if third > 0.05 * second + 1e-13:  # of a smooth function it is smaller by h
        return None
    return (8 * (near[3] - near[1]) - (near[4] - near[0])) / (12 * h)


def random_points(rng, count):
    return [(float(rng.uniform(0, 500e6)), float(rng.uniform(270, 420))) for _ in range(count)]


def turning_stress(law, memory, kelvin, share):
    """Stress at which the answer of the law has made a share of its change, by bisection."""
    low, high, advance = 0.0, 500e6, stepper(law)

    def answer(sigma):
        return law.fractions(advance(memory, sigma, kelvin, 1.0)).oriented

    wanted = answer(low) + share * (answer(high) - answer(low))
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if answer(middle) < wanted else (low, middle)
    return high


def slopes(law, slope_of):
    """Slopes in T [1/K] and in σ [1/(10 MPa)] found by `slope_of` and by differences.

    Half of the points are where the answer is changing, which random points seldom hit in laws
    that jump.
    """
    rng, pairs = np.random.default_rng(2), []
    for turn in range(150):
        memory = along(law, random_points(rng, 3), rng.random())[-1]
        ((sigma, kelvin),) = random_points(rng, 1)
        if turn % 2:
            sigma = turning_stress(law, memory, kelvin, float(rng.uniform(0.1, 0.9)))

        def in_temperature(xp, t, memory=memory, sigma=sigma):
            return law.kinetics(xp, memory, sigma, t, 1.0)[1].oriented

        def in_stress(xp, s, memory=memory, kelvin=kelvin):
            return law.kinetics(xp, memory, s * 1e7, kelvin, 1.0)[1].oriented

        for function, x in ((in_temperature, kelvin), (in_stress, sigma / 1e7)):
            difference = differenced(function, x)
            if difference is not None:
                pairs.append((slope_of(function, x), difference))
    return np.array(pairs).T


@MOST
def test_slopes_are_those_of_finite_differences(law):
    found, wanted = slopes(law, lambda function, x: value_and_slope(floats, function, x)[1])
    assert np.sum(np.abs(wanted) > 1e-3) > 30
    assert found == pytest.approx(wanted, rel=1e-5, abs=1e-8)


def test_a_wrong_slope_is_noticed():
    found, wanted = slopes(
        LAWS[0], lambda function, x: value_and_slope(floats, function, x)[1] * (1 + 1e-4)
    )
    assert found != pytest.approx(wanted, rel=1e-5, abs=1e-8)


# ---------------------------------------------------------------- extremes


def special(law, rng, count):
    """Temperatures and stresses, a third of them absurd or on the law's own numbers."""
    own = {"K": [0.0, 1e-300, 273.15, 1e5], "Pa": [0.0, -1e9, 1e12, 1e-300, -1e-300]}
    for leaf in law.leaves():
        if leaf.declared.unit in own:
            own[leaf.declared.unit].append(leaf.value)
    absurd = rng.random((2, count)) < 1 / 3
    s = np.where(absurd[0], rng.choice(own["Pa"], count), rng.uniform(0.0, 500e6, count))
    t = np.where(absurd[1], rng.choice(own["K"], count), rng.uniform(250.0, 450.0, count))
    return s, t


@EVERY
def test_many_states_stay_finite(law):
    """Four moves from each of many states; fewer for a law of many groups, which is slow."""
    count = 8_000 if hasattr(law, "groups") else 40_000
    rng, xp = np.random.default_rng(1), ArrayNamespace(np)
    xi: Any = np.where(rng.random(count) < 0.3, rng.integers(0, 2, count), rng.random(count))
    memory = law.init(xp, Fractions(xi, xi), *special(law, rng, count))
    for dt in (1e-3, 0.0, 10.0, 1e-9):
        s, t = special(law, rng, count)
        still = rng.random(count) < 0.1
        s, t = np.where(still, memory.stress, s), np.where(still, memory.temperature, t)
        memory, fractions = law.kinetics(xp, memory, s, t, dt)
        strain = law.strain(xp, fractions, s, t)
        for number in (*memory, *fractions, strain):
            assert np.isfinite(number).all()
        assert fractions.martensite.min() >= 0.0
        assert fractions.martensite.max() <= 1.0


def test_a_law_that_divides_by_nothing_is_noticed():
    class Careless(LiangRogers):
        """0/0 at the finish lines."""

        def follow(self, xp, move, stress, temperature, dt):
            found = super().follow(xp, move, stress, temperature, dt)
            return Fractions(*(x * move.scale / move.scale for x in found))

    with pytest.raises((AssertionError, RuntimeWarning)):
        test_many_states_stay_finite(builders.example(Careless))
