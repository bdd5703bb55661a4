"""Interface of an observer: readings and signals in, estimates of unmeasured quantities out.

An observer carries a model of the plant: in every sample it gets the readings, and the signals since the last sample.
It is a straight-line kernel and runs inside the loop of a bench. Its estimates are readings `estimated.NAME`, which a
controller may follow.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
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

    model: AbstractSystem = part("model of the system")

    @abstractmethod
    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that it needs."""

    @abstractmethod
    def estimates(self) -> dict[str, Output]:
        """Return the estimates by name."""

    def commands(self) -> tuple[str, str] | None:
        """Return the names of two estimates (active, signal) by which it commands a drive, or None."""
        return None

    @abstractmethod
    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        """Return estimates and memory at the first sample, with the plant in the steady state."""

    @abstractmethod
    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        """Return the estimates of this sample, and the new memory.

        Args:
            xp: namespace.
            memory: memory after the last sample, or from `rest`.
            readings: readings by name, in SI, and the age of each, `NAME.age` [s].
            signals: signals since the last sample, by drive.
            dt: time since the last sample [s].
            turns: number of steps of the model.
        """


class ObserverPeriod(NamedTuple):
    """Signals and length of a period."""

    signals: Sequence[Scalar]
    """Signals of the drives of the model, in their order."""
    dt: Scalar
    """[s]"""
    turns: int
    """Steps of the model."""
    learning: Scalar = 1.0
    """Factor of the random walks of parameters."""
    surprise: Scalar = 0.0
    """0 if the last readings fit the model, up to 1 if they contradict it."""

    @property
    def step(self) -> Scalar:
        """Return the length of a step [s]."""
        return self.dt / self.turns


def list_required(observer: AbstractObserver, signals: Named) -> list[Scalar]:
    """Return the signals of the model of an observer, in order; raise `ParameterError` if the plant lacks one."""
    for drive in observer.model.drives():
        if drive.name not in signals:
            raise ParameterError(
                f"The model of observer `{observer.registered_name}` is driven by "
                f"`{drive.name}`, which the plant is not. {suggest_name(drive.name, signals)}"
            )
    return [signals[drive.name] for drive in observer.model.drives()]


def require_outputs(observer: AbstractObserver, names: Iterable[str]) -> None:
    """Raise `ParameterError` if the model of an observer lacks an output."""
    outputs = list(observer.model.outputs())
    for name in names:
        if name not in outputs:
            raise ParameterError(
                f"Observer `{observer.registered_name}`: its model has no output `{name}`. "
                f"{suggest_name(name, outputs)}"
            )


def list_several(names: str | tuple[str, ...]) -> tuple[str, ...]:
    """Return one or several names as a tuple."""
    return (names,) if isinstance(names, str) else names
