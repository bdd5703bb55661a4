"""The Tanaka law equals the independent one-page reference on thousands of random paths."""

from functools import partial

import pytest
import strip_paths
import tanaka_reference as reference
from builders import along
from strip_paths import CASES, MODULI, RULES, random_case

from martensite.physics.laws.strip_laws import Tanaka

TOLERANCE = 1e-10
followed = partial(strip_paths.followed, reference)
worst = partial(strip_paths.worst, reference, Tanaka)


def tanaka(rule, numbers):
    return Tanaka(**(MODULI | numbers), history=rule)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
@pytest.mark.parametrize("paths", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_law_equals_reference(kind, rule, paths):
    assert worst(kind, rule, paths) <= TOLERANCE


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
def test_cutting_legs_changes_nothing(kind, rule):
    """Also where three processes share a leg, and where the tail of one is all that is left."""
    found = 0.0
    for seed in range(60):
        numbers, path, xi = random_case(seed, kind)
        law = tanaka(rule, numbers)
        whole, cut = (along(law, path, xi, substeps) for substeps in (1, 17))
        found = max(found, *(abs(a.fraction - b.fraction) for a, b in zip(whole, cut, strict=True)))
    assert found <= 1e-12


OVERLAPPING = {"A_s": 330.0, "A_f": 340.0, "M_s": 320.0, "M_f": 310.0, "C_A": 20e6, "C_M": 5e6}


class TestTurnsInTheOverlap:
    """One leg along which u falls and w rises; who acts is told by ξ at its end."""

    def leg(self, u0, u1, w0, w1):
        """The end points (σ, T) at which u and w have the given values [K]."""
        stresses = [(w - u) / (1 / 5e6 - 1 / 20e6) for u, w in ((u0, w0), (u1, w1))]
        return [(s, u + s / 5e6) for s, u in zip(stresses, (u0, u1), strict=True)]

    CASES = pytest.mark.parametrize(
        ("xi", "leg", "closed"),
        [
            # forward to M_f, then reverse from w = 335 to 340
            (0.0, (320, 300, 330, 340), lambda r: 0.99 * r(5)),
            # martensite, no branch: reverse to A_f at u = 316, forward to M_f at w = 346, reverse
            (1.0, (320, 300, 336, 356), lambda r: (1 - (1 - r(4)) * r(6)) * r(10)),
            # nothing to reverse and forward past its line: the state contradicts itself and stays
            (0.0, (309, 300, 331, 339), lambda r: 0.0),
            # forward has its turn, with nothing to do, up to M_f; then reverse past its line
            (1.0, (320, 300, 341, 361), lambda r: r(10)),
        ],
    )

    @pytest.mark.parametrize("rule", RULES)
    @pytest.mark.parametrize("substeps", [1, 13, 200])
    @CASES
    def test_closed_form(self, rule, substeps, xi, leg, closed):
        found = along(tanaka(rule, OVERLAPPING), self.leg(*leg), xi, substeps)[-1].fraction
        assert found == pytest.approx(closed(lambda kelvin: 10 ** (-0.2 * kelvin)), abs=1e-12)

    @pytest.mark.parametrize("rule", RULES)
    @CASES
    def test_reference_agrees(self, rule, xi, leg, closed):
        wanted, got, _ = followed(tanaka(rule, OVERLAPPING), OVERLAPPING, rule, self.leg(*leg), xi)
        assert got == pytest.approx(wanted, abs=TOLERANCE)
