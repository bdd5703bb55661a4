"""Independent rails on one bench: on each a wire lifts its own weight.

The rails share the environment, an optional supply, and the time of the controller. Each wire carries a constant force
m g and is never slack; inertia and friction of the carriages are neglected. Positions are zero as assembled and grow
with contraction.

Source: the test bench of Copaci, Moreno and Blanco (2019), section 2.2: three rails, wires of up to 0.27 m, up to 1 kg.
"""

from collections.abc import Sequence
from typing import Any

from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.mechanics.equal_elements import LoadLineEquation, answer_loads
from martensite.actuators.mechanisms.base import (
    MECHANISMS,
    AbstractMechanism,
    Column,
    Load,
    MechanicalEnergy,
    Mechanics,
    Output,
    Readout,
)
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_hanging
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column
from martensite.physics.laws.coupling import StepReport

PORTS = ("first", "second", "third")


@MECHANISMS.register("rails")
class Rails(AbstractMechanism):
    """Two or three parallel rails, each with a wire and a weight."""

    typical_scenario = "three_rails"

    cites = ("copaci2019",)

    rails: str = option("how many are in use", "3", "2", default="3")
    first_mass: Number = param("kg", "mass on the first rail", low=0.0, high=1e6, typical="500 g")
    second_mass: Number = param("kg", "mass on the second rail", low=0.0, high=1e6, typical="500 g")
    third_mass: Number = param("kg", "mass on the third rail", low=0.0, high=1e6, default=0.5, typical="500 g")
    gravity: Number = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)

    @override
    def ports(self) -> tuple[str, ...]:
        return PORTS[: int(self.rails)]

    @override
    def outputs(self) -> dict[str, Output]:
        return {f"{port}_position": Output("m", f"position on the {port} rail", "x") for port in self.ports()}

    @override
    def convergence_scales(self) -> dict[str, float]:
        return dict.fromkeys(self.outputs(), 1e-6)

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [getattr(self, f"{port}_mass") * self.gravity for port in self.ports()]

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> tuple[Scalar, ...]:
        """Return the elongations of the wires as assembled [m]."""
        return tuple(elongations)

    @override
    def advance(
        self, xp: Namespace, memory: tuple[Scalar, ...], loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[tuple[Scalar, ...], list[Any], StepReport]:
        lines = [LoadLineEquation(0.0, 1.0, 0.0, 0.0, weight) for weight in self.start_forces(xp)]
        responses = answer_loads(xp, loads, lines, dt)
        worst = responses[0].report
        for one in responses[1:]:
            worst = StepReport(*map(xp.maximum, worst, one.report))
        return memory, [one.state for one in responses], worst

    @override
    def observe(self, xp: Namespace, memory: tuple[Scalar, ...], loads: Sequence[Load], signals: Column) -> Readout:
        return [*self.start_forces(xp)], self._positions(xp, memory, loads)

    @override
    def mechanics(
        self, xp: Namespace, memory: tuple[Scalar, ...], loads: Sequence[Load], signals: Column
    ) -> Mechanics | None:
        lifts = self._positions(xp, memory, loads)
        energy = sum_column([weight * lift for weight, lift in zip(self.start_forces(xp), lifts, strict=True)])
        return Mechanics(MechanicalEnergy(gravity=energy), tuple(lifts))

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        return draw_hanging(self.ports(), [reading.outputs[name] for name in self.outputs()], [], reading)

    def _positions(self, xp: Namespace, memory: tuple[Scalar, ...], loads: Sequence[Load]) -> list[Scalar]:
        rows = zip(loads, self.start_forces(xp), memory, strict=True)
        return [home - one.element.elongation(xp, one.state, weight) for one, weight, home in rows]
