"""The law equals the independent one-page reference on thousands of random paths."""

from functools import partial

import liang_rogers_reference as reference
import pytest
import strip_paths
from builders import law_a
from strip_paths import CASES, RULES

from martensite.physics.laws.strip_laws import LiangRogers

TOLERANCE = 1e-10
followed = partial(strip_paths.followed, reference)
worst = partial(strip_paths.worst, reference, LiangRogers)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", CASES.values(), ids=CASES)
@pytest.mark.parametrize("paths", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_law_equals_reference(kind, rule, paths):
    assert worst(kind, rule, paths) <= TOLERANCE


@pytest.mark.parametrize("name", ["C_A", "C_M", "A_s", "A_f", "M_s", "M_f"])
def test_a_wrong_parameter_is_noticed(name):
    found = worst(0, "resume", 20, lambda p: {name: p[name] * (1 + 1e-6)})
    assert found > 1e3 * TOLERANCE


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
