"""The contract of an observer: readings and signals in, estimates of what no sensor sees out.

An observer carries a model, a system as it is believed to be, and goes along with the plant: in
every sample it gets the readings and the signals under which the plant has been since the last
one. It is a straight-line kernel and runs inside the loop of a bench. Its estimates are readings
called `estimated.NAME`, which a controller may follow: control without the sensor.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised, part
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar

OBSERVERS: Registry[AbstractObserver] = Registry("observer", "martensite.control.observers", typical="inverse-model")
Column: TypeAlias = Sequence[Scalar]
Named: TypeAlias = Mapping[str, Scalar]
ESTIMATED = "estimated."
"""Prefix of the names of estimates among the readings."""


class AbstractObserver(Parametrised):
    """Interface of an observer."""

    model: AbstractSystem = part("the system as it is believed to be")

    @abstractmethod
    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that it needs."""

    @abstractmethod
    def estimates(self) -> dict[str, Output]:
        """Return the estimates, by name."""

    def commands(self) -> tuple[str, str] | None:
        """Return the names of two estimates by which it commands a drive: whether it commands, and the signal."""
        return None

    @abstractmethod
    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        """Return the estimates and memory at the first sample, with the plant at rest."""

    @abstractmethod
    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        """Return the estimates of this sample, and the memory for the next sample.

        Args:
            xp: namespace.
            memory: from the sample before, or from `rest`.
            readings: by name, in SI, and the age of each, `NAME.age` [s].
            signals: by the name of the drive, as they have been since the sample before.
            dt: time since then [s].
            turns: in how many steps the model shall go.
        """


class ObserverPeriod(NamedTuple):
    """A period."""

    signals: Sequence[Scalar]
    """Signals of the drives of the model, in their order."""
    dt: Scalar
    """[s]"""
    turns: int
    """Steps of the model in it."""
    learning: Scalar = 1.0
    """By how much parameters may walk faster than usual."""

    @property
    def step(self) -> Scalar:
        """Return the length of a step [s]."""
        return self.dt / self.turns


def list_required(observer: AbstractObserver, signals: Named) -> list[Scalar]:
    """Return the signals of an observer's model, in order; raise `ParameterError` if the plant lacks one."""
    for drive in observer.model.drives():
        if drive.name not in signals:
            raise ParameterError(
                f"The model of observer `{observer.registered_name}` is driven by "
                f"`{drive.name}`, which the plant is not. {suggest_name(drive.name, signals)}"
            )
    return [signals[drive.name] for drive in observer.model.drives()]


def list_several(names: str | tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of one, or of several."""
    return (names,) if isinstance(names, str) else names
