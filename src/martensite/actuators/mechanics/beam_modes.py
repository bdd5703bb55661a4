"""Bending modes of a clamped beam with a tip mass, computed before a run.

An Euler–Bernoulli beam of length l, clamped at x = 0, with flexural stiffness E I, mass per length ρ A and a point mass
m at x = l,

    E I w'''' + ρ A ẅ = 0,    w = w' = 0 at 0,    w'' = 0 and E I w''' = m ẅ at l,

is cut into elements with cubic (Hermite) deflection and consistent mass. With M = L Lᵀ (Cholesky) the problem K φ = ω²
M φ becomes the symmetric problem of Lᵀ K⁻¹ L with eigenvalues 1/ω². K⁻¹ has a closed form, because cubic elements are
exact at their nodes; low modes thus do not lose digits with many elements. Each mode has unit deflection at the tip, so
that x_tip = Σ q_k and

    m_k q̈_k + k_k q_k = F_tip,    k_k = ω_k² m_k.

With the element length h and β⁴ = ω² ρ A l⁴/(E I), a frequency is too high by about (β h/l)⁴/1440. The exact β are the
roots of

    1 + cos β cosh β + (m/ρ A l) β (cos β sinh β - sin β cosh β) = 0.

Shear, rotary inertia and rotation of the tip mass are neglected: slender beams, low modes. Sign: deflection, force and
modal coordinates along the same axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

PER_MODE = 20
"""Elements per mode; all frequencies are then within 1e-6."""


class CantileverBeam(Parametrised):
    """Beam of rectangular section, clamped at one end, with a point mass at the other."""

    cites = ("kossoski2018",)

    E: Number = param("Pa", "Young's modulus", above=0.0, high=1e13)
    density: Number = param("kg/m^3", "density", above=0.0, high=1e5)
    width: Number = param("m", "width of the section, across the motion", above=0.0, high=10.0)
    height: Number = param("m", "height of the section, along the motion", above=0.0, high=10.0)
    length: Number = param("m", "length from the clamp to the tip", above=0.0, high=100.0)
    tip_mass: Number = param("kg", "mass at the tip", low=0.0, high=1e6, default=0.0)

    @property
    def second_moment(self) -> float:
        """Return the second moment of area I = b h³/12 [m⁴]."""
        return self.width * self.height**3 / 12.0

    @property
    def stiffness(self) -> float:
        """Return the tip force per tip deflection, 3 E I/l³ [N/m]."""
        return 3.0 * self.E * self.second_moment / self.length**3

    @property
    def mass(self) -> float:
        """Return the mass of the beam, ρ b h l [kg]."""
        return self.density * self.width * self.height * self.length

    @property
    def rate(self) -> float:
        """Return √(E I/(ρ A l⁴)) [rad/s]: angular frequencies are β² times this."""
        return math.sqrt(self.stiffness / (3.0 * self.mass))


@dataclass(frozen=True)
class BeamModes:
    """Lowest modes of a beam, each with unit deflection at the tip."""

    omega: tuple[float, ...]
    """Natural angular frequencies ω_k [rad/s], rising."""
    mass: tuple[float, ...]
    """Modal masses m_k [kg]."""
    stiffness: tuple[float, ...]
    """Modal stiffnesses k_k = ω_k² m_k [N/m]."""
    positions: tuple[float, ...]
    """Nodes from clamp to tip [m]."""
    shapes: tuple[tuple[float, ...], ...]
    """Deflection of each mode at the nodes, 1 at the tip [-]."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Return the natural frequencies [Hz]."""
        return tuple(omega / (2.0 * math.pi) for omega in self.omega)


def beam_modes(beam: CantileverBeam, modes: int = 3, elements: int | None = None) -> BeamModes:
    """Return the lowest modes by finite elements.

    Args:
        beam: beam with tip mass.
        modes: number of modes.
        elements: number of equal elements; by default `PER_MODE` per mode.

    Raises:
        ParameterError: there is no mode or no element, or more than two modes per element.
    """
    import numpy as np

    count = PER_MODE * modes if elements is None else elements
    _check_sizes(modes, count)
    positions = np.linspace(0.0, 1.0, count + 1)
    lower = np.linalg.cholesky(_build_masses(count, beam.tip_mass / beam.mass))
    inverse = lower.T @ _build_flexibility(positions) @ lower
    inverse_squares, vectors = np.linalg.eigh(0.5 * (inverse + inverse.T))
    lowest = slice(-1, -modes - 1, -1)
    columns = np.linalg.solve(lower.T, vectors[:, lowest])
    omega = beam.rate / np.sqrt(inverse_squares[lowest])
    masses = beam.mass / columns[-2] ** 2
    deflections = np.vstack([np.zeros(modes), columns[::2] / columns[-2]])
    return BeamModes(
        _to_tuple(omega),
        _to_tuple(masses),
        _to_tuple(omega**2 * masses),
        _to_tuple(beam.length * positions),
        tuple(map(_to_tuple, deflections.T)),
    )


