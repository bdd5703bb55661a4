"""The law equals the independent one-page reference on thousands of random paths."""

from itertools import pairwise

import brinson_reference as reference
import numpy as np
import pytest
from builders import example

from martensite.kernels import floats
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.brinson import Brinson

TOLERANCE = 1e-9
RULES = ("resume", "restart")
CASES = {"C_A below C_M": 0, "equal": 1, "overlap": 2, "A_s below M_s": 3, "both below": 4}
TOP = 600e6


def random_parameters(rng, kind):
    """Temperatures at zero stress, slopes and stresses; `kind` says how the strips lie."""
    M_f = rng.uniform(280, 300)
    M_s = M_f + rng.uniform(2, 25)
    A_s = rng.uniform(M_f - 20, M_s) if kind >= 3 else M_s + rng.uniform(0, 20)
    C_M = rng.uniform(3e6, 12e6)
    slope = {0: rng.uniform(0.4, 1.0), 1: 1.0, 4: rng.uniform(0.2, 0.9)}
    sigma_s = rng.uniform(10e6, 120e6)
    return reference.Parameters(
        A_s,
        A_s + rng.uniform(2, 25),
        M_s,
        M_f,
        C_M * slope.get(kind, rng.uniform(1.0, 3.0)),
        C_M,
        sigma_s,
        sigma_s + rng.uniform(10e6, 100e6),
    )


def random_point(rng, p):
    """A (σ, T) anywhere, or in the part of the plane where most lines are."""
    sigma = float(rng.uniform(0, TOP) * (rng.random() > 0.2))
    if rng.random() < 0.4:
        sigma = float(rng.uniform(0, 1.1 * p.sigma_f))
    low, high = min(p.M_f, p.A_s), max(p.A_f, p.M_s)
    if rng.random() < 0.6:
        return sigma, float(rng.uniform(low - 20, high + sigma / p.C_M + 20))
    return sigma, float(rng.uniform(low - 5, high + 5))


def random_path(rng, p, points=9):
    """Points with legs at constant σ, T, u, w and points exactly on every line included."""
    path = []
    for _ in range(points):
        sigma, T = random_point(rng, p)
        kind = rng.integers(14)
        if path and kind < 4:
            last_sigma, last_T = path[-1]
            sigma = last_sigma if kind == 0 else sigma
            per_slope = {1: 0.0, 2: 1 / p.C_M, 3: 1 / p.C_A}.get(kind)
            T = T if per_slope is None else last_T + (sigma - last_sigma) * per_slope
        if kind == 4:
            T = float(rng.choice([p.M_s, p.M_f]))
        if kind == 5:
            T = float(rng.choice([p.A_s, p.A_f])) + sigma / p.C_A
        if kind in (6, 7):
            sigma = float(rng.choice([p.sigma_s, p.sigma_f]))
            T = min(T, p.M_s) if kind == 6 else T
            sigma += p.C_M * max(T - p.M_s, 0)
        path.append((sigma, T))
    return path


def random_start(rng):
    """(ξ_S, ξ_T): austenite, one kind of martensite, both, or a mixture of all three."""
    a, b = float(rng.random()), float(rng.random())
    return [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (a, 1.0 - a), (a, b * (1.0 - a))][rng.integers(5)]


def random_case(seed, kind):
    rng = np.random.default_rng(seed)
    p = random_parameters(rng, kind)
    return p, random_path(rng, p), random_start(rng)


def cut(path, substeps):
    """The same path with more points on its legs."""
    points = [path[0]]
    for (s0, t0), (s1, t1) in pairwise(path):
        shares = [k / substeps for k in range(1, substeps)]
        points += [(s0 + x * (s1 - s0), t0 + x * (t1 - t0)) for x in shares]
        points.append((s1, t1))
    return points


def referred(p, rule, path, start):
    """States of the reference after every leg."""
    states = [reference.State(start[0], start[1], path[0][1], path[0][0])]
    for sigma, T in path[1:]:
        states.append(reference.advance(p, rule, states[-1], sigma, T))
    return states


def followed(p, rule, path, start, substeps=1, **changes):
    """(ξ_S, ξ_T) of the law after every leg; bounds are checked on the way."""
    law = example(Brinson, history=rule, **(vars(p) | changes))
    memory = law.init(floats, Fractions(start[0] + start[1], start[0]), *path[0])
    found = []
    for sigma, T in cut(path, substeps)[1:]:
        memory, (martensite, oriented) = law.kinetics(floats, memory, sigma, T, 0.0)
        assert 0.0 <= oriented <= martensite <= 1.0
        found.append((oriented, martensite - oriented))
    return np.array(found[substeps - 1 :: substeps])


