"""Formulas of close-coiled helical springs of round wire.

With wire diameter d, mean coil diameter D, index C = D/d, N turns and shear modulus G, a thin coil under a force F has
the surface stress and the spring rate

    τ = 8 F D/(π d³),      k = G d⁴/(8 N D³).

A coil of finite index has a higher stress at its inner fibre and is slightly stiffer:

    stress      Bergsträsser (4C + 2)/(4C - 3),   Wahl (4C - 1)/(4C - 4) + 0.615/C
    stiffness   Ancker–Goodier 1/[1 - 3/(16 C²)]

The exact factors belong to Göhner's problem, an elastic torus sector without pitch. Here they are polynomials in 1/C
and 1/C², within 1e-7 of numerical solutions for C ≥ 3 (the tests solve the problem in two ways and recompute the
coefficients). The handbook factor 1/[1 + 1/(2 C²)] of the stiffness has the wrong sign.

Source: Wahl (1963); Ancker and Goodier (1958); the exact factors were computed for this project.
"""

import math

from martensite.kernels.namespace import Scalar

LEAST_INDEX = 3.0
"""Smallest spring index of the exact factors."""

STIFFNESS_TERMS = (0.18749990704070718, 0.17092513673011378, 0.10753576375627583, 0.09930535360839417)
"""Coefficients of 1/C², 1/C⁴, … in the exact stiffness factor."""

STRESS_TERMS = (
    1.2500001253962632,
    0.8749632560407178,
    0.7712647021540424,
    0.6583303552933382,
    0.9105128627097725,
    -0.332299240590914,
    2.2937079620869074,
)
"""Coefficients of 1/C, 1/C², … in the exact stress factor."""


def spring_index(wire: Scalar, coil: Scalar) -> Scalar:
    """Return C = D/d [-] from wire and mean coil diameter [m]."""
    return coil / wire


def shear_stress(force: Scalar, wire: Scalar, coil: Scalar) -> Scalar:
    """Return 8 F D/(π d³) [Pa], the surface stress of a thin coil."""
    return force * (8.0 * coil / (math.pi * wire * wire * wire))


def compute_bergstraesser_factor(index: Scalar) -> Scalar:
    """Return Bergsträsser's factor of the inner-fibre stress [-]."""
    return (4.0 * index + 2.0) / (4.0 * index - 3.0)


def compute_wahl_factor(index: Scalar) -> Scalar:
    """Return Wahl's factor of the inner-fibre stress [-]."""
    return (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index


def ancker_goodier(index: Scalar) -> Scalar:
    """Return Ancker and Goodier's factor of the spring rate [-]."""
    return 1.0 / (1.0 - 3.0 / (16.0 * index * index))


def exact_stiffness(index: Scalar) -> Scalar:
    """Return the factor of the spring rate of a coil without pitch [-], C ≥ 3."""
    return _sum_series(STIFFNESS_TERMS, 1.0 / (index * index))


def exact_stress(index: Scalar) -> Scalar:
    """Return the factor of the inner-fibre stress of a coil without pitch [-], C ≥ 3."""
    return _sum_series(STRESS_TERMS, 1.0 / index)


def _sum_series(terms: tuple[float, ...], x: Scalar) -> Scalar:
    """Return 1 + a x + b x² + … by Horner's rule."""
    total = 0.0 * x
    for term in reversed(terms):
        total = (total + term) * x
    return 1.0 + total
