"""Elastic close-coiled helix as a sector of a torus: two solutions that share no discretisation.

Section radius 1, coil radius C (the spring index), shear modulus 1, deflection 1 per radian of
coil. Coordinates (r, z), section centred at r = C. The stress function ψ fulfils

    ψ_rr - (3/r) ψ_r + ψ_zz = 2/C²,     ψ = 0 on the boundary,
    τ_θz = -(C/r)² ψ_r,   τ_θr = (C/r)² ψ_z,   F = ∫ τ_θz dA = -2 C² ∫ ψ/r³ dA

(Göhner's problem). The operator is r³ ∇·(r⁻³ ∇ψ), so that ψ makes ∫ r⁻³ (|∇ψ|²/2 + 2ψ/C²) dA
least. `ritz` does that with polynomials; `collocated` puts the differential equation itself to
Chebyshev points in radius and Fourier points in angle (Trefethen's disk grid). Thin-coil values
are F = π/(2 C³) and a stress 2 F C/π at the section's rim; factors are relative to these.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, legendre


class Factors(NamedTuple):
    """Ratios to the thin-coil formulas."""

    stiffness: float
    peak_stress: float
    """Stress at the inner fibre, on 8FD/(πd³)."""


def factors(force: float, slope: float, index: float) -> Factors:
    """From the force, and from ψ_r at the inner fibre."""
    inner = -slope * (index / (index - 1.0)) ** 2
    return Factors(force * 2.0 * index**3 / math.pi, inner * math.pi / (2.0 * force * index))


def ritz(index: float, degree: int = 24) -> Factors:
    """Polynomials of a total degree, even in z, times the bubble 1 - x² - z²."""
    nodes, weights = legendre.leggauss(2 * degree + 10)
    radii, angles = 0.5 * (nodes + 1.0), np.pi * (nodes + 1.0)
    rho, theta = np.meshgrid(radii, angles, indexing="ij")
    area = np.outer(0.5 * weights * radii, np.pi * weights)
    x, z = rho * np.cos(theta), rho * np.sin(theta)
    values, dx, dz = bubbles(x, z, degree)
    weight = area / (index + x) ** 3
    scale = np.sqrt(weight).ravel()
    rows = np.hstack([scale * d.reshape(len(values), -1) for d in (dx, dz)])
    triangle: Any = np.linalg.qr(rows.T, mode="r")  # the matrix of the problem is its square
    load = -2.0 / index**2 * np.einsum("irt,rt->i", values, weight)
    found = np.linalg.solve(triangle, np.linalg.solve(triangle.T, load))
    force = float(-2.0 * index**2 * found @ np.einsum("irt,rt->i", values, weight))
    slope = bubbles(np.array([[-1.0]]), np.array([[0.0]]), degree)[1]
    return factors(force, float(found @ slope[:, 0, 0]), index)


def bubbles(x: Any, z: Any, degree: int) -> tuple[Any, Any, Any]:
    """Values and both slopes of the trial functions at points."""
    bubble, found = 1.0 - x * x - z * z, []
    for i in range(degree + 1):
        for j in range(0, degree + 1 - i, 2):
            p, q = (chebyshev.Chebyshev.basis(n) for n in (i, j))
            a, b, da, db = p(x), q(z), p.deriv()(x), q.deriv()(z)
            slopes = -2.0 * x * a * b + bubble * da * b, -2.0 * z * a * b + bubble * a * db
            found.append((bubble * a * b, *slopes))
    return tuple(np.array(column) for column in zip(*found, strict=True))  # type: ignore[return-value]


def chebyshev_matrix(n: int) -> tuple[Any, Any]:
    """Differentiation matrix on n + 1 Chebyshev points cos(πk/n), and the points."""
    points = np.cos(np.pi * np.arange(n + 1) / n)
    ends = np.where((np.arange(n + 1) % n) == 0, 2.0, 1.0) * (-1.0) ** np.arange(n + 1)
    gaps = points[:, None] - points[None, :] + np.eye(n + 1)
    matrix = np.outer(ends, 1.0 / ends) / gaps
    return matrix - np.diag(matrix.sum(axis=1)), points


def fourier_matrices(m: int) -> tuple[Any, Any]:
    """First and second derivative on m equal angles, m even."""
    waves = np.fft.fftfreq(m, 1.0 / m)
    identity = np.eye(m)
    first = np.where(np.abs(waves) == m // 2, 0.0, 1j * waves)
    derivatives = [np.fft.ifft(f[:, None] * np.fft.fft(identity, axis=0), axis=0).real for f in (first, -waves * waves)]
    return derivatives[0], derivatives[1]


def collocated(index: float, n: int = 31, m: int = 40) -> Factors:
    """The differential equation at the points of a polar grid; n odd."""
    d1, points = chebyshev_matrix(n)
    d2, half = d1 @ d1, (n + 1) // 2
    rho, inside = points[1:half], slice(1, half)
    mirror = slice(n - 1, half - 1, -1)
    turn = np.roll(np.eye(m), m // 2, axis=0)
    first, second = fourier_matrices(m)
    angle = 2.0 * np.pi * np.arange(m) / m

    def radial(matrix: Any) -> Any:
        return np.kron(matrix[inside, inside], np.eye(m)) + np.kron(matrix[inside, mirror], turn)

    by_rho = radial(d1)
    over_rho = np.kron(np.diag(1.0 / rho), np.eye(m))
    laplace = radial(d2) + over_rho @ by_rho + np.kron(np.diag(rho**-2.0), second)
    cosine, sine = np.tile(np.cos(angle), half - 1), np.tile(np.sin(angle), half - 1)
    by_r = cosine[:, None] * by_rho - sine[:, None] * (over_rho @ np.kron(np.eye(half - 1), first))
    r = index + np.repeat(rho, m) * cosine
    psi = np.linalg.solve(laplace - (3.0 / r)[:, None] * by_r, np.full(r.size, 2.0 / index**2))
    rim = d1[0, inside, None] * psi.reshape(half - 1, m)
    rim = rim + d1[0, mirror, None] * (psi.reshape(half - 1, m) @ turn.T)
    slope = -float(rim.sum(axis=0)[m // 2])
    return factors(-2.0 * index**2 * _integral(psi / r**3, rho, n, m), slope, index)


def _integral(values: Any, rho: Any, n: int, m: int) -> float:
    """Over the disk: sums over equal angles, then ρ times their even Chebyshev interpolant."""
    rings = 2.0 * np.pi / m * values.reshape(rho.size, m).sum(axis=1)
    points = np.cos(np.pi * np.arange(n + 1) / n)
    even = np.concatenate([[0.0], rings, rings[::-1], [0.0]])
    terms = chebyshev.chebmul(chebyshev.chebfit(points, even, n), [0.0, 1.0])
    whole = chebyshev.chebint(terms)
    return float(chebyshev.chebval(1.0, whole) - chebyshev.chebval(0.0, whole))


# ---------------------------------------------------------------- what the package uses


def stiffness_terms(degree: int = 4) -> list[float]:
    """Coefficients of x, x², … in the stiffness factor 1 + …, x = 1/C², for C ≥ 3."""
    return fitted(lambda x: collocated(x**-0.5).stiffness, 1.0 / 9.0, degree)


def stress_terms(degree: int = 7) -> list[float]:
    """Coefficients of x, x², … in the peak stress factor 1 + …, x = 1/C, for C ≥ 3."""
    return fitted(lambda x: collocated(1.0 / x).peak_stress, 1.0 / 3.0, degree)


def fitted(function: Any, end: float, degree: int) -> list[float]:
    """(f - 1)/x interpolated at Chebyshev points of [0, end], in powers of x."""
    nodes = 0.5 * end * (1.0 - np.cos(np.pi * (np.arange(degree) + 0.5) / degree))
    values = [(function(x) - 1.0) / x for x in nodes.tolist()]
    powers: Any = np.polynomial.Polynomial.fit(nodes, values, degree - 1).convert()
    return powers.coef.tolist()
