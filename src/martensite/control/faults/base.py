"""The contract of a fault: from one time to another, something on a bench is not as it should be.

A fault acts in one place: on the plant (its supply, its surroundings), on a signal on its way to
the source, or on a sensor. It is part of the traced loop: everything is a choice by `where`.
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
"""Difference of times that is rounding, for time is a sum of periods [s]."""


class AbstractFault(Parametrised):
    """Interface of a fault. A subclass overrides what it disturbs."""

    start: Number = param("s", "when it begins", low=0.0, default=0.0, typical="0.5 s")
    end: Number = param("s", "when it is over", above=0.0, default=math.inf, typical="1.5 s")

    def check(self) -> None:
        """Raise `ParameterError` unless it ends after it begins."""
        if not self.start < self.end:
            raise ParameterError(
                f"A fault must end after it begins, but begins at {self.start:g} s and ends at {self.end:g} s."
            )

    def active(self, xp: Namespace, time: Scalar) -> Flag:
        """Return whether the fault is present at a time [s]."""
        return xp.both(time >= self.start - TIME_TOLERANCE, time < self.end - TIME_TOLERANCE)

    def fault_at(self, xp: Namespace, time: Scalar) -> Self:
        """Return the fault as it is by a time [s]; itself unless it grows."""
        return self

    def names(self) -> dict[str, str]:
        """Return the names of sensors and drives in the fault -> `sensor` or `drive`; the bench checks them."""
        return {}

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """Return the plant with the fault in it."""
        return plant

    def signal(self, xp: Namespace, drive: str, signal: Scalar, active: Flag) -> Scalar:
        """Return the signal that arrives at the source of a drive."""
        return signal

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, held: Scalar, active: Flag) -> Scalar:
        """Return the reading of a sensor with the fault; `held` is the reading before."""
        return reading

    def disturb(self, xp: Namespace, sensor: str, reading: Scalar, number: Scalar, active: Flag) -> Scalar:
        """Return a reading, disturbed by the standard normal number of its noise; 0 in a run without noise."""
        return reading

    def travel(self, xp: Namespace, sensor: str, travel: Scalar, active: Flag) -> Scalar:
        """Return the travel time of a reading of a sensor [s], longer than normal by `latest` at most."""
        return travel

    def latest(self, sensor: str) -> float:
        """Return the largest additional travel time of a reading of a sensor [s]."""
        return 0.0

    def fresh(self, xp: Namespace, sensor: str, fresh: Flag, active: Flag) -> Flag:
        """Return whether there is a new reading of a sensor."""
        return fresh
