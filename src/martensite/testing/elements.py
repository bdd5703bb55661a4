"""Suite for elements, heat losses, ends, fluids, resistances and sources."""

import math

import numpy as np

from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base import units
from martensite.base.errors import UnitError
from martensite.kernels import floats
from martensite.physics.electrical.base import AbstractResistance, AbstractSource, Conductor
from martensite.physics.fluids.base import AbstractFluid
from martensite.physics.thermal.base import AbstractCooling, Cylinder, Environment
from martensite.physics.thermal.ends import AbstractEnds
from martensite.signals.moments import Moments
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_example


def check_heat_loss(element: AbstractElement) -> None:
    """Heat loss grows with the temperature of an element, and is zero at the ambient temperature."""
    around = build_example(Environment, temperature=295.0)
    flows = [element.heat_loss(floats, t, around) for t in TEMPERATURES.tolist()]
    require_condition((np.diff(flows) > 0.0).all(), "The heat loss falls as the element gets hotter.")
    left = element.heat_loss(floats, around.temperature, around)
    require_condition(left == 0.0, f"At the temperature around it, it loses {left:.4g} W.")


def check_capacity(element: AbstractElement) -> None:
    """Its heat capacity is positive, and its latent heat not negative."""
    capacity = element.heat_capacity_total()
    require_condition(capacity > 0.0, f"The heat capacity is {capacity} J/K.")
    if isinstance(element, AbstractLumped):
        latent = element.latent_heat_total(floats, 50e6, 330.0)
        require_condition(latent >= 0.0, f"The latent heat is {latent} J.")


def check_stiffness(element: AbstractElement) -> None:
    """An element gets longer under more force, and carries the force of its assembly."""
    state = element.init(floats, 2.0, 300.0)
    pull = element.force(state)
    require_condition(abs(pull - 2.0) < 1e-9, f"Assembled with 2 N, it holds {pull:.6g} N.")
    lengths = [element.elongation(floats, state, force) for force in (0.0, 1.0, 2.0, 3.0)]
    require_condition((np.diff(lengths) > 0.0).all(), "It does not get longer under more force.")


OHMS = (0.5, 5.0, 50.0)
SIGNALS = np.linspace(0.0, 20.0, 41).tolist()


def check_length(model: AbstractResistance) -> None:
    """A resistance is positive and grows with length."""
    for fraction in (0.0, 0.3, 1.0):
        short, long = (
            model.resistance(floats, fraction, 0.01, 330.0, Conductor(3e-8, length)) for length in (0.1, 0.2)
        )
        require_condition(
            0.0 < short < long, f"At a martensite fraction of {fraction} 0.1 m have {short:.4g} ohm, 0.2 m {long:.4g}."
        )


def check_unit(source: AbstractSource) -> None:
    """A source has a valid unit for its signal."""
    try:
        units.require_unit(source.unit)
    except UnitError as error:
        require_condition(False, str(error))
    both = source.sets_temperature == (source.unit == "K")
    require_condition(both, "A source sets the temperature if, and only if, its signal is in kelvin.")


def check_current(source: AbstractSource) -> None:
    """A source gives no current without a signal, and never less current for a larger signal."""
    for ohms in OHMS:
        currents = [source.current(floats, u, ohms) for u in SIGNALS]
        require_condition(currents[0] == 0.0, f"At a signal of 0 there are {currents[0]:.4g} A.")
        falls = np.diff(currents) < 0.0
        there = SIGNALS[int(np.argmax(falls))]
        require_condition(not falls.any(), f"At {ohms} ohm the current falls above a signal of {there:g}.")


def check_limits(source: AbstractSource) -> None:
    """A source respects its limits of current and voltage."""
    for ohms in OHMS:
        most = max(source.current(floats, u, ohms) for u in SIGNALS)
        limit = getattr(source, "current_limit", np.inf)
        require_condition(most <= limit, f"{most:.4g} A are above the `current_limit`.")
        volts = most * (ohms + getattr(source, "series_resistance", 0.0))
        limit = getattr(source, "voltage_limit", np.inf)
        require_condition(volts <= limit + 1e-12, f"{volts:.4g} V are above the `voltage_limit`.")


