"""What every system does: it takes elements and mechanism through a step together.

One step solves laws, heat and mechanism together, second order in the step. The mechanism
does so: it knows how its elements depend on each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.elements.base import Point
from martensite.laws.coupling import Report
from martensite.mechanisms.base import (
    MECHANISMS,
    AbstractMechanism,
    Column,
    Energy,
    Load,
    Output,
    Work,
)
from martensite.parameters import Parametrised, part
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.system.actuator import Actuator, Feed
from martensite.system.outputs import Outputs

JUDGED = {"temperature": 1.0, "martensite_fraction": 0.01, "stress": 1e6}
"""Outputs of an element whose convergence is judged, with the least range that counts."""


class State(NamedTuple):
    """All that changes in time."""

    elements: tuple[Any, ...]
    mechanism: Any


class Mechanics(NamedTuple):
    """What a mechanism holds, and the forces that do work on it."""

    energy: Energy
    elements: tuple[Work, ...]
    """Tension of each element, and how much shorter it is."""
    outside: tuple[Work, ...]
    """What takes work out of the mechanism."""


class Drive(NamedTuple):
    """A signal that drives a system."""

    name: str
    unit: str
    at_end: bool
    """True if its value at the end of a step counts, not the one at mid-step."""
    ahead: bool = False
    """In discrete time: true if it is read at the end of a sample, not at its start."""


class AbstractSystem(Parametrised, init=False):
    """Interface of everything that is simulated: elements, what they pull on, what drives them."""

    mechanism: AbstractMechanism
    """What the elements pull on."""

    def actuators(self) -> dict[str, Actuator]:
        """The actuator at every port."""
        raise NotImplementedError

    def drives(self) -> list[Drive]:
        """The signals that drive it."""
        raise NotImplementedError

    def label(self, port: str, name: str) -> str:
        """What an output of the actuator at a port is called."""
        raise NotImplementedError

    def drive_at(self, port: str) -> str:
        """What the drive of the actuator at a port is called."""
        raise NotImplementedError

    def outputs(self) -> dict[str, Output]:
        """What can be observed, by name; rows of `observe` come in this order."""
        raise NotImplementedError

    def described(self) -> str:
        """What it is made of, in words."""
        raise NotImplementedError

    def sample_time(self) -> float:
        """Time from sample to sample [s] of a system in discrete time; else 0."""
        return self.mechanism.sample_time()

    def profile(self, state: Any) -> list[Column]:
        """What differs along the element of a system that has but one."""
        return []

    def judged(self) -> dict[str, float]:
        """Outputs whose convergence is judged, with the least range that counts."""
        raise NotImplementedError

    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """The state at rest, at ambient temperature, under the first drive signals."""
        raise NotImplementedError

    def step(
        self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar
    ) -> tuple[Any, Report]:
        """Advance by `dt` [s] under constant drive signals, or what they bring in that time."""
        raise NotImplementedError

    def exchanges(self) -> bool:
        """Whether it offers `step_rosenbrock`."""
        return False

    def step_rosenbrock(
        self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar
    ) -> tuple[Any, Any, Any]:
        """States after a step of `dt` [s], in its middle, and after it to a lower order."""
        raise NotImplementedError

    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """Everything that can be measured in a state under drive signals."""
        raise NotImplementedError

    def heat_contents(self, xp: Namespace, state: Any) -> list[Scalar | None]:
        """Heat [J] that the element at every drive holds, but for a constant; None if unknown."""
        return [None] * len(self.drives())

    def flows(self, xp: Namespace, state: Any, *drives: Scalar | Feed) -> tuple[Scalar, Scalar]:
        """Power [W] into the elements whose heat is known, in the mean, and what they lose."""
        return 0.0, 0.0

    def mechanics(self, xp: Namespace, state: Any, *drives: Scalar) -> Mechanics | None:
        """Energy of the mechanism, and what does work on it; None if it does not say."""
        return None

    def points(self, xp: Namespace, state: Any) -> list[list[Point]]:
        """Places at which laws without rates act, of every element."""
        return []

    def rates(self, state: Any) -> list[Scalar]:
        """Numbers of a state that only tell a solve where to look: rates of the last step."""
        return []


class AbstractAssembly(AbstractSystem):
    """Interface of a mechanism with actuators at its ports."""

    mechanism: AbstractMechanism = part("what the elements pull on", MECHANISMS)

    def drives(self) -> list[Drive]:
        """One signal per actuator, then those of the mechanism."""
        own = [
            Drive(self.drive_at(port), one.source.unit, one.source.sets_temperature)
            for port, one in self.actuators().items()
        ]
        return own + [Drive(name, unit, True) for name, unit in self.mechanism.signals().items()]

    def of_mechanism(self) -> dict[str, Output]:
        """What can be observed on the mechanism, with the signals that drive it."""
        signals = self.mechanism.signals()
        driven = {name: Output(unit, f"signal {name}", "u") for name, unit in signals.items()}
        return self.mechanism.outputs() | driven

    def arranged(self, seen: list[Outputs], mechanism: Column) -> list[Scalar]:
        """Numbers in the order of `outputs`."""
        raise NotImplementedError

    def judged(self) -> dict[str, float]:
        """Temperatures, fractions, and what the mechanism names."""
        found: dict[str, float] = {}
        for port in self.actuators():
            found |= {self.label(port, name): least for name, least in JUDGED.items()}
        return found | self.mechanism.judged()

    def init(self, xp: Namespace, *drives: Scalar) -> State:
        """The assembled system at rest, at ambient temperature."""
        actuators, signals = self._actuators(), self._signals(drives)
        forces = self.mechanism.first_forces(xp, signals)
        rows = list(zip(actuators, forces, drives, strict=False))
        states = [one.start(xp, force, drive) for one, force, drive in rows]
        elongations = [
            one.element.elongation(xp, state, force)
            for (one, force, _), state in zip(rows, states, strict=True)
        ]
        elements = [one.element for one in actuators]
        own = self.mechanism.init(xp, elements, elongations, signals)
        return State(tuple(states), own)

    def step(
        self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar
    ) -> tuple[State, Report]:
        """Advance by `dt` [s] under constant drive signals, or what they bring in that time."""
        loads, signals = self._loads(state, drives), self._signals(drives)
        own, states, report = self.mechanism.advance(xp, state.mechanism, loads, signals, dt)
        return State(tuple(states), own), report

    def exchanges(self) -> bool:
        """Whether it is one element whose law gives rates, on a load line."""
        return self.mechanism.static and self._actuators()[0].element.exchanges

    def step_rosenbrock(
        self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar
    ) -> tuple[State, State, State]:
        """States after a step of `dt` [s], in its middle, and after it to a lower order."""
        ((element, own, heating),) = self._loads(state, drives)
        pull = self.mechanism.load_line(state.mechanism)
        after, middle, coarse = (
            State((one,), state.mechanism)
            for one in element.advance_rosenbrock(xp, own, heating, pull, dt)
        )
        return after, middle, coarse

    def heat_contents(self, xp: Namespace, state: State) -> list[Scalar | None]:
        """Heat [J] that the element at every drive holds, but for a constant; None if unknown."""
        rows = zip(self._actuators(), state.elements, strict=True)
        own = [one.element.heat_content(xp, element) for one, element in rows]
        return own + [None] * len(self.mechanism.signals())

    def flows(self, xp: Namespace, state: State, *drives: Scalar | Feed) -> tuple[Scalar, Scalar]:
        """Power [W] into the elements whose heat is known, in the mean, and what they lose."""
        given: Scalar = 0.0
        lost: Scalar = 0.0
        for load in self._loads(state, drives):
            known = load.element.heat_content(xp, load.state) is not None
            if known and load.heating.temperature is None:
                force, around = load.element.force(load.state), load.heating.environment
                seen = load.element.condition(xp, load.state, force, around)
                given = given + load.heating.heat(xp, seen.resistance).mean
                lost = lost + seen.heat_loss
        return given, lost

    def mechanics(self, xp: Namespace, state: State, *drives: Scalar) -> Mechanics | None:
        """Energy of the mechanism, and what does work on it; None if it does not say."""
        loads, signals = self._loads(state, drives), self._signals(drives)
        energy = self.mechanism.energy(xp, state.mechanism, loads, signals)
        if energy is None:
            return None
        forces, _ = self.mechanism.observe(xp, state.mechanism, loads, signals)
        ways = self.mechanism.ways(xp, state.mechanism, loads, forces)
        elements = (Work(*row) for row in zip(forces, ways, strict=True))
        outside = self.mechanism.outside(xp, state.mechanism, loads, signals)
        return Mechanics(energy, tuple(elements), tuple(outside))

    def points(self, xp: Namespace, state: State) -> list[list[Point]]:
        """Places at which laws without rates act, of every element."""
        rows = zip(self._actuators(), state.elements, strict=True)
        return [one.element.points(xp, element) for one, element in rows]

    def rates(self, state: State) -> list[Scalar]:
        """Numbers of a state that only tell a solve where to look: rates of the last step."""
        rows = zip(self._actuators(), state.elements, strict=True)
        return [rate for one, element in rows for rate in one.element.rates(element)]

    def observe(self, xp: Namespace, state: State, *drives: Scalar) -> list[Scalar]:
        """Everything that can be measured in a state under drive signals."""
        loads, signals = self._loads(state, drives), self._signals(drives)
        forces, own = self.mechanism.observe(xp, state.mechanism, loads, signals)
        rows = zip(self._actuators(), state.elements, forces, drives, strict=False)
        seen = [one.seen(xp, element, force, drive) for one, element, force, drive in rows]
        return self.arranged(seen, [*own, *signals])

    def _actuators(self) -> list[Actuator]:
        return list(self.actuators().values())

    def _loads(self, state: State, drives: Sequence[Scalar | Feed]) -> list[Load]:
        rows = zip(self._actuators(), state.elements, drives, strict=False)
        return [one.load(element, drive) for one, element, drive in rows]

    def _signals(self, drives: Sequence[Scalar | Feed]) -> Column:
        """The drive signals of the mechanism itself, which are never fed."""
        return [one for one in drives[len(self._actuators()) :] if not isinstance(one, Feed)]
