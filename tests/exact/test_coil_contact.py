"""Coil springs whose turns touch: no shorter than solid, without a jump, with a kink.

Source of truth: the solid length N d, and the declared ratio of stiffnesses.
"""

from __future__ import annotations

import numpy as np
import pytest
from coil_cases import CLOSED, elongation, platform_spring, tangent


@pytest.mark.parametrize("deflection", ["small", "large"])
@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.7, 1.0])
class TestContact:
    def test_the_spring_gets_no_shorter_than_solid(self, fraction: float, deflection: str) -> None:
        spring = platform_spring(deflection=deflection, free_length=18e-3, contact=1e3)
        lengths = [18e-3 + elongation(spring, fraction, f) for f in np.linspace(-40, 20, 121)]
        assert (np.diff(lengths) > 0.0).all()
        assert CLOSED - 2e-4 < lengths[0] < CLOSED
        assert lengths[-1] > 50e-3

    def test_the_curve_has_no_jump_and_a_kink(self, fraction: float, deflection: str) -> None:
        spring = platform_spring(deflection=deflection, free_length=18e-3, contact=1e3)
        low, high = -40.0, 0.0
        for _ in range(80):
            middle = 0.5 * (low + high)
            solid = elongation(spring, fraction, middle) < CLOSED - 18e-3
            low, high = (middle, high) if solid else (low, middle)
        assert elongation(spring, fraction, high) == pytest.approx(-3e-3, abs=1e-12)
        below, above = (tangent(spring, fraction, f).compliance for f in (low - 1e-9, high + 1e-9))
        assert above / below == pytest.approx(1001.0, rel=1e-6)


def test_a_pulled_spring_knows_no_contact() -> None:
    stiff, soft = (platform_spring(contact=ratio) for ratio in (1e5, 1.0))
    for force in (0.0, 1.0, 20.0):
        assert tangent(stiff, 0.5, force) == tangent(soft, 0.5, force)
