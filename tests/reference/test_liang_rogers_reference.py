"""The law equals the independent one-page reference on thousands of random paths."""

from collections import Counter

import liang_rogers_reference as reference
import numpy as np
import pytest
from builders import ZERO, law_a

from martensite.laws.base import Fractions
from martensite.runtimes import floats

TOLERANCE = 1e-10
RULES = ("resume", "restart")
CASES = {"usual": 0, "equal slopes": 1, "overlapping strips": 2, "A_s below M_s": 3}
TOP = 600e6


def random_parameters(rng, kind):
    """Temperatures at zero stress, and slopes; `kind` chooses how the strips lie."""
    M_f = rng.uniform(280, 300)
    M_s = M_f + rng.uniform(2, 25)
    A_s = rng.uniform(M_f - 5, M_s) if kind == 3 else M_s + rng.uniform(0, 20)
    A_f = A_s + rng.uniform(2, 25)
    C_M = rng.uniform(3e6, 12e6)
    C_A = {0: C_M * rng.uniform(0.5, 1.0), 1: C_M}.get(kind, C_M * rng.uniform(1.0, 3.0))
    return reference.Parameters(A_s, A_f, M_s, M_f, C_A, C_M)


def random_path(rng, p, points=9):
    """(σ, T) points; legs at constant σ, T, u or w, and points exactly on strip lines, included."""
    lines = [(line, p.C_M) for line in (p.M_s, p.M_f)] + [(line, p.C_A) for line in (p.A_s, p.A_f)]
    path = []
    for _ in range(points):
        sigma = float(rng.uniform(0, TOP) * (rng.random() > 0.2))
        T = float(rng.uniform(p.M_f - 20, p.A_f + sigma / p.C_M + 20))
        kind = rng.integers(10)
        if path and kind == 0:
            sigma = path[-1][0]
        if path and kind == 1:
            T = path[-1][1]
        if path and kind in (2, 3):
            C = p.C_M if kind == 2 else p.C_A
            T = path[-1][1] + (sigma - path[-1][0]) / C
        if kind == 4:
            line, C = lines[rng.integers(4)]
            T = line + sigma / C
        path.append((sigma, T))
    return path


def followed(p, rule, path, xi, law=None):
    """ξ after every leg by the reference and by the law, and how often processes acted."""
    law = law or law_a(rule, **vars(p))
    sigma, T = path[0]
    state, memory = reference.State(xi, T, sigma), law.init(floats, Fractions(xi, xi), sigma, T)
    wanted, found, branches = [], [], []
    for sigma, T in path[1:]:
        state = reference.advance(p, rule, state, sigma, T)
        memory, fractions = law.kinetics(floats, memory, sigma, T, 0.0)
        wanted.append(state.xi)
        found.append(fractions.martensite)
        branches.append(state.branch)
    return wanted, found, branches


def random_case(seed, kind):
    rng = np.random.default_rng(seed)
    p = random_parameters(rng, kind)
    xi = float(rng.choice([0.0, 1.0, rng.random()]))
    return p, random_path(rng, p), xi


def worst(kind, rule, count, change=None):
    """Largest difference over `count` random paths; `change` perturbs the law's parameters."""
    found = 0.0
    for seed in range(count):
        p, path, xi = random_case(seed, kind)
        law = law_a(rule, **(vars(p) | (change(p) if change else {})))
        wanted, got, _ = followed(p, rule, path, xi, law)
        found = max(found, *(abs(a - b) for a, b in zip(wanted, got, strict=True)))
    return found


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
def test_law_equals_reference(kind, rule):
    assert worst(kind, rule, 1000) <= TOLERANCE


def test_random_paths_reach_everything():
    """The comparison above means something: all processes act, partly and completely."""
    seen = Counter()
    for seed in range(200):
        p, path, xi = random_case(seed, CASES["overlapping strips"])
        wanted, _, branches = followed(p, "resume", path, xi)
        for before, after, branch in zip([xi, *wanted], wanted, branches, strict=False):
            seen[branch, after in (0.0, 1.0)] += before != after
    assert min(seen["F", False], seen["F", True], seen["R", False], seen["R", True]) > 50


@pytest.mark.parametrize("name", ["C_A", "C_M", "A_s", "A_f", "M_s", "M_f"])
def test_a_wrong_parameter_is_noticed(name):
    found = worst(0, "resume", 20, lambda p: {name: getattr(p, name) * (1 + 1e-6)})
    assert found > 1e3 * TOLERANCE


def test_the_wrong_rule_is_noticed():
    p, path, _ = random_case(0, 0)
    zigzag = [(0.0, 400.0), *((0.0, p.M_f + share * (p.M_s - p.M_f)) for share in (0.4, 0.6, 0.3))]
    wanted, got, _ = followed(p, "resume", zigzag, 0.0, law_a("restart", **vars(p)))
    assert abs(wanted[-1] - got[-1]) > 0.01
    assert path


class TestTwoProcessesInOneLeg:
    """In the overlap one straight leg may hold a whole process and a part of the other."""

    P = reference.Parameters(327.0, 349.0, 314.0, 299.0, 10.5e6, 5.2e6)

    @pytest.mark.parametrize("rule", RULES)
    @pytest.mark.parametrize(
        ("xi", "start", "end"),
        [
            (0.0, (0.0, 320.0), (515e6, 396.0)),  # nothing to reverse before: forward, then reverse
            (1.0, (0.0, 335.0), (515e6, 400.0)),
            (1.0, (0.0, 348.0), (400e6, 388.0)),  # nothing to form before: reverse, then forward
            (0.5, (0.0, 335.0), (600e6, 420.0)),
        ],
    )
    def test_law_equals_reference(self, rule, xi, start, end):
        wanted, got, _ = followed(self.P, rule, [start, end], xi)
        assert got == pytest.approx(wanted, abs=TOLERANCE)

    def test_both_act(self):
        """Forward through its whole strip, then reverse part of the way, from nothing."""
        forward = reference.advance(
            self.P, "resume", reference.State(0.0, 320.0, 0.0), 515e6, 396.0
        )
        assert forward.branch == "R"
        assert 0.1 < forward.xi < 0.9


def test_the_reference_itself_on_a_worked_example():
    """Problem A's strips: heating 20 → 73 °C leaves ½, then cooling 73 → 47 °C adds half of it."""
    p = reference.Parameters(68 + ZERO, 78 + ZERO, 52 + ZERO, 42 + ZERO, 10e6, 8e6)
    hot = reference.advance(p, "resume", reference.State(1.0, 20 + ZERO, 0.0), 0.0, 73 + ZERO)
    assert hot.xi == pytest.approx(0.5, abs=1e-12)
    cold = reference.advance(p, "resume", hot, 0.0, 47 + ZERO)
    assert cold.xi == pytest.approx(0.75, abs=1e-12)
