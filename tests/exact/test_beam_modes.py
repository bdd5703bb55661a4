"""Bending modes of a cantilever: elements against the characteristic equation, and facts.

Sources of truth: roots of the characteristic equation found by scipy; β² for a tip mass equal to
the beam's, Mathematical Problems in Engineering 2017, 1568019, Table 1; matrices of the elements
by quadrature and scipy's eigenproblem; the exact mode shapes; the stiffness of 540.1 N/m that
Kossoski (2018, Table 5) prints for the aluminium beam.
"""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from scipy import integrate, linalg, optimize

from martensite.actuators.mechanics.beam_modes import (
    PER_MODE,
    CantileverBeam,
    beam_modes,
    exact_roots,
    solve_angular_frequencies,
)
from martensite.base.errors import ParameterError

RATIOS = (0.0, 0.3, 1.0, 20.0)
EQUAL = (1.557298, 16.25009, 50.89584, 105.1983, 179.2320)


def beam(ratio: float = 0.0) -> CantileverBeam:
    bare = CantileverBeam(E=69e9, density=2700.0, width=0.038, height=0.003, length=0.32)
    return bare.with_values({"tip_mass": ratio * bare.mass})


def left_hand_side(beta: float, ratio: float) -> float:
    """The characteristic equation, written without the package's scaling."""
    c, s, ch, sh = math.cos(beta), math.sin(beta), math.cosh(beta), math.sinh(beta)
    return 1.0 + c * ch + ratio * beta * (c * sh - s * ch)


def shape(beta: float) -> tuple[np.ndarray, np.ndarray]:
    """Places from 0 to 1 and the exact mode there, 1 at the tip."""
    at = np.linspace(0.0, 1.0, 20001)
    sigma = (math.cos(beta) + math.cosh(beta)) / (math.sin(beta) + math.sinh(beta))
    b = beta * at
    w = np.cosh(b) - np.cos(b) - sigma * (np.sinh(b) - np.sin(b))
    return at, w / w[-1]


def matrices(count: int, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness [E I/l³] and mass [ρ A l] of Hermite elements, integrated numerically."""
    h = 1.0 / count
    u, weights = np.polynomial.legendre.leggauss(6)
    u, weights = 0.5 * (u + 1.0), 0.5 * h * weights
    rows = [1 - 3 * u**2 + 2 * u**3, h * (u - 2 * u**2 + u**3), 3 * u**2 - 2 * u**3, h * (u**3 - u**2)]
    bends = [-6 + 12 * u, h * (-4 + 6 * u), 6 - 12 * u, h * (6 * u - 2)]
    n, b = np.array(rows), np.array(bends) / h**2
    stiffness, mass = np.zeros((2, 2 * count + 2, 2 * count + 2))
    for k in range(count):
        place = slice(2 * k, 2 * k + 4)
        stiffness[place, place] += (b * weights) @ b.T
        mass[place, place] += (n * weights) @ n.T
    mass[-2, -2] += ratio
    return stiffness[2:, 2:], mass[2:, 2:]


# ---------------------------------------------------------------- frequencies


def test_stiffness_of_the_published_beam() -> None:
    assert beam().stiffness == pytest.approx(540.1, abs=0.05)
    assert beam().second_moment == pytest.approx(8.55e-11)
    assert beam().mass == pytest.approx(0.098496)


@pytest.mark.parametrize("ratio", RATIOS)
def test_roots(ratio: float) -> None:
    for k, beta in enumerate(exact_roots(5, ratio)):
        low = max(k * math.pi, 1e-9)
        found = optimize.brentq(left_hand_side, low, (k + 1) * math.pi, args=(ratio,), xtol=1e-14)
        assert beta == pytest.approx(found, rel=1e-12)


def test_roots_that_are_known() -> None:
    assert exact_roots(3) == pytest.approx((1.8751040687, 4.6940911330, 7.8547574382), rel=1e-10)
    squares = [beta**2 for beta in exact_roots(5, 1.0)]
    assert squares == pytest.approx(EQUAL, rel=1e-6)
    assert exact_roots(300)[-1] == pytest.approx(299.5 * math.pi)  # nothing overflows


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("modes", [1, 3, 12])
def test_frequencies(ratio: float, modes: int) -> None:
    found = beam_modes(beam(ratio), modes)
    assert found.omega == pytest.approx(solve_angular_frequencies(beam(ratio), modes), rel=1e-6)
    assert found.omega[0] == pytest.approx(solve_angular_frequencies(beam(ratio), 1)[0], rel=1e-7)
    assert found.frequencies[0] == found.omega[0] / (2.0 * math.pi)


@pytest.mark.parametrize("ratio", RATIOS)
def test_elements_are_those_of_the_textbook(ratio: float) -> None:
    """The inverse stiffness that is written down belongs to the elements, as does their mass."""
    squares = linalg.eigh(*matrices(7, ratio), eigvals_only=True)
    found = beam_modes(beam(ratio), 14, 7)
    assert np.square(found.omega) / beam().rate ** 2 == pytest.approx(squares, rel=1e-8)


# ---------------------------------------------------------------- modal mass and stiffness


@pytest.mark.parametrize("ratio", RATIOS)
def test_shapes_and_modal_masses(ratio: float) -> None:
    found = beam_modes(beam(ratio), 3)
    assert len(found.positions) == 3 * PER_MODE + 1
    for k, beta in enumerate(exact_roots(3, ratio)):
        at, w = shape(beta)
        exact = np.interp(np.array(found.positions) / 0.32, at, w)
        assert np.array(found.shapes[k]) == pytest.approx(exact, abs=2e-6 * np.abs(exact).max())
        assert found.shapes[k][-1] == 1.0
        mass = beam().mass * (integrate.simpson(w * w, x=at) + ratio)
        assert found.mass[k] == pytest.approx(mass, rel=1e-5)
        assert found.stiffness[k] == found.omega[k] ** 2 * found.mass[k]


@pytest.mark.parametrize("ratio", RATIOS)
def test_all_modes_together_are_as_soft_as_the_beam(ratio: float) -> None:
    """A force at the tip deflects every mode by F/k_k; elements are exact for it."""
    found = beam_modes(beam(ratio), 20, 10)
    assert sum(1.0 / k for k in found.stiffness) == pytest.approx(1.0 / beam().stiffness, rel=1e-9)


# ---------------------------------------------------------------- refusals


def test_what_is_refused() -> None:
    with pytest.raises(ParameterError, match="4 modes, but 5 are asked for"):
        beam_modes(beam(), 5, 2)
    with pytest.raises(ParameterError, match="at least 1"):
        beam_modes(beam(), 0)
    with pytest.raises(ParameterError, match="`height`"):
        CantileverBeam(E=69e9, density=2700.0, width=0.038, height=0.0, length=0.32)


def test_import_is_light() -> None:
    code = "import sys, martensite.actuators.mechanics.beam_modes; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
