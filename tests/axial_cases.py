"""A thin wire between clamps: systems, the exact fin, and the finite volumes written anew."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from builders import plain_law

from martensite.actuators.assembly import System
from martensite.actuators.elements.axial_wire import AxialWire
from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling

D, L, K, H, AMBIENT = 0.1e-3, 20e-3, 18.0, 200.0, 295.0
SECTION = 0.25 * math.pi * D * D
HEALING = math.sqrt(K * D / (4.0 * H))
"""Healing length [m]: 1.5 mm."""
IDEAL = 1e9
"""Contact conductance [W/K] that counts as ideal."""


def thin_wire(length: float = L, law: Any = None, **changes: Any) -> Wire:
    """A wire with the diameter of a finger's, of one resistivity."""
    numbers: dict[str, Any] = {
        "diameter": D,
        "density": 6450.0,
        "heat_capacity": 400.0,
        "latent_heat": 24e3,
        "resistance": PerLengthResistance(r_A=125.0, r_M=125.0),
    }
    return Wire(length=length, law=law or plain_law(), **(numbers | changes))


def axial(wire: Wire | None = None, **numbers: Any) -> AxialWire:
    """The thin wire, cut."""
    usual: dict[str, Any] = {"thermal_conductivity": K, "contact": IDEAL, "grading": 3.0}
    return AxialWire(wire=wire or thin_wire(), **(usual | numbers))


def clamped(element: AbstractElement, mechanism: AbstractMechanism | None = None) -> System:
    """An element under a constant film coefficient and an electrical power."""
    return System(
        element=element,
        environment=Environment(temperature=AMBIENT, cooling=ConstantCooling(h=H)),
        source=PowerSource(),
        mechanism=mechanism or DeadWeight(mass=0.05),
    )


def fin(
    watts: float, length: float = L, contact: float = IDEAL, spans: float = 1.0, k: float = K
) -> tuple[float, float]:
    """Mean and highest overtemperature [K] of a fin with a uniform source between its clamps.

    θ'' = m² (θ - θ_∞) with k A θ' = G_c θ at the clamp.
    """
    m, span = math.sqrt(4.0 * H / (k * D)), length / spans
    b, beta = 0.5 * m * span, k * SECTION * m / contact
    far = watts / (H * math.pi * D * length)
    end = far / (math.cosh(b) + beta * math.sinh(b))  # what the clamp takes in the middle
    return far * (1.0 - math.tanh(b) / (b * (1.0 + beta * math.tanh(b)))), far - end


def finite_volumes(watts: float, cells: int, grading: float, first: float = 0.5) -> float:
    """Mean overtemperature [K] by cells; `first` is the share of a cell up to the clamp."""
    faces = np.expm1(grading * np.arange(cells + 1) / cells) / math.expm1(grading) * 0.5 * L
    sizes = np.diff(faces)
    half = sizes / (2.0 * K * SECTION)
    between = 1.0 / (half[:-1] + half[1:])
    matrix = np.diag(H * math.pi * D * sizes)
    matrix[0, 0] += 1.0 / (2.0 * first * half[0])
    for i, g in enumerate(between):
        matrix[i : i + 2, i : i + 2] += g * np.array([[1.0, -1.0], [-1.0, 1.0]])
    found = np.linalg.solve(matrix, watts * sizes / L)
    return float(found @ sizes / sizes.sum())


def orders(errors: Any) -> np.ndarray:
    """Observed orders between neighbours in a row of doubled numbers of cells or steps."""
    sizes = np.abs(np.array(errors))
    return np.log2(sizes[:-1] / sizes[1:])
