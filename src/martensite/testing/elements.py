"""What every element promises: heat to the colder side, capacities, and a heat that adds up."""

from __future__ import annotations

import numpy as np

from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.kernels import floats
from martensite.physics.thermal.base import Environment
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_example
from martensite.testing.heat_losses import TEMPERATURES


def check_heat_loss(element: AbstractElement) -> None:
    """An element loses more heat the hotter it is, and none at the temperature around it."""
    around = build_example(Environment, temperature=295.0)
    flows = [element.heat_loss(floats, t, around) for t in TEMPERATURES.tolist()]
    require_condition((np.diff(flows) > 0.0).all(), "The heat loss falls as the element gets hotter.")
    left = element.heat_loss(floats, around.temperature, around)
    require_condition(left == 0.0, f"At the temperature around it, it loses {left:.4g} W.")


def check_capacity(element: AbstractElement) -> None:
    """Its heat capacity is above zero, and its latent heat not below."""
    found = element.heat_capacity_total()
    require_condition(found > 0.0, f"The heat capacity is {found} J/K.")
    if isinstance(element, AbstractLumped):
        latent = element.latent_heat_total(floats, 50e6, 330.0)
        require_condition(latent >= 0.0, f"The latent heat is {latent} J.")


def check_stiffness(element: AbstractElement) -> None:
    """It gets longer under more force, and holds the force with which it is assembled."""
    state = element.init(floats, 2.0, 300.0)
    held = element.force(state)
    require_condition(abs(held - 2.0) < 1e-9, f"Assembled with 2 N, it holds {held:.6g} N.")
    lengths = [element.elongation(floats, state, force) for force in (0.0, 1.0, 2.0, 3.0)]
    require_condition((np.diff(lengths) > 0.0).all(), "It does not get longer under more force.")
