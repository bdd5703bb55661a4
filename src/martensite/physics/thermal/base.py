"""Interface of a heat-loss model: the film coefficient h(T) over the lateral surface.

A model may have a drive signal, such as the air speed of a fan (`active_cooling`). Heat that does not depend on the
ambient temperature is reported separately (`pump_heat`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import NamedTuple, Self

from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, param, part
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.base import AbstractFluid
from martensite.signals.moments import Moments

COOLING: Registry[AbstractCooling] = Registry("cooling", "martensite.physics.thermal", typical="constant")


class Cylinder(NamedTuple):
    """Shape that loses heat through its lateral surface [m]."""

    diameter: Scalar
    length: Scalar


class AbstractCooling(Parametrised):
    """Interface of a heat-loss model."""

    @abstractmethod
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Return the film coefficient h [W/(m² K)] of a cylinder at `temperature` in `ambient` [K]."""

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        """Return the heat flow [W] in addition to the film; None without such a flow."""
        return None

    def signals(self) -> dict[str, str]:
        """Return the names and units of its drive signals, including nested models."""
        return {name: unit for _, model in self._models() for name, unit in model.signals().items()}

    def with_signals(self, xp: Namespace, signals: Mapping[str, Scalar | Moments]) -> AbstractCooling:
        """Return the model with the present values of its signals, at an instant or over a step."""
        return self.drive_models(xp, signals)

    def drive_models(self, xp: Namespace, signals: Mapping[str, Scalar | Moments]) -> Self:
        """Return this model with its nested models under their signals."""
        driven = {name: model.with_signals(xp, signals) for name, model in self._models() if model.signals()}
        return self.rebuilt(driven) if driven else self

    def _models(self) -> Iterator[tuple[str, AbstractCooling]]:
        return ((name, child) for name, child in self.children() if isinstance(child, AbstractCooling))


class Environment(Parametrised):
    """Environment of the element."""

    temperature: Number = param("K", "ambient temperature", low=100.0, high=1000.0, default=293.15)
    cooling: AbstractCooling = part("heat-loss model", COOLING)

    @override
    def cautions(self) -> list[str]:
        fluids = [item for item in self.cooling.tree() if isinstance(item, AbstractFluid)]
        outside = [f for f in fluids if not f.span()[0] <= self.temperature <= f.span()[1]]
        return [
            f"Ambient temperature {self.temperature:.2f} K lies outside the {f.span()[0]:.2f} K to {f.span()[1]:.2f} K "
            f"over which `{f.registered_name}` is known; its properties are held at the nearer end."
            for f in outside
        ]
