"""The spring of the two-axis platform, in the units of its paper, for several test files."""

from __future__ import annotations

import math
from typing import Any

from martensite.actuators.elements.base import Spring
from martensite.actuators.elements.coil_spring import CoilSpring
from martensite.kernels import floats
from martensite.physics.electrical.resistances import MixtureResistance
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import load_material

NUMBERS: dict[str, Any] = {name: n.value for name, n in load_material("platform-spring").values.items()}
WIRE, COIL, TURNS = 0.75e-3, 5.25e-3, 20.0
"""Wire diameter, mean coil diameter [m], turns."""
CLOSED, COLD = 15e-3, 60e-3
"""Unloaded lengths hot and cold [m]."""
G_A, G_M = 26.9e9, 17e9
ROOT3 = math.sqrt(3.0)


def platform_law(**options: Any) -> LiangRogers:
    """The law of the paper: mixture modulus, transformation stress linear in ξ."""
    numbers = {n: v for n, v in NUMBERS.items() if n in LiangRogers.declarations}
    chosen: dict[str, Any] = {"modulus": "mixture", "transformation": "stress"}
    return LiangRogers(**(numbers | chosen | options))


def platform_spring(**changes: Any) -> CoilSpring:
    """Outer diameter 6 mm, closed when hot."""
    numbers = {n: v for n, v in NUMBERS.items() if n in CoilSpring.declarations}
    resistance = MixtureResistance(rho_A=NUMBERS["rho_A"], rho_M=NUMBERS["rho_M"])
    given: dict[str, Any] = {
        "diameter": WIRE,
        "coil_diameter": 6e-3,
        "coil_measure": "outer",
        "turns": TURNS,
        "free_length": CLOSED,
        "resistance": resistance,
        "law": platform_law(),
    }
    return CoilSpring(**(numbers | given | changes))


def tangent(spring: CoilSpring, fraction: float, force: float = 0.0) -> Spring:
    """At a martensite fraction, 300 K and a force [N]."""
    return spring.spring(floats, Fractions(fraction, fraction), 300.0, force)


def elongation(spring: CoilSpring, fraction: float, force: float) -> float:
    """[m]"""
    found = tangent(spring, fraction, force)
    return found.free + found.compliance * force


def force_at(spring: CoilSpring, fraction: float, length: float) -> float:
    """Force [N] of a spring drawn to a length [m], by the tangents alone."""
    force = 0.0
    for _ in range(20):
        found = tangent(spring, fraction, force)
        force = (length - spring.free_length - found.free) / found.compliance
    return force
