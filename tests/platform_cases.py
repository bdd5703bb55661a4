"""The platform of the tests, and its kinematics once more, with numpy's matrices.

Two triangular plates of 100 mm, 60 mm apart (Ranjith Pillai, Murali and Gopal, 2018).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from martensite.actuators.mechanics.platform_kinematics import Plates

SIDE, HEIGHT = 0.100, 0.060
RADIUS = SIDE / math.sqrt(3.0)
PLATES = Plates(SIDE, HEIGHT, HEIGHT)
GEOMETRIES = [PLATES, Plates(SIDE, HEIGHT, 0.5 * HEIGHT), Plates(SIDE, HEIGHT, 0.0), Plates(0.05, 0.12, 0.15)]
POSTURES = [(0.0, 0.0), (0.3, 0.0), (0.0, -0.4), (0.35, 0.5), (-0.6, 0.2), (-0.5, -0.7)]
VERTICES = np.array([[0.0, RADIUS, 0.0], [-SIDE / 2, -RADIUS / 2, 0.0], [SIDE / 2, -RADIUS / 2, 0.0]])
"""Of the first platform [m]."""


def about_x(angle: float) -> Any:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_y(angle: float) -> Any:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def by_matrices(plates: Plates, rotation: Any) -> Any:
    """Lengths of the legs [m] of plates that are turned by a matrix."""
    base = VERTICES * (plates.side / SIDE)
    down = np.array([0.0, 0.0, 1.0])
    above = (plates.height - plates.pivot) * down
    top = (base - above) @ rotation.T - plates.pivot * down
    return np.linalg.norm(top - base, axis=1)
