"""History rules in closed form: interrupted transformations, small cycles, one memory level."""

import pytest
from builders import fraction_after, isobar, law_a
from closed_forms import cold, exact, hot


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
