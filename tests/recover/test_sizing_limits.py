"""A wire that `size` calls fit violates no limit of its material.

Source of truth: a run of the scenario that is written for it, with the limits of the element.
"""

from __future__ import annotations

import pytest

from martensite.design.sizing.candidates import size_wire
from martensite.design.sizing.request import WireRequest
from martensite.design.sizing.scenario import format_scenario
from martensite.physics.materials.wires import load_wires
from martensite.scenario.scenario import read_scenario

REQUESTS = {
    "weak and slow": {"force": 0.5, "stroke": 3e-3, "rate": 0.2, "supply": 5.0},
    "strong and long": {"force": 10.0, "stroke": 20e-3, "rate": 0.05, "supply": 12.0},
    "quick": {"force": 1.0, "stroke": 3e-3, "rate": 1.0, "supply": 12.0},
}
LIMITS = {"temperature", "stress", "strain"}


@pytest.mark.parametrize("name", list(REQUESTS))
def test_what_fits_stays_within_the_limits_of_its_element(name: str, c_compiler: str) -> None:
    sizing = size_wire(WireRequest(alloy="90", **REQUESTS[name]))
    fits = [one for one in sizing.candidates if one.feasible]
    assert fits
    for one in fits[:2]:
        run = read_scenario(format_scenario(sizing.request, one, load_wires())).run()
        assert {alarm.kind for alarm in run.alarms} & LIMITS == set(), one.size.name
