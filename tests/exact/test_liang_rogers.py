"""Liang–Rogers law: its printed curves and a system. Tests of all strip laws are in `test_strip_laws`."""

import pytest
from builders import ZERO, along, chamber, isobar, law_a, through
from closed_forms import BOTH_RULES

from martensite.simulate.api import simulate


@BOTH_RULES
def test_a_chamber_run_is_the_bare_law(rule):
    """Prescribed temperature under a dead weight: ξ of the system = ξ of the law, to round-off."""
    law = law_a(rule)
    celsius = [20.0, 84.0, 60.0, 51.0, 88.0]
    run = simulate(chamber(law, mass=1.0), through([t + ZERO for t in celsius]), 4.0, step=0.01, samples=5)
    stress = run["stress"][0]
    expected = [m.fraction for m in along(law, isobar(*celsius, stress=stress), 1.0)]
    assert run["martensite_fraction"] == pytest.approx(expected, abs=1e-6)
    assert len({round(x, 3) for x in expected}) > 3
