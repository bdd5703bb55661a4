"""Two unbalanced motors on one beam, on one page: Lagrange's equations by SciPy; nothing of the package is in it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Motor(NamedTuple):
    """A motor with an unbalance: m r [kg m], J + m r² [kg m²], K [N m/A], R [ohm], L [H], b [N m s]."""

    moment: float
    turning: float
    constant: float
    ohms: float
    henrys: float
    friction: float


def run_motors(
    beam: tuple[float, float, float], motors: list[Motor], volts: list[float], times: np.ndarray
) -> np.ndarray:
    """Displacement, velocity, and angle, speed and current of each motor at some times, from rest.

    Args:
        beam: moving mass [kg], damping [N s/m], stiffness [N/m].
        motors: those at its tip.
        volts: constant voltage of each [V].
        times: from 0 s on.
    """
    mass, damping, stiffness = beam
    n = len(motors)

    def rates(_: float, y: Any) -> Any:
        x, v, angles, speeds, currents = y[0], y[1], y[2 : 2 + n], y[2 + n : 2 + 2 * n], y[2 + 2 * n :]
        matrix, right = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
        matrix[0, 0], right[0] = mass, -damping * v - stiffness * x
        for k, one in enumerate(motors):
            matrix[0, k + 1] = matrix[k + 1, 0] = one.moment * np.cos(angles[k])
            matrix[k + 1, k + 1] = one.turning
            right[0] += one.moment * speeds[k] ** 2 * np.sin(angles[k])
            right[k + 1] = one.constant * currents[k] - one.friction * speeds[k]
        gained = np.linalg.solve(matrix, right)
        rows = zip(motors, volts, speeds, currents, strict=True)
        coils = [(u - one.constant * w - one.ohms * i) / one.henrys for one, u, w, i in rows]
        return np.concatenate([[v, gained[0]], speeds, gained[1:], coils])

    found = solve_ivp(rates, (0.0, times[-1]), np.zeros(2 + 3 * n), "DOP853", times, rtol=1e-10, atol=1e-12)
    return found.y