def worst(kind, rule, count, change=None):
    """Largest difference over random paths; `change` perturbs the parameters of the law."""
    found = 0.0
    for seed in range(count):
        p, path, start = random_case(seed, kind)
        got = followed(p, rule, path, start, **(change(p) if change else {}))
        wanted = [(s.xi_S, s.xi_T) for s in referred(p, rule, path, start)[1:]]
        found = max(found, np.abs(got - wanted).max())
    return found


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
def test_law_equals_reference(kind, rule):
    assert worst(kind, rule, 120) <= TOLERANCE


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
@pytest.mark.parametrize("paths", [3, pytest.param(15, marks=pytest.mark.slow)])
def test_cuts_change_nothing(kind, rule, paths):
    for seed in range(paths):
        p, path, start = random_case(1000 + seed, kind)
        whole = followed(p, rule, path, start)
        for substeps in (3, 40):
            parts = followed(p, rule, path, start, substeps)
            assert np.abs(parts - whole).max() <= 1e-12


# ---------------------------------------------------------------- several processes in one leg


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(
    ("start", "leg"),
    [
        ((0.0, 1.0), [(74.3e6, 311.8), (3.5e6, 286.4)]),
        ((0.58, 0.08), [(70e6, 311.0), (3e6, 287.5)]),
        ((0.0, 0.0), [(74.3e6, 311.8), (3.5e6, 286.4)]),
    ],
)
def test_three_processes_in_one_leg(rule, start, leg):
    """Cooling and unloading with A_s far below M_s: S, then reverse, then T."""
    p = reference.Parameters(272.0, 276.3, 302.7, 287.4, 1.49e6, 3.43e6, 31.2e6, 57.5e6)
    wanted = [(s.xi_S, s.xi_T) for s in referred(p, rule, leg, start)[1:]]
    assert followed(p, rule, leg, start) == pytest.approx(np.array(wanted), abs=TOLERANCE)


# ---------------------------------------------------------------- the formulas of 1993


class TestDualRegion:
    """M_f < T < M_s and σ_s < σ < σ_f, cooled and loaded: the published sum is inadmissible."""

    P = reference.Parameters(307.65, 322.15, 291.55, 282.15, 13.8e6, 8e6, 100e6, 170e6)

    def both(self, start, share_S, share_T):
        """The literal sum, the reference and the law, from the corner of the region."""
        p = self.P
        sigma = p.sigma_s + share_S * (p.sigma_f - p.sigma_s)
        T = p.M_s - share_T * (p.M_s - p.M_f)
        leg = [(p.sigma_s, p.M_s), (sigma, T)]
        state = referred(p, "resume", leg, start)[-1]
        law = followed(p, "resume", leg, start)[-1]
        literal = reference.literal_sum(p, start[0], start[1], sigma, T)
        return literal, state.xi_S + state.xi_T, law.sum()

    def test_the_literal_sum_reaches_two(self):
        """From austenite to the far corner: all of it counted once as ξ_S and once as ξ_T."""
        literal, state, law = self.both((0.0, 0.0), 1.0, 1.0)
        assert literal == pytest.approx(2.0, abs=1e-12)
        assert state == law == 1.0

    def test_from_a_mixed_start_too(self):
        """½ of everything formed by each: 1.150 from (0.3, 0.3), where 0.9 is admissible."""
        literal, state, law = self.both((0.3, 0.3), 0.5, 0.5)
        assert literal == pytest.approx(0.65 + 0.3 - 0.15 + 0.35, abs=1e-12)
        assert state == pytest.approx(1.0 - 0.4 / 4, abs=1e-12)
        assert law == pytest.approx(state, abs=1e-12)

    def test_the_corrected_sum_never_exceeds_one(self):
        rng = np.random.default_rng(1)
        exceeded = 0
        for _ in range(300):
            xi_S, xi_T = (float(x) for x in rng.dirichlet([1, 1, 1])[:2])
            literal, state, law = self.both((xi_S, xi_T), *rng.random(2).tolist())
            assert state <= 1.0
            assert law == pytest.approx(state, abs=1e-12)
            exceeded += literal > 1.0
        assert exceeded > 50

    def test_each_formula_alone_agrees(self):
        """By stress alone or by cooling alone the published curves are right."""
        p = self.P
        literal, state, _ = self.both((0.3, 0.3), 0.6, 0.0)
        assert literal == pytest.approx(state, abs=1e-12)
        cooled = reference.literal_sum(p, 0.0, 0.3, p.sigma_s, 0.5 * (p.M_s + p.M_f))
        found = self.both((0.0, 0.3), 0.0, 0.5)[1]
        assert cooled == pytest.approx(found, abs=1e-12)
