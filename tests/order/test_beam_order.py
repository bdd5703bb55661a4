"""Frequencies of beam elements converge with order 4, and from above.

Source of truth: the characteristic equation; the leading error (β h)⁴/1440 of a frequency.
"""

from __future__ import annotations

import numpy as np
import pytest

from martensite.actuators.mechanics.beam_modes import CantileverBeam, beam_modes, exact_roots, solve_angular_frequencies

COUNTS = (8, 16, 32, 64)


def beam(tip_mass: float) -> CantileverBeam:
    return CantileverBeam(E=69e9, density=2700.0, width=0.038, height=0.003, length=0.32, tip_mass=tip_mass)


def errors(tip_mass: float, mode: int) -> np.ndarray:
    """Relative errors of one frequency for growing numbers of elements."""
    exact = solve_angular_frequencies(beam(tip_mass), mode)[-1]
    found = [beam_modes(beam(tip_mass), mode, count).omega[-1] for count in COUNTS]
    return np.array(found) / exact - 1.0


def orders(found: np.ndarray) -> np.ndarray:
    """Observed orders between successive halvings."""
    return np.log2(np.abs(found[:-1] / found[1:]))


@pytest.mark.parametrize("tip_mass", [0.0, 0.15])
@pytest.mark.parametrize("mode", [1, 2, 3])
def test_order_is_four(tip_mass: float, mode: int) -> None:
    found = errors(tip_mass, mode)
    assert np.all(found > 0.0)
    # with a heavy tip the first error is so small that the last halvings are near rounding
    assert orders(found)[-1] == pytest.approx(4.0, abs=0.05)


def test_leading_error() -> None:
    for mode, beta in enumerate(exact_roots(3), start=1):
        expected = (beta / COUNTS[-1]) ** 4 / 1440.0
        assert errors(0.0, mode)[-1] == pytest.approx(expected, rel=0.05)
