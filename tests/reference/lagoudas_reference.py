"""One-page Lagoudas model, by return mapping in small increments; shares no code with the package.

    forward  (1 - D) H σ + ½ ΔS σ² + s T - u - ½ a₁ [1 + ξ^n₁ - (1 - ξ)^n₂] - a₃ - Y = 0
    reverse  (1 + D) Λ σ + ½ ΔS σ² + s T - u - ½ a₂ [1 + ξ^n₃ - (1 - ξ)^n₄] + a₃ + Y = 0

The seven constants are the solution of a linear system of the seven conditions of calibration.
A leg is cut into increments; after each, ξ is moved onto the surface it has crossed (`brentq`),
reverse first, then forward. The transformation strain grows by ∫H dξ forward, by Gauss's rule
over ξ with the stress at each ξ from the increment, and by Λ = ε_t/ξ at the last reversal.

With a waist b, y = ξ^m - (1 - ξ)^n of a branch becomes (1 - b) y + b y³. Curved surfaces add to T of a branch in Φ
-c σ (σ - 2 σ_cal), and to its hardening s (½ - h) w σ, in tension: a₁ and a₂ hold s times a range.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def root(function, low: float, high: float) -> float:
    """Where a function changes its sign, to rounding."""
    found: Any = brentq(function, low, high, xtol=1e-15, rtol=1e-14)
    return float(found)


@dataclass
class Parameters:
    E_A: float  # [Pa]
    E_M: float
    A_s: float  # [K]
    A_f: float
    M_s: float
    M_f: float
    C_A: float  # [Pa/K]
    C_M: float
    sigma_cal: float  # [Pa]
    H_min: float
    H_sat: float
    H_k: float  # [1/Pa]
    sigma_crit: float
    n_1: float
    n_2: float
    n_3: float
    n_4: float
    waist_f: float = 0.0
    waist_r: float = 0.0
    curvature_f: float = 0.0  # [K/Pa²]
    curvature_r: float = 0.0
    widening_f: float = 0.0  # [K/Pa]
    widening_r: float = 0.0

    def h(self, xi: float, back: bool = False) -> float:
        """Hardening of a branch, from 0 to 1."""
        m, n, b = (self.n_3, self.n_4, self.waist_r) if back else (self.n_1, self.n_2, self.waist_f)
        y = xi**m - (1 - xi) ** n
        return 0.5 * (1 + (1 - b) * y + b * y**3)

    def bend(self, curvature: float, sigma: float) -> float:
        """What a curved surface adds to the temperature of its line [K]."""
        return curvature * sigma * (sigma - 2 * self.sigma_cal) if sigma > 0 else 0.0

    def H(self, sigma: float) -> float:
        if sigma <= self.sigma_crit:
            return self.H_min
        return self.H_sat - (self.H_sat - self.H_min) * exp(-self.H_k * (sigma - self.sigma_crit))


@dataclass
class State:
    xi: float
    strain: float  # ε_t
    ratio: float  # Λ at the last reversal
    sigma: float
    T: float


def constants(p: Parameters) -> dict[str, float]:
    """The solution of the seven conditions, unknowns s, D, u, a₁, a₂, a₃, Y."""
    h = 1e-6 * p.sigma_cal
    G = ((p.sigma_cal + h) * p.H(p.sigma_cal + h) - (p.sigma_cal - h) * p.H(p.sigma_cal - h)) / (2 * h)
    soft = p.sigma_cal * (1 / p.E_M - 1 / p.E_A)
    mean = [2 * float(quad(p.h, 0, 1, back, epsabs=1e-12)[0]) for back in (False, True)]
    rows = [
        ([1, -p.C_M * G, 0, 0, 0, 0, 0], -p.C_M * (G + soft)),  # slope forward
        ([1, p.C_A * G, 0, 0, 0, 0, 0], -p.C_A * (G + soft)),  # slope reverse
        ([p.M_s, 0, -1, 0, 0, -1, -1], 0),
        ([p.M_f, 0, -1, -1, 0, -1, -1], 0),
        ([p.A_f, 0, -1, 0, 0, 1, 1], 0),
        ([p.A_s, 0, -1, 0, -1, 1, 1], 0),
        ([0, 0, 0, mean[0] / 2, -mean[1] / 2, 2, 0], 0),  # equal hardening energy
    ]
    matrix, right = np.array([r for r, _ in rows], float), np.array([b for _, b in rows], float)
    scale = np.array([1e5, 1, 1e8, 1e7, 1e7, 1e7, 1e7])
    solved = scale * np.linalg.solve(matrix * scale, right)
    return dict(zip(("s", "D", "u", "a1", "a2", "a3", "Y"), map(float, solved), strict=True))


def forward(p: Parameters, c: dict[str, float], xi: float, sigma: float, T: float) -> float:
    """Φ of the forward surface."""
    elastic = 0.5 * (1 / p.E_M - 1 / p.E_A) * sigma**2
    hardening = c["a1"] * p.h(xi)
    drive = (1 - c["D"]) * p.H(sigma) * sigma + elastic + c["s"] * (T - p.bend(p.curvature_f, sigma)) - c["u"]
    hardening += c["s"] * (0.5 - p.h(xi)) * p.widening_f * max(sigma, 0.0)
    return drive - hardening - c["a3"] - c["Y"]


def reverse(p: Parameters, c: dict[str, float], ratio: float, xi: float, sigma: float, T: float) -> float:
    """Φ of the reverse surface."""
    elastic = 0.5 * (1 / p.E_M - 1 / p.E_A) * sigma**2
    hardening = c["a2"] * p.h(xi, back=True)
    drive = (1 + c["D"]) * ratio * sigma + elastic + c["s"] * (T - p.bend(p.curvature_r, sigma)) - c["u"]
    hardening += c["s"] * (0.5 - p.h(xi, back=True)) * p.widening_r * max(sigma, 0.0)
    return -drive + hardening - c["a3"] - c["Y"]


def gained(p: Parameters, c: dict[str, float], old: State, new: State) -> float:
    """∫H dξ over an increment on which ξ grew."""
    if old.sigma == new.sigma:
        return p.H(new.sigma) * (new.xi - old.xi)
    total = 0.0
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        xi = old.xi + 0.5 * (1 + node) * (new.xi - old.xi)

        def beyond(part: float, xi: float = xi) -> float:
            at = old.sigma + part * (new.sigma - old.sigma)
            return forward(p, c, xi, at, old.T + part * (new.T - old.T))

        part = root(beyond, 0.0, 1.0) if beyond(0.0) < 0.0 < beyond(1.0) else 1.0
        sigma = old.sigma + part * (new.sigma - old.sigma)
        total += 0.5 * weight * p.H(sigma) * (new.xi - old.xi)
    return total


def increment(p: Parameters, c: dict[str, float], old: State, sigma: float, T: float) -> State:
    """The state after a small step to (σ, T)."""
    new = replace(old, sigma=sigma, T=T)

    def back(xi: float) -> float:
        return reverse(p, c, old.ratio, xi, sigma, T)

    def ahead(xi: float) -> float:
        return forward(p, c, xi, sigma, T)

    if new.xi > 0.0 and back(new.xi) > 0.0:
        new.xi = root(back, 0.0, new.xi) if back(0.0) < 0.0 else 0.0
        new.strain = new.xi * old.ratio
    if new.xi < 1.0 and ahead(new.xi) > 0.0:
        before = replace(new, sigma=old.sigma, T=old.T)
        new.xi = root(ahead, new.xi, 1.0) if ahead(1.0) < 0.0 else 1.0
        new.strain += gained(p, c, before, new)
        new.ratio = new.strain / new.xi if new.xi > 0.0 else 0.0
    return new


def start(p: Parameters, xi: float, oriented: float, sigma: float, T: float) -> State:
    """Any phase state; `oriented` is ε_t/H_sat."""
    strain = oriented * p.H_sat
    return State(xi, strain, strain / xi if xi > 0.0 else 0.0, sigma, T)


def advance(p: Parameters, state: State, sigma: float, T: float, count: int) -> State:
    """The state after a straight leg in `count` increments."""
    c, first = constants(p), state
    state = increment(p, c, state, state.sigma, state.T)  # a start outside the surfaces
    for k in range(1, count + 1):
        part = k / count
        at = first.sigma + part * (sigma - first.sigma) if k < count else sigma
        kelvin = first.T + part * (T - first.T) if k < count else T
        state = increment(p, c, state, at, kelvin)
    return state