def check_heat(source: AbstractSource) -> None:
    """The heat of a constant signal is the power of its current."""
    if source.sets_temperature:
        return
    for ohms in OHMS:
        for u in SIGNALS[::8]:
            steady = Moments(u, u * u, u, u, 0.0, 0.0, 0.0)
            heat = source.heat(floats, steady, ohms).mean
            current = source.current(floats, u, ohms)
            power = current * current * ohms
            require_condition(
                abs(heat - power) <= 1e-9 * max(power, 1e-12),
                f"At a signal of {u:g} in {ohms} ohm the current brings {power:.6g} W, but `heat` says {heat:.6g} W.",
            )


AMBIENT = 295.0
TEMPERATURES = np.linspace(260.0, 450.0, 96)


def find_losses(cooling: AbstractCooling) -> np.ndarray:
    """Return the heat flux [W/m²] at all temperatures, for an ambient of 295 K."""
    shape = Cylinder(0.2e-3, 0.2)
    films = [cooling.film(floats, t, AMBIENT, shape) for t in TEMPERATURES.tolist()]
    return np.array(films) * (TEMPERATURES - AMBIENT)


def check_growth(cooling: AbstractCooling) -> None:
    """Heat loss grows with temperature."""
    falls = np.diff(find_losses(cooling)) <= 0.0
    hot = TEMPERATURES[int(np.argmax(falls))]
    require_condition(not falls.any(), f"In air of 295 K the heat loss falls above {hot:.0f} K.")


def check_side(cooling: AbstractCooling) -> None:
    """Heat flows to the colder side only."""
    wrong = np.sign(find_losses(cooling)) != np.sign(TEMPERATURES - AMBIENT)
    there = TEMPERATURES[int(np.argmax(wrong))]
    require_condition(not wrong.any(), f"At {there:.0f} K heat flows from the colder to the hotter side.")


def check_conductance(ends: AbstractEnds) -> None:
    """With ends, an element loses at least as much as through its surface, and more with a larger film coefficient."""
    for length in (1e-3, 0.02, 0.5):
        shape, before = Cylinder(0.2e-3, length), 0.0
        for film in (0.0, 1e-3, 5.0, 50.0, 500.0):
            conductance = ends.conductance(floats, film, shape)
            surface = film * math.pi * shape.diameter * shape.length
            words = f"At a film of {film:g} W/m²/K {length:g} m lose {conductance:.4g} W/K"
            require_condition(conductance >= surface * (1.0 - 1e-9), f"{words}, the surface {surface}.")
            require_condition(conductance >= before, f"{words}, less than at a smaller one.")
            before = conductance


def check_properties(fluid: AbstractFluid) -> None:
    """Conductivity, viscosity and Prandtl number are positive over the span."""
    low, high = fluid.span()
    require_condition(0.0 < low < high, f"Its span is {low:g} K to {high:g} K.")
    for kelvin in np.linspace(low, high, 60).tolist():
        values = fluid.properties(floats, kelvin)
        sound = all(math.isfinite(x) for x in values) and min(values[:3]) > 0.0
        require_condition(sound, f"At {kelvin:.0f} K its properties are {values}.")


def check_span(fluid: AbstractFluid) -> None:
    """Outside its span, properties equal those at the nearer end."""
    low, high = fluid.span()
    for beyond, end in ((0.1 * low, low), (10.0 * high, high)):
        same = fluid.properties(floats, beyond) == fluid.properties(floats, end)
        require_condition(same, f"At {beyond:.0f} K it is not as at {end:.0f} K.")


def check_smoothness(fluid: AbstractFluid) -> None:
    """Over the span no property jumps."""
    low, high = fluid.span()
    rows = [fluid.properties(floats, t) for t in np.linspace(low, high, 4001).tolist()]
    values = np.array(rows)
    steps = np.abs(np.diff(values, axis=0)).max(axis=0)
    spans = np.ptp(values, axis=0) + 1e-6 * np.abs(values).max(axis=0)
    require_condition((steps <= 0.05 * spans).all(), "A property jumps with the temperature.")