def exact_roots(count: int, mass_ratio: float = 0.0) -> tuple[float, ...]:
    """Return the lowest `count` roots β of the characteristic equation, by bisection to the last digit.

    Between (k - 1) π and k π the left-hand side changes its sign for any `mass_ratio` of tip and beam; without a tip
    mass cos β cosh β = -1.
    """
    return tuple(_find_wave_number(k, mass_ratio) for k in range(1, count + 1))


def solve_angular_frequencies(beam: CantileverBeam, count: int) -> tuple[float, ...]:
    """Return the natural angular frequencies [rad/s] from the characteristic equation."""
    roots = exact_roots(count, beam.tip_mass / beam.mass)
    return tuple(beam.rate * beta * beta for beta in roots)


def _find_wave_number(k: int, ratio: float) -> float:
    low, high = (k - 1) * math.pi, k * math.pi
    rising = k % 2 == 0
    while (middle := 0.5 * (low + high)) not in (low, high):
        above = _evaluate_characteristic(middle, ratio) > 0.0
        low, high = (low, middle) if above == rising else (middle, high)
    return high


def _evaluate_characteristic(beta: float, ratio: float) -> float:
    """Return the left-hand side over cosh β, of order 1 for large β."""
    inverse = 2.0 * math.exp(-beta) / (1.0 + math.exp(-2.0 * beta))
    tip = ratio * beta * (math.cos(beta) * math.tanh(beta) - math.sin(beta))
    return inverse + math.cos(beta) + tip


def _build_flexibility(positions: Matrix) -> Matrix:
    """Return the inverse stiffness matrix [l³/(E I)]: nodal deflections, and slopes times l, without the clamp."""
    import numpy as np

    at, of = np.meshgrid(positions[1:], positions[1:], indexing="ij")
    near, far = np.minimum(at, of), np.maximum(at, of)
    slope = np.where(at < of, at * (2.0 * of - at), of * of) / 2.0
    whole = np.empty((2 * len(at), 2 * len(at)))
    whole[0::2, 0::2] = near * near * (3.0 * far - near) / 6.0
    whole[1::2, 0::2], whole[0::2, 1::2] = slope, slope.T
    whole[1::2, 1::2] = near
    return whole


def _build_masses(count: int, ratio: float) -> Matrix:
    """Return the consistent mass matrix [ρ A l] of equal elements, with the tip mass."""
    import numpy as np

    h = 1.0 / count
    near = np.array([[156.0, 22.0 * h], [22.0 * h, 4.0 * h * h]]) * h / 420.0
    far = np.array([[54.0, -13.0 * h], [13.0 * h, -3.0 * h * h]]) * h / 420.0
    signs = np.array([[1.0, -1.0], [-1.0, 1.0]])
    whole = np.zeros((2 * count + 2, 2 * count + 2))
    for first in range(0, 2 * count, 2):
        here, there = slice(first, first + 2), slice(first + 2, first + 4)
        whole[here, here] += near
        whole[here, there] += far
        whole[there, here] += far.T
        whole[there, there] += near * signs
    whole[-2, -2] += ratio
    return whole[2:, 2:]


def _check_sizes(modes: int, elements: int) -> None:
    if modes < 1 or elements < 1:
        raise ParameterError(f"Modes and elements must be at least 1, but are {modes} and {elements}.")
    if modes > 2 * elements:
        raise ParameterError(
            f"{elements} elements have {2 * elements} modes, but {modes} are asked for; "
            f"{PER_MODE} elements for each mode give frequencies within 1e-6."
        )


def _to_tuple(numbers: Any) -> tuple[float, ...]:
    return tuple(map(float, numbers))
