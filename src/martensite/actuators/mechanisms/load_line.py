"""Load lines: mechanisms of one element and one coordinate that answer in closed form.

An element at frozen fractions and temperature has elongation = free + compliance · force. The mechanism closes the
loop: it returns the force at which both fit. It is assembled with the element in its initial state, which defines
position zero. Position grows as the element shortens. Inertia is left out.
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
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport


class LoadLineReference(NamedTuple):
    """Memory of a load line from its assembly."""

    elongation: Scalar
    """Elongation of the element at position zero [m]."""


class AbstractLoadLine(AbstractMechanism):
    """Interface of a quasi-static mechanism with one element and one coordinate."""

    static = True

    @abstractmethod
    def start_force(self, xp: Namespace) -> Scalar:
        """Return the force [N] on the element when it is assembled."""

    @abstractmethod
    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """Return the force [N] at which element and mechanism fit; never below zero."""

    @abstractmethod
    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Return the coordinate of the mechanism [m]; zero at assembly, growing with contraction."""

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy | None:
        """Return the energy if the path of the element is shorter than at assembly by a length [m].

        None, and no balance of the work, if the mechanism does not say.
        """
        return None

    def outputs(self) -> dict[str, Output]:
        """Return the position."""
        return {"position": Output("m", "position of the mechanism", "x")}

    def convergence_scales(self) -> dict[str, float]:
        """Return the position."""
        return {"position": 1e-6}

    def start_forces(self, xp: Namespace) -> Column:
        """Return the start force [N]."""
        return [self.start_force(xp)]

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> LoadLineReference:
        """Return the elongation of the element as assembled."""
        return LoadLineReference(elongations[0])

    def advance(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[LoadLineReference, list[object], StepReport]:
        """Return the element solves the step by itself, against the load line."""
        ((element, state, heating),) = loads
        pull = self.load_line(memory)
        after, report = element.advance(xp, state, heating, pull, dt)
        return memory, [after], report

    def observe(self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column) -> Readout:
        """Return the force at which both fit, and the position there."""
        (load,) = loads
        force = load.meet_pull(xp, self.load_line(memory))
        elongation = load.element.elongation(xp, load.state, force)
        return [force], [self.position(xp, memory, force, elongation)]

    def mechanics(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column
    ) -> Mechanics | None:
        """Return its energy at the end of the last step; it has no friction."""
        ((element, state, _),) = loads
        force = element.force(state)
        elongation = element.elongation(xp, state, force)
        slack = self.position(xp, memory, force, elongation)
        way = xp.where(force > 0.0, memory.elongation - elongation, slack)
        found = self.energy(xp, way)
        return None if found is None else Mechanics(found, (way,))

    def load_line(self, memory: LoadLineReference) -> Pull:
        """Return the mechanism as the element sees it."""

        def pull(xp: Namespace, spring: Spring) -> Scalar:
            return self.force(xp, memory, spring)

        return pull


@MECHANISMS.register("dead-weight")
class DeadWeight(AbstractLoadLine):
    """A hanging mass; inertia is left out, and the wire is never slack."""

    mass: Number = param("kg", "hanging mass", low=0.0, high=1e6, typical="200 g")
    gravity: Number = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)

    def start_force(self, xp: Namespace) -> Scalar:
        """Return the weight m g [N]."""
        return self.mass * self.gravity

    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """Return the weight m g [N]."""
        return self.start_force(xp)

    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Lift of the mass [m]."""
        return assembly.elongation - elongation

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy:
        """m g times the lift [J]."""
        return MechanicalEnergy(gravity=self.start_force(xp) * shortening)

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Return the element hangs from a ceiling, the mass from the element."""
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
    """A linear return spring with preload.

        F = F₀ + k x while positive;   F = 0 when the element is slack

    with F₀ the preload at assembly and x the position. Neither wire nor spring can push.
    """

    stiffness: Number = param("N/m", "spring rate", above=0.0, high=1e9, typical="150 N/m")
    preload: Number = param("N", "force at assembly", low=0.0, high=1e6, default=0.0, typical="1.5 N")

    def start_force(self, xp: Namespace) -> Scalar:
        """Return the preload [N]."""
        return self.preload

    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """Return the intersection of the two straight lines [N]; zero if they meet in compression."""
        pull = self.preload + self.stiffness * (assembly.elongation - spring.free)
        return xp.maximum(pull / (1.0 + self.stiffness * spring.compliance), 0.0)

    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Return the shortening of the spring's path [m]; the spring's own length when slack."""
        return (force - self.preload) * (1.0 / self.stiffness)

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy:
        """½ F²/k [J]."""
        pull = xp.maximum(self.preload + self.stiffness * shortening, 0.0)
        return MechanicalEnergy(springs=(0.5 / self.stiffness) * pull * pull)

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Element and spring in a row between two walls; the spring's own length is not known."""
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
