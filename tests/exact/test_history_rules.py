"""History rules in closed form: interrupted transformations, small cycles, one memory level."""

from itertools import pairwise

import numpy as np
import pytest
from builders import PrintedFormula, along, fraction_after, isobar, law_a
from closed_forms import BOTH_RULES, cold, exact, hot

from martensite.kernels import floats
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.strip_laws import LiangRogers


class TestInterruptedTransformations:
    """ξ at the last point, zero stress; the numbers were computed for this project."""

    CASES = pytest.mark.parametrize(
        ("path", "xi", "rule", "printed", "closed"),
        [
            ((20, 73, 71, 74), 1.0, "resume", 0.3455, hot(74)),
            ((20, 73, 71, 74), 1.0, "restart", 0.2176, hot(73) * hot(74) / hot(71)),
            ((100, 46, 49, 45), 0.0, "resume", 0.7939, 1 - cold(45)),
            ((100, 46, 49, 45), 0.0, "restart", 0.9103, 1 - cold(46) * cold(45) / cold(49)),
            ((100, 46, 60, 44), 0.0, "resume", 0.9045, 1 - cold(44)),
            ((100, 46, 60, 44), 0.0, "restart", 0.9670, 1 - cold(46) * cold(44)),
        ],
    )

    @CASES
    @pytest.mark.parametrize("substeps", [1, 30])
    def test_table(self, path, xi, rule, printed, closed, substeps):
        found = fraction_after(law_a(rule), isobar(*path), xi, substeps)
        assert found == exact(closed)
        assert round(found, 4) == printed

    @pytest.mark.parametrize(
        ("high", "low", "resume", "restart"), [(74, 72, 0.3455, 0.0), (73.2, 72.8, 0.4686, 0.0010)]
    )
    def test_fifty_small_cycles(self, high, low, resume, restart):
        path = isobar(20, high, *[low, high] * 49)  # heated to `high` fifty times
        stays = fraction_after(law_a("resume"), path, 1.0)
        ratchets = fraction_after(law_a("restart"), path, 1.0)
        assert (round(stays, 4), round(ratchets, 4)) == (resume, restart)
        assert stays == exact(hot(high))
        assert ratchets == exact(hot(high) * (hot(high) / hot(low)) ** 49)

    @BOTH_RULES
    def test_no_jumps(self, rule):
        """ξ is continuous: no step of 0.1 K moves it further than the steepest curve does."""
        path = isobar(20, 73, 71, 74, 45.5, 48, 44, 75)
        law, fractions = law_a(rule), [1.0]
        memory = law.init(floats, Fractions(1.0, 1.0), *path[0])
        for (_, a), (_, b) in pairwise(path):
            for temperature in np.linspace(a, b, round(10 * abs(b - a)) + 1).tolist()[1:]:
                memory, now = law.kinetics(floats, memory, 0.0, temperature, 0.0)
                fractions.append(now.martensite)
        assert np.abs(np.diff(fractions)).max() == pytest.approx(0.016, abs=5e-4)

    @BOTH_RULES
    def test_memory_has_one_level(self, rule):
        """Inner loops 74 ↔ 47 °C do not close: each reversal anchors at the fraction it finds."""
        path = isobar(20, *[74, 47] * 4)
        found = [m.fraction for m in along(law_a(rule), path, 1.0)][1::2]
        assert found == pytest.approx([0.346, 0.232, 0.213, 0.210], abs=6e-4)
        xi, expected = 1.0, []
        for _ in range(4):
            expected.append(hot(74) * xi)
            xi = 1 - cold(47) * (1 - expected[-1])
        assert found == [exact(x) for x in expected]


def test_the_printed_formula_with_refreshed_start_is_noticed():
    law = PrintedFormula(**{n: getattr(law_a("restart"), n) for n in LiangRogers.declarations})
    assert fraction_after(law, isobar(20, 73), 1.0) == exact(hot(73))
    assert abs(fraction_after(law, isobar(20, 73), 1.0, substeps=50) - hot(73)) > 0.1
    assert abs(fraction_after(law, isobar(20, 73, 71, 74), 1.0) - hot(74)) > 0.1
