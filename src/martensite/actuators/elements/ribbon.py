"""Ribbon: equal parallel wires that warm each other.

All have one elongation; a longer wire is slack. The current flows through the first `heated` wires in series, the
others are passive. Between neighbours at the axis distance D the gap conducts

    G' (T_i - T_j),   G' = 2π k/acosh[(2 D² - d²)/d²]   per length,

the exact conduction between two parallel cylinders in a medium. Each wire loses heat to the ambient as if it were
alone, so this is an upper bound of the exchange.
"""

import math

from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.elements.cells import AbstractCells
from martensite.actuators.elements.columns import Cells, Links
from martensite.actuators.elements.network import Column, Linkage, ParallelCells
from martensite.actuators.elements.wire import Wire
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import Environment


@ELEMENTS.register("ribbon")
class Ribbon(AbstractCells):
    """Parallel wires that exchange heat."""

    passes = 3

    wires: str = option("number of wires", "2", "3", "4", "6", "8", default="2")
    heated: Number = param("1", "how many of them carry the current", low=1.0, high=8.0, typical=2.0)
    distance: Number = param("m", "distance of neighbouring axes", above=0.0, high=1.0, typical="1 mm")
    gap_conductivity: Number = param(
        "W/m/K", "thermal conductivity of what is between the wires (air 0.027)", low=0.0, high=1e3, default=0.027
    )
    wire: Wire = part("one of the wires", ELEMENTS)

    @override
    def check(self) -> None:
        self.require_cells()
        if self.heated != round(self.heated) or self.heated > int(self.wires):
            raise ParameterError(
                f"Parameter `heated` of `ribbon` must be a whole number of at most {self.wires}, "
                f"the number of wires, but is {self.heated:g}."
            )
        if self.distance <= self.wire.diameter:
            raise ParameterError(
                f"Parameter `distance` of `ribbon` must be above the diameter of its wires, "
                f"{1e3 * self.wire.diameter:.4g} mm, but is {1e3 * self.distance:.4g} mm."
            )

    @override
    def lengths(self, xp: Namespace) -> Column:
        return [self.wire.length for _ in range(int(self.wires))]

    def shares(self, xp: Namespace) -> Column:
        """Return 1 for wires in the circuit, 0 for the others."""
        return [xp.clip(self.heated - k, 0.0, 1.0) for k in range(int(self.wires))]

    @override
    def places(self) -> list[float]:
        return [k * self.distance for k in range(int(self.wires))]

    @override
    def links(self, xp: Namespace, fractions: Column) -> Links:
        ratio = self.distance / self.wire.diameter
        x = 2.0 * ratio * ratio - 1.0
        acosh = xp.log(x + xp.sqrt(x * x - 1.0))
        between = 2.0 * math.pi * self.gap_conductivity * self.wire.length / acosh
        count = int(self.wires)
        return Links([between] * (count - 1), [0.0] * count)

    @override
    def linkage(self) -> Linkage:
        return ParallelCells()

    @override
    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Cells:
        count = int(self.wires)
        memory = self.wire.init(xp, force * (1.0 / count), temperature).memory
        return Cells((memory,) * count, force)

    @override
    def heat_capacity_total(self) -> Scalar:
        return int(self.wires) * self.wire.heat_capacity_total()

    @override
    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        return int(self.wires) * self.wire.heat_loss(xp, temperature, environment)
