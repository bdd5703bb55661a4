"""A system: one element, its surroundings, what drives it and what it pulls.

One step solves law, heat and mechanism together. The element does so: it is told what heats
it, and asks the mechanism for the force on a spring of its kind. Second order in the step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from martensite.electrical.base import SOURCES, AbstractSource
from martensite.elements.base import (
    ELEMENTS,
    AbstractElement,
    Heating,
    Profile,
    Pull,
    Spring,
    fitted,
)
from martensite.laws.coupling import Report
from martensite.mechanisms.base import MECHANISMS, AbstractMechanism, Assembly
from martensite.parameters import Parametrised, part
from martensite.runtimes.bracket import ITERATIONS
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.thermal.base import Environment


class State(NamedTuple):
    """All that changes in time."""

    element: Any
    assembly: Assembly


class Outputs(NamedTuple):
    """What can be observed, in SI units; described in `OUTPUTS`."""

    drive: Scalar
    temperature: Scalar
    hottest: Scalar
    martensite_fraction: Scalar
    oriented_fraction: Scalar
    stress: Scalar
    strain: Scalar
    force: Scalar
    position: Scalar
    resistance: Scalar
    current: Scalar
    voltage: Scalar
    power: Scalar
    heat_loss: Scalar


# output -> (unit, long name, symbol); the drive's unit is that of its source
OUTPUTS: dict[str, tuple[str, str, str]] = {
    "drive": ("1", "drive signal", "u"),
    "temperature": ("K", "wire temperature", "T"),
    "hottest": ("K", "highest temperature in the element", "T_max"),
    "martensite_fraction": ("1", "martensite fraction", "ξ"),
    "oriented_fraction": ("1", "net oriented martensite fraction", "ξ_S"),
    "stress": ("Pa", "axial stress", "σ"),
    "strain": ("1", "strain", "ε"),
    "force": ("N", "force", "F"),
    "position": ("m", "position of the mechanism", "x"),
    "resistance": ("ohm", "electrical resistance", "R"),
    "current": ("A", "current", "I"),
    "voltage": ("V", "voltage across the element", "U"),
    "power": ("W", "electrical power in the element", "P"),
    "heat_loss": ("W", "heat flow to the environment", "Q"),
}


PROFILES: dict[str, tuple[str, str, str]] = {
    "cell_temperature": ("K", "temperature of a cell", "T"),
    "cell_fraction": ("1", "martensite fraction of a cell", "ξ"),
}


class System(Parametrised):
    """An element, its environment, a source and a mechanism."""

    element: AbstractElement = part("the shape-memory element", ELEMENTS)
    environment: Environment = part("surroundings")
    source: AbstractSource = part("what drives the element", SOURCES)
    mechanism: AbstractMechanism = part("what the element pulls on", MECHANISMS)

    def init(self, xp: Namespace, drive: Scalar) -> State:
        """The assembled system at rest, at ambient temperature."""
        imposed = self.source.sets_temperature
        temperature = drive if imposed else self.environment.temperature
        force = self.mechanism.start_force(xp)
        state = self.element.init(xp, force, temperature)
        return State(state, Assembly(self.element.elongation(xp, state, force)))

    def step(
        self,
        xp: Namespace,
        state: State,
        drive: Scalar,
        dt: Scalar,
        iterations: int = ITERATIONS,
    ) -> tuple[State, Report]:
        """Advance by `dt` [s] under a constant drive signal."""
        pull, heating = self._pull(state), self._heating(drive)
        after, report = self.element.advance(xp, state.element, heating, pull, dt, iterations)
        return State(after, state.assembly), report

    def _pull(self, state: State) -> Pull:
        """The mechanism as the element sees it."""

        def pull(xp: Namespace, spring: Spring) -> Scalar:
            return self.mechanism.force(xp, state.assembly, spring)

        return pull

    def _heating(self, drive: Scalar) -> Heating:
        """What a drive signal does to the element."""

        def current(xp: Namespace, ohms: Scalar) -> Scalar:
            return self.source.current(xp, drive, ohms)

        imposed = drive if self.source.sets_temperature else None
        return Heating(self.environment, current, imposed)

    def profile(self, state: State) -> Profile:
        """What differs along the element; described in `PROFILES`."""
        return self.element.profile(state.element)

    def observe(self, xp: Namespace, state: State, drive: Scalar) -> Outputs:
        """Everything that can be measured in a state under a drive signal."""
        element = self.element

        def tangent(xp: Namespace, force: Scalar) -> Spring:
            return element.tangent(xp, state.element, force)

        start = element.force(state.element)
        force = fitted(xp, tangent, self._pull(state), start, element.passes)
        found = element.condition(xp, state.element, force, self.environment)
        elongation = element.elongation(xp, state.element, force)
        current = self.source.current(xp, drive, found.resistance)
        return Outputs(
            drive=drive,
            temperature=found.temperature,
            hottest=found.hottest,
            martensite_fraction=found.martensite_fraction,
            oriented_fraction=found.oriented_fraction,
            stress=found.stress,
            strain=found.strain,
            force=force,
            position=self.mechanism.position(xp, state.assembly, force, elongation),
            resistance=found.resistance,
            current=current,
            voltage=current * found.resistance,
            power=current * current * found.resistance,
            heat_loss=found.heat_loss,
        )
