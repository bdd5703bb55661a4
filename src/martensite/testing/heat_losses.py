"""What every heat-loss model promises: heat flows to the colder side, the more the hotter."""

from __future__ import annotations

import numpy as np

from martensite.kernels import floats
from martensite.physics.thermal.base import AbstractCooling, Cylinder
from martensite.testing.conformance import Check, require_condition

AMBIENT = 295.0
TEMPERATURES = np.linspace(260.0, 450.0, 96)


def find_losses(cooling: AbstractCooling) -> np.ndarray:
    """Heat flow per surface [W/m²] at all temperatures, surroundings at 295 K."""
    shape = Cylinder(0.2e-3, 0.2)
    films = [cooling.film(floats, t, AMBIENT, shape) for t in TEMPERATURES.tolist()]
    return np.array(films) * (TEMPERATURES - AMBIENT)


def check_growth(cooling: AbstractCooling) -> None:
    """The heat loss grows with temperature."""
    falls = np.diff(find_losses(cooling)) <= 0.0
    hot = TEMPERATURES[int(np.argmax(falls))]
    require_condition(not falls.any(), f"In air of 295 K the heat loss falls above {hot:.0f} K.")


def check_side(cooling: AbstractCooling) -> None:
    """Heat flows to the colder side only."""
    wrong = np.sign(find_losses(cooling)) != np.sign(TEMPERATURES - AMBIENT)
    there = TEMPERATURES[int(np.argmax(wrong))]
    require_condition(
        not wrong.any(), f"At {there:.0f} K heat flows from the colder to the hotter side."
    )


CHECKS: dict[str, list[Check]] = {"cooling": [check_growth, check_side]}
