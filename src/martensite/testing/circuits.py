"""What every resistance and every source promises."""

from __future__ import annotations

import numpy as np

from martensite.base import units
from martensite.base.errors import UnitError
from martensite.kernels import floats
from martensite.physics.electrical.base import AbstractResistance, AbstractSource, Conductor
from martensite.signals.moments import Moments
from martensite.testing.conformance import require_condition

OHMS = (0.5, 5.0, 50.0)
SIGNALS = np.linspace(0.0, 20.0, 41).tolist()


def check_length(model: AbstractResistance) -> None:
    """A resistance is above zero and grows with length."""
    for fraction in (0.0, 0.3, 1.0):
        short, long = (
            model.resistance(floats, fraction, 0.01, 330.0, Conductor(3e-8, length)) for length in (0.1, 0.2)
        )
        require_condition(
            0.0 < short < long, f"At a martensite fraction of {fraction} 0.1 m have {short:.4g} ohm, 0.2 m {long:.4g}."
        )


def check_unit(source: AbstractSource) -> None:
    """A source says in which unit its signal is."""
    try:
        units.require_unit(source.unit)
    except UnitError as error:
        require_condition(False, str(error))
    both = source.sets_temperature == (source.unit == "K")
    require_condition(both, "A source sets the temperature if, and only if, its signal is in kelvin.")


def check_current(source: AbstractSource) -> None:
    """Without a signal there is no current, and never less for more."""
    for ohms in OHMS:
        currents = [source.current(floats, u, ohms) for u in SIGNALS]
        require_condition(currents[0] == 0.0, f"At a signal of 0 there are {currents[0]:.4g} A.")
        falls = np.diff(currents) < 0.0
        there = SIGNALS[int(np.argmax(falls))]
        require_condition(not falls.any(), f"At {ohms} ohm the current falls above a signal of {there:g}.")


def check_limits(source: AbstractSource) -> None:
    """Where a source has limits of current and voltage, it keeps to them."""
    for ohms in OHMS:
        most = max(source.current(floats, u, ohms) for u in SIGNALS)
        limit = getattr(source, "current_limit", np.inf)
        require_condition(most <= limit, f"{most:.4g} A are above the `current_limit`.")
        volts = most * (ohms + getattr(source, "series_resistance", 0.0))
        limit = getattr(source, "voltage_limit", np.inf)
        require_condition(volts <= limit + 1e-12, f"{volts:.4g} V are above the `voltage_limit`.")


def check_heat(source: AbstractSource) -> None:
    """A steady signal brings the heat of its current."""
    if source.sets_temperature:
        return
    for ohms in OHMS:
        for u in SIGNALS[::8]:
            steady = Moments(u, u * u, u, u, 0.0, 0.0, 0.0)
            found = source.heat(floats, steady, ohms).mean
            current = source.current(floats, u, ohms)
            power = current * current * ohms
            require_condition(
                abs(found - power) <= 1e-9 * max(power, 1e-12),
                f"At a signal of {u:g} in {ohms} ohm the current brings {power:.6g} W, but `heat` says {found:.6g} W.",
            )
