"""Benchmark problem A: a Liang-Rogers wire, heated by a voltage, against a bias spring.

What: one page with every number of the problem, shared by all engines that are compared.
Equations (T [degC], xi = martensite fraction):

    heat      M c dT/dt = V^2/R(xi) - (h0 + h1 D) S D + M latent dxi/dt,  D = T - T_a
    resistor  R = R0 (1 + kappa xi)
    material  sigma = E(xi) (eps - eps_L xi) + Theta (T - T_a),  E = E_A + xi (E_M - E_A)
    spring    sigma = sigma0 + K (eps0 - eps),  x = l (sigma - sigma0)/K
    kinetics  T_A = T - sigma/C_A, w_A falls 1 -> 0 as a half cosine over A_s..A_f;
              T_M = T - sigma/C_M, w_M falls 1 -> 0 on cooling over M_s..M_f

History: P ("resume") continues a transformation where it stopped, R ("restart") begins a new one
at every reversal; each engine is measured against the reference of the rule that it solves.
Source: kinetics of Liang and Rogers (1990), wire and drive of Elahinia type; numbers chosen for
this project (they describe no tested wire). Sign: x > 0 when the hot wire shortens.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

THETA = ("h0", "A_s", "A_f", "M_s", "M_f", "C_A", "C_M", "eps_L", "latent", "c")
OUTPUT_INTERVAL = 0.1  # [s]

# time [s] -> (x [mm], T [degC], xi) of rule P, and x [mm] of rule R; computed for this project.
REFERENCE_P = {
    15.0: (3.715943, 79.825001, 0.62737736),
    45.0: (2.722325, 68.174947, 0.72707145),
    50.0: (0.930803, 50.473369, 0.90718567),
    60.0: (6.077798, 63.369082, 0.38957955),
}
REFERENCE_R = {15.0: 3.715943, 45.0: 2.722324, 50.0: 0.591651, 60.0: 6.046748}
RANGE_P = 9.976009  # [mm]
OBJECTIVE_P = 1.897409421465e-4  # J at theta, steps of 10 ms
GRADIENT_P = (
    *(0.013777, 0.004818, 0.003096, 0.005796, 0.004980),
    *(-0.000831, -0.002439, 0.004037, -0.002096, -0.000723),
)


class Wire(NamedTuple):
    """Parameters of problem A; the ten of THETA may be arrays of parameter sets."""

    h0: Any = 100.0  # [W/m^2/K] heat loss
    A_s: Any = 68.0  # [degC]
    A_f: Any = 78.0  # [degC]
    M_s: Any = 52.0  # [degC]
    M_f: Any = 42.0  # [degC]
    C_A: Any = 10e6  # [Pa/K]
    C_M: Any = 8e6  # [Pa/K]
    eps_L: Any = 0.04  # [1]
    latent: Any = 24e3  # [J/kg]
    c: Any = 400.0  # [J/kg/K]
    density: float = 6450.0  # [kg/m^3]
    diameter: float = 0.381e-3  # [m]
    length: float = 0.25  # [m]
    E_A: float = 75e9  # [Pa]
    E_M: float = 28e9  # [Pa]
    Theta: float = 0.055e6  # [Pa/K]
    resistance: float = 8.3  # [ohm/m]
    kappa: float = 0.15  # [1]
    h1: float = 0.15  # [W/m^2/K^2]
    T_a: float = 20.0  # [degC]
    preload: float = 5.0  # [N]
    rate: float = 1000.0  # [N/m]


class Lumped(NamedTuple):
    """Values that follow from a `Wire`."""

    M: float  # [kg]
    S: float  # [m^2]
    sigma0: float  # [Pa]
    K: float  # [Pa] spring rate seen as a modulus
    R0: float  # [ohm]
    eps0: Any  # [1]


def lumped(p: Wire) -> Lumped:
    """Mass, surface, spring and resistance of the wire."""
    area = math.pi * p.diameter**2 / 4
    sigma0 = p.preload / area
    return Lumped(
        M=p.density * area * p.length,
        S=math.pi * p.diameter * p.length,
        sigma0=sigma0,
        K=p.rate * p.length / area,
        R0=p.resistance * p.length,
        eps0=p.eps_L + sigma0 / p.E_M,
    )


def stress(p: Wire, d: Lumped, T: Any, xi: Any) -> Any:
    """Stress [Pa] of the wire on its spring at temperature T [degC] and fraction xi."""
    E = p.E_A + xi * (p.E_M - p.E_A)
    load = d.sigma0 + d.K * d.eps0 + E * p.eps_L * xi - p.Theta * (T - p.T_a)
    return d.sigma0 + d.K * (d.eps0 - load / (E + d.K))


def displacement(p: Wire, d: Lumped, T: Any, xi: Any) -> Any:
    """Displacement x [mm], zero at the preload."""
    return 1e3 * p.length * (stress(p, d, T, xi) - d.sigma0) / d.K


def thin_wire() -> Wire:
    """The wire of the pulse input: 0.1 mm, spring and resistance scaled with the section."""
    p = Wire()
    s = (0.1e-3 / p.diameter) ** 2
    return p._replace(diameter=0.1e-3, preload=p.preload * s, rate=p.rate * s, resistance=p.resistance / s)


def parameter_sets(n: int) -> Wire:
    """n parameter sets around the nominal one, as arrays of shape (n,) in the fields of THETA."""
    import numpy

    rng = numpy.random.default_rng(0)
    p, drawn = Wire(), {}
    for name in THETA:
        u = 2 * rng.random(n) - 1
        value = getattr(p, name)
        drawn[name] = value + 2.0 * u if name in THETA[1:5] else value * (1 + 0.15 * u)
    return p._replace(**drawn)


def one_set(sets: Wire, i: int) -> Wire:
    """Parameter set number i of arrays of sets, as plain floats."""
    return sets._replace(**{name: float(getattr(sets, name)[i]) for name in THETA})


def first_sets(sets: Wire, n: int) -> Wire:
    """The first n of arrays of sets."""
    return sets._replace(**{name: getattr(sets, name)[:n] for name in THETA})


def scaled(p: Wire, q: Any) -> Wire:
    """Theta multiplied by the ten factors q."""
    return p._replace(**{name: getattr(p, name) * q[i] for i, name in enumerate(THETA)})


def target_factors() -> list[float]:
    """The factors q1 that make the displacement to be matched by the gradient objective."""
    import numpy

    return [1 + 0.02 * u for u in numpy.random.default_rng(3).uniform(-1, 1, 10).tolist()]


def rms_error(x: Any, reference: Any) -> float:
    """rms difference over the range of the reference: the err of every table."""
    import numpy

    reference = numpy.asarray(reference)
    gap = numpy.asarray(x, dtype=float) - reference
    return float(numpy.sqrt(numpy.mean(gap**2)) / numpy.ptp(reference))
