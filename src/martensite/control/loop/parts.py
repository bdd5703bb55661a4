"""What a bench is made of, by name, and what its parts remember."""

from __future__ import annotations

from typing import Any, NamedTuple

from martensite.actuators.assembly import Members
from martensite.control.controllers.base import AbstractController
from martensite.control.faults.base import AbstractFault
from martensite.control.loop.mounted_sensor import MountedSensor, Sensed
from martensite.control.observers.base import AbstractObserver
from martensite.kernels.namespace import Scalar

Named = dict[str, Scalar]


class Sensors(Members[MountedSensor], init=False):
    """Sensors by name: what a controller calls their readings."""

    noun, kind = "sensor", MountedSensor


class Observers(Members[AbstractObserver], init=False):
    """Observers by name."""

    noun, kind = "observer", AbstractObserver


class Controllers(Members[AbstractController], init=False):
    """Controllers by the name of the drive that they have."""

    noun, kind = "controller", AbstractController


class FaultTable(Members[AbstractFault], init=False):
    """Faults by name."""

    noun, kind = "fault", AbstractFault


class ObserverState(NamedTuple):
    """State of an observer."""

    estimates: tuple[Scalar, ...]
    memory: tuple[Scalar, ...]


class Controlling(NamedTuple):
    """State of a controller."""

    wanted: Scalar
    memory: tuple[Scalar, ...]


class BenchState(NamedTuple):
    """All that changes in time."""

    time: Scalar
    plant: Any
    sensors: tuple[Sensed, ...]
    observers: tuple[ObserverState, ...]
    controllers: tuple[Controlling, ...]
    supervisor: tuple[Scalar, ...]


class Inputs(NamedTuple):
    """What drives a bench, by where it goes."""

    references: tuple[Scalar, ...]
    free: Named
    """Signals of the plant that no controller has."""
    numbers: tuple[tuple[Scalar, Scalar], ...]
    """Normal numbers for noise and jitter of every sensor."""
