"""A system: one element, its surroundings, what drives it and what it pulls.

One step solves law, heat and mechanism together. Given the phase fractions at the end of the
step, everything else follows in closed form:

    T    linearised trapezoid of the heat balance, with latent heat
    F    balance of the element (a linear spring at these fractions and T) with the mechanism

so the coupled step is the search for the fractions that the law answers with themselves
(`laws.coupling`). Second order in the step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from martensite.electrical.base import SOURCES, AbstractSource
from martensite.elements.base import ELEMENTS, AbstractElement
from martensite.laws.base import Fractions
from martensite.laws.coupling import Report, advance
from martensite.mechanisms.base import MECHANISMS, AbstractMechanism, Assembly
from martensite.parameters import Parametrised, part
from martensite.runtimes.bracket import ITERATIONS
from martensite.runtimes.dual import value_and_slope
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.thermal.base import Environment


class State(NamedTuple):
    """All that changes in time."""

    memory: Any
    assembly: Assembly


class Outputs(NamedTuple):
    """What can be observed, in SI units; described in `OUTPUTS`."""

    drive: Scalar
    temperature: Scalar
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


class System(Parametrised):
    """An element, its environment, a source and a mechanism."""

    element: AbstractElement = part("the shape-memory element", ELEMENTS)
    environment: Environment = part("surroundings")
    source: AbstractSource = part("what drives the element", SOURCES)
    mechanism: AbstractMechanism = part("what the element pulls on", MECHANISMS)

    def init(self, xp: Namespace, drive: Scalar) -> State:
        """The assembled system at rest, at ambient temperature."""
        element = self.element
        sets = self.source.sets_temperature
        temperature = drive if sets else self.environment.temperature
        force = self.mechanism.start_force(xp)
        stress = element.stress(xp, force)
        fractions = element.initial_fractions()
        memory = element.law.init(xp, fractions, stress, temperature)
        spring = element.spring(xp, fractions, temperature)
        return State(memory, Assembly(spring.free + spring.compliance * force))

    def step(
        self,
        xp: Namespace,
        state: State,
        drive: Scalar,
        dt: Scalar,
        iterations: int = ITERATIONS,
    ) -> tuple[State, Report]:
        """Advance by `dt` [s] under a constant drive signal."""
        heat = self._heat_line(xp, state, drive, dt)

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            temperature = heat(xp, fractions.martensite)
            return self._stress(xp, state, fractions, temperature), temperature

        after, report = advance(xp, self.element.law, state.memory, settle, dt, iterations)
        return State(after, state.assembly), report

    def _heat_line(
        self, xp: Namespace, state: State, drive: Scalar, dt: Scalar
    ) -> Callable[[Namespace, Scalar], Scalar]:
        """T at the end of the step as a function of the fraction there."""
        if self.source.sets_temperature:
            return _constant(drive)
        element, environment = self.element, self.environment
        start = state.memory.temperature
        strain = self._strain(xp, state)
        fraction = element.law.fractions(state.memory).martensite

        def loss(xp: Namespace, temperature: Scalar) -> Scalar:
            return element.heat_loss(xp, temperature, environment)

        lost, slope = value_and_slope(xp, loss, start)
        share = 1.0 / (element.heat_capacity_total() + 0.5 * dt * slope)
        latent = element.latent_heat_total(xp, state.memory.stress, start)

        def temperature(xp: Namespace, x: Scalar) -> Scalar:
            ohms = element.ohms(xp, 0.5 * (fraction + x), strain, start)
            current = self.source.current(xp, drive, ohms)
            gained = dt * (current * current * ohms - lost) + latent * (x - fraction)
            return start + share * gained

        return temperature

    def _stress(
        self, xp: Namespace, state: State, fractions: Fractions, temperature: Scalar
    ) -> Scalar:
        spring = self.element.spring(xp, fractions, temperature)
        return self.element.stress(xp, self.mechanism.force(xp, state.assembly, spring))

    def _strain(self, xp: Namespace, state: State) -> Scalar:
        law, memory = self.element.law, state.memory
        return law.strain(xp, law.fractions(memory), memory.stress, memory.temperature)

    def observe(self, xp: Namespace, state: State, drive: Scalar) -> Outputs:
        """Everything that can be measured in a state under a drive signal."""
        element, memory = self.element, state.memory
        fractions = element.law.fractions(memory)
        spring = element.spring(xp, fractions, memory.temperature)
        force = self.mechanism.force(xp, state.assembly, spring)
        elongation = spring.free + spring.compliance * force
        strain = element.strain(xp, elongation)
        ohms = element.ohms(xp, fractions.martensite, strain, memory.temperature)
        current = self.source.current(xp, drive, ohms)
        return Outputs(
            drive=drive,
            temperature=memory.temperature,
            martensite_fraction=fractions.martensite,
            oriented_fraction=fractions.oriented,
            stress=element.stress(xp, force),
            strain=strain,
            force=force,
            position=self.mechanism.position(xp, state.assembly, force, elongation),
            resistance=ohms,
            current=current,
            voltage=current * ohms,
            power=current * current * ohms,
            heat_loss=element.heat_loss(xp, memory.temperature, self.environment),
        )


def _constant(number: Scalar) -> Callable[[Namespace, Scalar], Scalar]:
    def same(xp: Namespace, x: Scalar) -> Scalar:
        return number

    return same
