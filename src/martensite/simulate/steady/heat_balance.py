r"""Steady temperature and film coefficient of an element under constant power.

In the steady state, the power P equals the heat loss. With the film coefficient h(T) and the lateral surface S,

P = h(T) S (T - T_a) + loss at the ends

The right-hand side rises with T, so each power has one temperature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.errors import InputError, ParameterError, require_known
from martensite.kernels import floats
from martensite.kernels.brent import find_root
from martensite.physics.thermal.base import Cylinder, Environment

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

Subject: TypeAlias = "Scenario | AbstractSystem | Actuator | Cylinder"

HOTTEST = 1e5
"""Upper end of the search for a temperature, above ambient [K]."""


def find_steady_temperature(
    subject: Subject, power: float, *, environment: Environment | None = None, port: str | None = None
) -> float:
    """Return the temperature [K] at which an element loses a power [W], including losses at its ends.

    Args:
        subject: a scenario, a system, an actuator, or a bare cylinder (`ms.thermal.Cylinder`).
        power: heating power [W]; below 0 for cooling.
        environment: environment of a bare cylinder; for all others it replaces their environment.
        port: port of the element in a system with several; the first if not named.

    Raises:
        InputError: the element or the environment is missing, or the port does not exist.
        ParameterError: no temperature is that high, or low enough.
    """
    one = _HeatedPart.read(subject, environment, port)
    ambient = float(one.environment.temperature)

    def missing(temperature: float) -> float:
        return one.heat_loss(temperature) - power

    if missing(ambient) == 0.0:
        return ambient
    side = math.copysign(1.0, power)
    reach = 1.0
    while missing(max(ambient + side * reach, 1e-3)) * side < 0.0:
        reach *= 2.0
        if reach > HOTTEST:
            raise ParameterError(f"The element loses less than {abs(power):g} W at every temperature.")
    ends = sorted((ambient, max(ambient + side * reach, 1e-3)))
    return find_root(missing, *ends, relative=1e-14)


def find_film_coefficient(
    subject: Subject,
    power: float | None = None,
    *,
    temperature: float | None = None,
    environment: Environment | None = None,
    port: str | None = None,
) -> float:
    """Return the film coefficient [W/(m² K)] of an element at its steady temperature, or at a given temperature.

    Args:
        subject: a scenario, a system, an actuator, or a bare cylinder (`ms.thermal.Cylinder`).
        power: heating power [W].
        temperature: temperature of the element [K], in place of the power.
        environment: environment of a bare cylinder; for all others it replaces their environment.
        port: port of the element in a system with several; the first if not named.

    Raises:
        InputError: not exactly one of power and temperature is given, or the element does not exist.
        ParameterError: no temperature is high enough for the power.
    """
    one = _HeatedPart.read(subject, environment, port)
    if temperature is None and power is not None:
        temperature = find_steady_temperature(subject, power, environment=environment, port=port)
    elif temperature is None or power is not None:
        raise InputError("A film coefficient belongs to a power or to a temperature; give one of them.")
    return one.film(temperature)


@dataclass(frozen=True)
class _HeatedPart:
    """Part with heat loss, and its environment."""

    element: Any
    """Element; None for a bare cylinder."""
    shape: Cylinder
    environment: Environment

    @classmethod
    def read(cls, subject: Subject, environment: Environment | None, port: str | None) -> _HeatedPart:
        if isinstance(subject, Cylinder):
            if environment is None:
                raise InputError("A bare cylinder loses heat to an `environment`, which is not given.")
            return cls(None, subject, environment)
        one = _find_actuator(subject, port)
        wire: Any = getattr(one.element, "wire", one.element)
        return cls(one.element, wire.cylinder(), environment or one.environment)

    def film(self, temperature: float) -> float:
        """Return the film coefficient h(T) [W/(m² K)]."""
        ambient = self.environment.temperature
        return float(self.environment.cooling.film(floats, temperature, ambient, self.shape))

    def heat_loss(self, temperature: float) -> float:
        """Return the heat flow to ambient [W]."""
        if self.element is not None:
            return float(self.element.heat_loss(floats, temperature, self.environment))
        surface = math.pi * self.shape.diameter * self.shape.length
        return self.film(temperature) * surface * (temperature - float(self.environment.temperature))


def _find_actuator(subject: Scenario | AbstractSystem | Actuator, port: str | None) -> Actuator:
    """Return the element in its environment."""
    if not isinstance(subject, Actuator):
        system = subject if isinstance(subject, AbstractSystem) else subject.system
        actuators = system.actuators()
        if not actuators:
            raise InputError("This system has no element that could be heated.")
        if port is not None:
            require_known("port", port, list(actuators))
        return actuators[port or next(iter(actuators))]
    return subject
