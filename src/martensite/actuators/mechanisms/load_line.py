"""Load lines: mechanisms of one element and one coordinate that answer in closed form.

An element at frozen fractions and temperature has elongation = free + compliance · force. The mechanism closes the
loop: it returns the force at which both fit. It is assembled with the element in its initial state, which defines
position zero. Position grows as the element shortens. Inertia is left out.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.elements.base import AbstractElement, Pull, Spring, equilibrium_force
from martensite.actuators.mechanisms.base import AbstractMechanism, Column, Load, MechanicalEnergy, Mechanics, Output
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport


class LoadLineReference(NamedTuple):
    """What a load line remembers of being assembled."""

    elongation: Scalar
    """Elongation of the element at position zero [m]."""


class AbstractLoadLine(AbstractMechanism):
    """Interface of a quasi-static mechanism with one element and one coordinate."""

    static = True

    @abstractmethod
    def start_force(self, xp: Namespace) -> Scalar:
        """Force [N] on the element when it is assembled."""

    @abstractmethod
    def force(self, xp: Namespace, assembly: LoadLineReference, spring: Spring) -> Scalar:
        """Force [N] at which element and mechanism fit; never below zero."""

    @abstractmethod
    def position(self, xp: Namespace, assembly: LoadLineReference, force: Scalar, elongation: Scalar) -> Scalar:
        """Coordinate of the mechanism [m]; zero at assembly, growing with contraction."""

    def energy(self, xp: Namespace, shortening: Scalar) -> MechanicalEnergy | None:
        """What it holds if the path of the element is shorter by so much than at assembly [m].

        None, and no balance of the work, if the mechanism does not say.
        """
        return None

    def outputs(self) -> dict[str, Output]:
        """The position."""
        return {"position": Output("m", "position of the mechanism", "x")}

    def convergence_scales(self) -> dict[str, float]:
        """The position."""
        return {"position": 1e-6}

    def start_forces(self, xp: Namespace) -> Column:
        """The start force [N]."""
        return [self.start_force(xp)]

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> LoadLineReference:
        """The elongation of the element as assembled."""
        return LoadLineReference(elongations[0])

    def advance(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[LoadLineReference, list[object], StepReport]:
        """The element solves the step by itself, against the load line."""
        ((element, state, heating),) = loads
        pull = self.load_line(memory)
        after, report = element.advance(xp, state, heating, pull, dt)
        return memory, [after], report

    def observe(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """The force at which both fit, and the position there."""
        ((element, state, _),) = loads

        def tangent(xp: Namespace, force: Scalar) -> Spring:
            return element.tangent(xp, state, force)

        force = equilibrium_force(xp, tangent, self.load_line(memory), element.force(state), element.passes)
        elongation = element.elongation(xp, state, force)
        return [force], [self.position(xp, memory, force, elongation)]

    def mechanics(
        self, xp: Namespace, memory: LoadLineReference, loads: Sequence[Load], signals: Column
    ) -> Mechanics | None:
        """Its energy at the end of the last step; it has no friction."""
        ((element, state, _),) = loads
        force = element.force(state)
        elongation = element.elongation(xp, state, force)
        slack = self.position(xp, memory, force, elongation)
        way = xp.where(force > 0.0, memory.elongation - elongation, slack)
        found = self.energy(xp, way)
        return None if found is None else Mechanics(found, (way,))

    def load_line(self, memory: LoadLineReference) -> Pull:
        """The mechanism as the element sees it."""

        def pull(xp: Namespace, spring: Spring) -> Scalar:
            return self.force(xp, memory, spring)

        return pull
