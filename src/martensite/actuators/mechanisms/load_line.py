"""Load lines: mechanisms of one element and one coordinate in closed form.

An element at frozen fractions and temperature has elongation = free + compliance · force; the mechanism returns the
equilibrium force. It is assembled with the element in its initial state, at position zero. Position grows as the
element shortens. Inertia is neglected.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.elements.base import AbstractElement, Pull, Spring
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
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar, draw_weight
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport


class LoadLineReference(NamedTuple):
    """Memory of a load line from its assembly."""

    elongation: Scalar
    """Elongation of the element at position zero [m]."""


class AbstractLoadLine(AbstractMechanism):
    """Quasi-static mechanism with one element and one coordinate."""

    static = True

    @abstractmethod
    def start_force(self, xp: Namespace) -> Scalar:
        """Return the force [N] on the element at assembly."""

    @abstractmethod
    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """Return the equilibrium force [N] of element and mechanism; never below zero."""

    @abstractmethod
    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Return the coordinate of the mechanism [m]; zero at assembly, growing with contraction."""

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy | None:
        """Return the energy at a shortening of the path since assembly [m]; None means no work balance."""
        return None

    @override
    def outputs(self) -> dict[str, Output]:
        return {"position": Output("m", "position of the mechanism", "x")}

    @override
    def convergence_scales(self) -> dict[str, float]:
        return {"position": 1e-6}

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [self.start_force(xp)]

    @override
    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> LoadLineReference:
        return LoadLineReference(elongations[0])

    @override
    def advance(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[LoadLineReference, list[object], StepReport]:
        ((element, state, heating),) = loads
        pull = self.load_line(memory)
        after, report = element.advance(xp, state, heating, pull, dt)
        return memory, [after], report

    @override
    def observe(self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column) -> Readout:
        (load,) = loads
        force = load.meet_pull(xp, self.load_line(memory))
        elongation = load.element.elongation(xp, load.state, force)
        return [force], [self.position(xp, memory, force, elongation)]

    @override
    def mechanics(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column
    ) -> Mechanics | None:
        ((element, state, _),) = loads
        force = element.force(state)
        elongation = element.elongation(xp, state, force)
        slack = self.position(xp, memory, force, elongation)
        way = xp.where(force > 0.0, memory.elongation - elongation, slack)
        energy = self.energy(xp, way)
        return None if energy is None else Mechanics(energy, (way,))

    @override
    def load_line(self, memory: LoadLineReference) -> Pull:
        def pull(xp: Namespace, spring: Spring) -> Scalar:
            return self.force(xp, memory, spring)

        return pull


@MECHANISMS.register("dead-weight")
class DeadWeight(AbstractLoadLine):
    """Hanging mass without inertia; the wire is never slack."""

    mass: Number = param("kg", "hanging mass", low=0.0, high=1e6, typical="200 g")
    gravity: Number = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)

    def start_force(self, xp: Namespace) -> Scalar:
        """Return the weight m g [N]."""
        return self.mass * self.gravity

    @override
    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        return self.start_force(xp)

    @override
    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        return assembly.elongation - elongation

    @override
    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy:
        return MechanicalEnergy(gravity=self.start_force(xp) * shortening)

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        hung = reading.lengths["element"]
        end = (0.0, 0.0, reading.outputs["position"] - hung)
        wide, thick = 0.2 * hung, 0.015 * hung
        return [
            draw_bar("ceiling", thick, (-wide, 0.0, thick), (wide, 0.0, thick), kind="wall"),
            DrawingShape("element", "wire", ((0.0, 0.0, 0.0), end), 0.0, "element"),
            draw_weight("weight", end, self.mass, 0.02 * hung, 0.15 * hung),
        ]


@MECHANISMS.register("bias-spring")
class BiasSpring(AbstractLoadLine):
    """Linear return spring with preload.

        F = F₀ + k x while positive;   F = 0 when the element is slack

    with the preload F₀ at assembly and the position x. Neither wire nor spring can push.
    """

    stiffness: Number = param("N/m", "spring rate", above=0.0, high=1e9, typical="150 N/m")
    preload: Number = param("N", "force at assembly", low=0.0, high=1e6, default=0.0, typical="1.5 N")

    @override
    def start_force(self, xp: Namespace) -> Scalar:
        return self.preload

    @override
    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        pull = self.preload + self.stiffness * (assembly.elongation - spring.free)
        return xp.maximum(pull / (1.0 + self.stiffness * spring.compliance), 0.0)

    @override
    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        return (force - self.preload) * (1.0 / self.stiffness)

    @override
    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy:
        pull = xp.maximum(self.preload + self.stiffness * shortening, 0.0)
        return MechanicalEnergy(springs=(0.5 / self.stiffness) * pull * pull)

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        element = reading.lengths["element"]
        end, far, tall = element - reading.outputs["position"], 1.6 * element, 0.1 * element
        thick = 0.012 * element
        near_wall = ((-thick, 0.0, -tall), (-thick, 0.0, tall))
        far_wall = ((far + thick, 0.0, -tall), (far + thick, 0.0, tall))
        return [
            draw_bar("wall", thick, *near_wall, kind="wall"),
            draw_bar("wall of the spring", thick, *far_wall, kind="wall"),
            DrawingShape("element", "wire", ((0.0, 0.0, 0.0), (end, 0.0, 0.0)), 0.0, "element"),
            DrawingShape("slider", "slider", ((end, 0.0, 0.0),), 0.02 * element),
            DrawingShape("spring", "spring", ((end, 0.0, 0.0), (far, 0.0, 0.0)), 0.04 * element),
        ]
