"""What models of heat loss, of ends and fluids promise: more heat, to the colder side."""

from __future__ import annotations

import math

import numpy as np

from martensite.kernels import floats
from martensite.physics.fluids.base import AbstractFluid
from martensite.physics.thermal.base import AbstractCooling, Cylinder
from martensite.physics.thermal.ends import AbstractEnds
from martensite.testing.conformance import require_condition

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
    require_condition(not wrong.any(), f"At {there:.0f} K heat flows from the colder to the hotter side.")


# ---------------------------------------------------------------- ends and fluids


def check_conductance(ends: AbstractEnds) -> None:
    """With ends an element loses at least what its surface loses, and more with a larger film."""
    for length in (1e-3, 0.02, 0.5):
        shape, before = Cylinder(0.2e-3, length), 0.0
        for film in (0.0, 1e-3, 5.0, 50.0, 500.0):
            found = ends.conductance(floats, film, shape)
            surface = film * math.pi * shape.diameter * shape.length
            words = f"At a film of {film:g} W/m²/K {length:g} m lose {found:.4g} W/K"
            require_condition(found >= surface * (1.0 - 1e-9), f"{words}, the surface {surface}.")
            require_condition(found >= before, f"{words}, less than at a smaller one.")
            before = found


def check_properties(fluid: AbstractFluid) -> None:
    """Conductivity, viscosity and Prandtl number are above zero over the span."""
    low, high = fluid.span()
    require_condition(0.0 < low < high, f"Its span is {low:g} K to {high:g} K.")
    for kelvin in np.linspace(low, high, 60).tolist():
        found = fluid.properties(floats, kelvin)
        sound = all(math.isfinite(x) for x in found) and min(found[:3]) > 0.0
        require_condition(sound, f"At {kelvin:.0f} K its properties are {found}.")


def check_span(fluid: AbstractFluid) -> None:
    """Beyond its span the properties are those at the nearer end."""
    low, high = fluid.span()
    for beyond, end in ((0.1 * low, low), (10.0 * high, high)):
        same = fluid.properties(floats, beyond) == fluid.properties(floats, end)
        require_condition(same, f"At {beyond:.0f} K it is not as at {end:.0f} K.")


def check_smoothness(fluid: AbstractFluid) -> None:
    """Over the span no property jumps."""
    low, high = fluid.span()
    rows = [fluid.properties(floats, t) for t in np.linspace(low, high, 4001).tolist()]
    found = np.array(rows)
    steps = np.abs(np.diff(found, axis=0)).max(axis=0)
    spans = np.ptp(found, axis=0) + 1e-6 * np.abs(found).max(axis=0)
    require_condition((steps <= 0.05 * spans).all(), "A property jumps with the temperature.")
