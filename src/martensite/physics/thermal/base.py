"""What every heat-loss model answers: the film coefficient h(T) over the lateral surface."""

from __future__ import annotations

from abc import abstractmethod
from typing import NamedTuple

from martensite.base.parameters import Parametrised, param, part
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.base import AbstractFluid

COOLING: Registry[AbstractCooling] = Registry("cooling", "martensite.physics.thermal", typical="constant")


class Cylinder(NamedTuple):
    """The shape that loses heat through its lateral surface [m]."""

    diameter: Scalar
    length: Scalar


class AbstractCooling(Parametrised):
    """Interface of a heat-loss model."""

    @abstractmethod
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """Film coefficient h [W/(m² K)] of a cylinder at `temperature` in `ambient` [K]."""


class Environment(Parametrised):
    """What surrounds the element."""

    temperature: Scalar = param("K", "ambient temperature", low=100.0, high=1000.0, default=293.15)
    cooling: AbstractCooling = part("heat-loss model", COOLING)

    def cautions(self) -> list[str]:
        """An ambient temperature at which the properties of a fluid are not known."""
        fluids = [item for item in self.cooling.tree() if isinstance(item, AbstractFluid)]
        outside = [f for f in fluids if not f.span()[0] <= self.temperature <= f.span()[1]]
        return [
            f"Ambient temperature {self.temperature:.2f} K lies outside the {f.span()[0]:.2f} K to {f.span()[1]:.2f} K "
            f"over which `{f.registered_name}` is known; its properties are held at the nearer end."
            for f in outside
        ]
