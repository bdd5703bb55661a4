"""How the model of an observer goes along with the plant through a period."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.observers.base import AbstractObserver, Named
from martensite.kernels.namespace import Scalar


class ObserverPeriod(NamedTuple):
    """A period."""

    signals: Sequence[Scalar]
    """Of the drives of the model, in their order."""
    dt: Scalar
    """[s]"""
    turns: int
    """Steps of the model in it."""

    @property
    def step(self) -> Scalar:
        """Length of a step [s]."""
        return self.dt / self.turns


def list_required(observer: AbstractObserver, signals: Named) -> list[Scalar]:
    """Signals of the model of an observer, in their order.

    Raises:
        ParameterError: the plant has no signal of that name.
    """
    for drive in observer.model.drives():
        if drive.name not in signals:
            raise ParameterError(
                f"The model of observer `{observer.registered_name}` is driven by "
                f"`{drive.name}`, which the plant is not. {suggest_name(drive.name, signals)}"
            )
    return [signals[drive.name] for drive in observer.model.drives()]


def list_several(names: str | tuple[str, ...]) -> tuple[str, ...]:
    """Names of one, or of several."""
    return (names,) if isinstance(names, str) else names
