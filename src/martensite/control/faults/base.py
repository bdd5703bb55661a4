"""Interface of a fault: a disturbance of a bench from one time to another.

A fault acts on the plant (its supply or environment), on the signal that reaches the source, or on a sensor. It is
part of the traced loop, so every choice is a `where`.
"""

from __future__ import annotations

import math
from typing import Self

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param
from martensite.base.registry import Registry
from martensite.kernels.namespace import Flag, Namespace, Scalar

FAULTS: Registry[AbstractFault] = Registry("fault", "martensite.control.faults", typical="stuck")
TIME_TOLERANCE = 1e-7
"""Rounding error of times, which are sums of periods [s]."""


class AbstractFault(Parametrised):
    """Interface of a fault; a subclass overrides the quantity that it disturbs."""

    start: Number = param("s", "when it begins", low=0.0, default=0.0, typical="0.5 s")
    end: Number = param("s", "when it is over", above=0.0, default=math.inf, typical="1.5 s")

    def check(self) -> None:
        if not self.start < self.end:
            raise ParameterError(
                f"A fault must end after it begins, but begins at {self.start:g} s and ends at {self.end:g} s."
            )

    def active(self, xp: Namespace, time: Scalar) -> Flag:
        """Return whether the fault is active at a time [s]."""
        return xp.both(time >= self.start - TIME_TOLERANCE, time < self.end - TIME_TOLERANCE)

    def fault_at(self, xp: Namespace, time: Scalar) -> Self:
        """Return the fault as it has grown by a time [s]; by default unchanged."""
        return self

    def names(self) -> dict[str, str]:
        """Return `sensor` or `drive` by the name of each sensor and drive that the fault uses."""
        return {}

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """Return the plant with the fault."""
        return plant

    def signal(self, xp: Namespace, drive: str, signal: Scalar, active: Flag) -> Scalar:
        """Return the signal that arrives at the source of a drive."""
        return signal

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, last_reading: Scalar, active: Flag) -> Scalar:
        """Return the reading of a sensor with the fault; `last_reading` is the last reading."""
        return reading

    def disturb(self, xp: Namespace, sensor: str, reading: Scalar, number: Scalar, active: Flag) -> Scalar:
        """Return a reading with a disturbance; `number` is the standard normal number of its noise, 0 without noise."""
        return reading

    def travel(self, xp: Namespace, sensor: str, travel: Scalar, active: Flag) -> Scalar:
        """Return the delay of a reading [s], longer than without the fault by `latest` at most."""
        return travel

    def latest(self, sensor: str) -> float:
        """Return the largest additional delay of a reading of a sensor [s]."""
        return 0.0

    def fresh(self, xp: Namespace, sensor: str, fresh: Flag, active: Flag) -> Flag:
        """Return whether the sensor has a new reading."""
        return fresh
