"""The law equals the independent one-page reference on thousands of random paths."""

from collections import Counter
from functools import partial

import liang_rogers_reference as reference
import pytest
import strip_paths
from builders import ZERO, law_a
from strip_paths import CASES, RULES, random_case

from martensite.physics.laws.strip_laws import LiangRogers

TOLERANCE = 1e-10
followed = partial(strip_paths.followed, reference)
worst = partial(strip_paths.worst, reference, LiangRogers)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
@pytest.mark.parametrize("paths", [200, pytest.param(1000, marks=pytest.mark.slow)])
def test_law_equals_reference(kind, rule, paths):
    assert worst(kind, rule, paths) <= TOLERANCE


def test_random_paths_reach_everything():
    """The comparison above means something: all processes act, partly and completely."""
    seen = Counter()
    for seed in range(200):
        p, path, xi = random_case(seed, CASES["overlapping strips"])
        wanted, _, branches = followed(law_a(**p), p, "resume", path, xi)
        for before, after, branch in zip([xi, *wanted], wanted, branches, strict=False):
            seen[branch, after in (0.0, 1.0)] += before != after
    assert min(seen["F", False], seen["F", True], seen["R", False], seen["R", True]) > 50


@pytest.mark.parametrize("name", ["C_A", "C_M", "A_s", "A_f", "M_s", "M_f"])
def test_a_wrong_parameter_is_noticed(name):
    found = worst(0, "resume", 20, lambda p: {name: p[name] * (1 + 1e-6)})
    assert found > 1e3 * TOLERANCE


def test_the_wrong_rule_is_noticed():
    p, path, _ = random_case(0, 0)
    inside = [p["M_f"] + share * (p["M_s"] - p["M_f"]) for share in (0.4, 0.6, 0.3)]
    zigzag = [(0.0, 400.0), *((0.0, kelvin) for kelvin in inside)]
    wanted, got, _ = followed(law_a("restart", **p), p, "resume", zigzag, 0.0)
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
        law, numbers = law_a(rule, **vars(self.P)), vars(self.P)
        wanted, got, _ = followed(law, numbers, rule, [start, end], xi)
        assert got == pytest.approx(wanted, abs=TOLERANCE)

    def test_both_act(self):
        """Forward through its whole strip, then reverse part of the way, from nothing."""
        forward = reference.advance(self.P, "resume", reference.State(0.0, 320.0, 0.0), 515e6, 396.0)
        assert forward.branch == "R"
        assert 0.1 < forward.xi < 0.9


def test_the_reference_itself_on_a_worked_example():
    """Problem A's strips: heating 20 → 73 °C leaves ½, then cooling 73 → 47 °C adds half of it."""
    p = reference.Parameters(68 + ZERO, 78 + ZERO, 52 + ZERO, 42 + ZERO, 10e6, 8e6)
    hot = reference.advance(p, "resume", reference.State(1.0, 20 + ZERO, 0.0), 0.0, 73 + ZERO)
    assert hot.xi == pytest.approx(0.5, abs=1e-12)
    cold = reference.advance(p, "resume", hot, 0.0, 47 + ZERO)
    assert cold.xi == pytest.approx(0.75, abs=1e-12)
