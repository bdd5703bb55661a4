"""A plate on its joint, let go from a tilt, against SciPy on equations that share nothing with the package.

Source of truth: Newton's law of three masses at the middles of the sides, which are a uniform triangle, turned by
β about Y after α about X; every spring pulls with F₀ + k (L - h) along the line between its ends.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from martensite.kernels.compiler import find_compiler
from martensite.scenario.running import run
from martensite.scenario.scenario import read_scenario

SIDE, HEIGHT, MASS, DAMPING, PRELOAD, END = 0.1, 0.06, 1.2, 1e-3, 3.0, 0.2
RATE = 17e9 * 0.75e-3**4 / (8 * 20 * 5.25e-3**3)
"""Of a cold spring [N/m]: G d⁴/(8 n D³)."""
TEXT = """
[element]
kind = "coil-spring"
material = "platform-spring"
diameter = "0.75 mm"
coil_diameter = "6 mm"
coil_measure = "outer"
turns = 20
free_length = "15 mm"
density = "6862 kg/m^3"
law = { kind = "liang-rogers", modulus = "mixture", transformation = "stress", eps_L = 0.0112519 }
resistance = { rho_A = "9.7057e-7 ohm m", rho_M = "1.09795e-6 ohm m" }

[environment]
temperature = "25 degC"
cooling = { kind = "constant", h = "68.6 W/m^2/K" }

[mechanism]
kind = "parallel-platform"
motion = "dynamic"
rho_inf = 1.0
side = "100 mm"
height = "60 mm"
mass = "1.2 kg"
damping = "1e-3 N*m*s/rad"
preload = "3 N"

[drive]
kind = "power"

[initial]
alpha = "10 deg"

[run]
duration = "0.2 s"
step = "10 us"
samples = 101
"""


def turn_x(angle: float, order: int) -> np.ndarray:
    """A turn about X, or its first or second derivative."""
    c, s = math.cos(angle + 0.5 * math.pi * order), math.sin(angle + 0.5 * math.pi * order)
    return np.array([[order == 0, 0, 0], [0, c, -s], [0, s, c]])


def turn_y(angle: float, order: int) -> np.ndarray:
    """A turn about Y, or its first or second derivative."""
    c, s = math.cos(angle + 0.5 * math.pi * order), math.sin(angle + 0.5 * math.pi * order)
    return np.array([[c, 0, s], [0, order == 0, 0], [-s, 0, c]])


RADIUS = SIDE / math.sqrt(3.0)
CORNERS = RADIUS * np.array([[math.sin(a), math.cos(a), 0.0] for a in (0.0, -2 * math.pi / 3, 2 * math.pi / 3)])
MIDDLES = -0.5 * CORNERS


def accelerate(_: float, y: np.ndarray) -> np.ndarray:
    alpha, beta, *rates = y

    def turned(points: np.ndarray, i: int, j: int) -> np.ndarray:
        return points @ (turn_y(beta, j) @ turn_x(alpha, i)).T

    jacobian = [turned(MIDDLES, 1, 0), turned(MIDDLES, 0, 1)]
    a, b = rates
    bias = a * a * turned(MIDDLES, 2, 0) + 2 * a * b * turned(MIDDLES, 1, 1) + b * b * turned(MIDDLES, 0, 2)
    spans = turned(CORNERS, 0, 0) - CORNERS - [0.0, 0.0, HEIGHT]
    lengths = np.linalg.norm(spans, axis=1)
    pulls = -(PRELOAD + RATE * (lengths - HEIGHT))[:, None] * spans / lengths[:, None]
    levers = [turned(CORNERS, 1, 0), turned(CORNERS, 0, 1)]
    inertia = [[MASS / 3 * np.sum(p * q) for q in jacobian] for p in jacobian]
    forces = [np.sum(pulls * lever) - MASS / 3 * np.sum(bias * p) for lever, p in zip(levers, jacobian, strict=True)]
    return np.array([a, b, *np.linalg.solve(inertia, np.array(forces) - DAMPING * np.array(rates))])


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
@pytest.mark.parametrize("alpha, beta, spin", [(10.0, 0.0, 0.0), (5.0, 5.0, 40.0)])
def test_plate_that_is_let_go_swings_as_in_another_program(alpha: float, beta: float, spin: float) -> None:
    initial = {"alpha": f"{alpha} deg", "beta": f"{beta} deg", "beta_rate": f"{spin} deg/s"}
    found = run(read_scenario(TEXT), runtime="c", initial=initial)
    begin = np.radians([alpha, beta, 0.0, spin])
    known = solve_ivp(accelerate, (0.0, END), begin, "DOP853", found.times, rtol=1e-11, atol=1e-12).y
    assert np.ptp(known[0]) > math.radians(9.0)
    for name, row in zip(("alpha", "beta"), known, strict=False):
        assert np.abs(found[name] - row).max() < 1e-6 * np.abs(begin[:2]).max()
    forces = [found[f"{port}.force"] for port in ("first", "second", "third")]
    assert min(map(min, forces)) > 0.0 and found["first.martensite_fraction"].min() == 1.0
