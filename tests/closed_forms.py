"""The published cosines of Liang and Rogers with the strips of problem A, in °C and MPa.

At zero stress reverse from 68 to 78 °C, forward from 52 to 42 °C; C_A = 10, C_M = 8 MPa/K.
"""

import math

import pytest

A_S, A_F, M_S, M_F, C_A, C_M, EPS_L = 68.0, 78.0, 52.0, 42.0, 10.0, 8.0, 0.04
BOTH_RULES = pytest.mark.parametrize("rule", ["resume", "restart"])


def exact(x):
    """Equal to 1e-10."""
    return pytest.approx(x, abs=1e-10, rel=0)


def forward(celsius, mpa=0.0, xi=0.0):
    """½ (1 - ξ₀) cos[a_M (T - M_f - σ/C_M)] + ½ (1 + ξ₀), the printed curve."""
    angle = math.pi / (M_S - M_F) * (celsius - M_F - mpa / C_M)
    return 0.5 * (1 - xi) * math.cos(angle) + 0.5 * (1 + xi)


def reverse(celsius, mpa=0.0, xi=1.0):
    """½ ξ₀ {cos[a_A (T - A_s - σ/C_A)] + 1}, the printed curve."""
    return 0.5 * xi * (math.cos(math.pi / (A_F - A_S) * (celsius - A_S - mpa / C_A)) + 1)


def hot(celsius):
    """What heating from below A_s to a temperature leaves of all martensite."""
    return math.cos(0.5 * math.pi * (celsius - A_S) / (A_F - A_S)) ** 2


def cold(celsius):
    """What cooling from above M_s to a temperature leaves of all austenite."""
    return math.sin(0.5 * math.pi * (celsius - M_F) / (M_S - M_F)) ** 2
