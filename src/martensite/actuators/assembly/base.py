"""Common base of all systems: it advances elements and mechanism through a step together.

One step solves laws, heat and mechanism together, second order in the step. The mechanism
does so: it knows how its elements depend on each other.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.assembly.actuator import Actuator, Feed
from martensite.actuators.assembly.ledger import Entries
from martensite.actuators.assembly.outputs import OUTPUTS
from martensite.actuators.assembly.starts import start_actuators
from martensite.actuators.elements.base import AbstractElement, Effort, Heating, MaterialPoint, StoredHeat
from martensite.actuators.mechanisms.base import MECHANISMS, AbstractMechanism, Column, Load, Output
from martensite.base.errors import ParameterError
from martensite.base.interfaces import make_missing_error
from martensite.base.parameters import Parametrised, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column
from martensite.physics.laws.coupling import StepReport

JUDGED = {"temperature": 1.0, "martensite_fraction": 0.01, "stress": 1e6}
"""Outputs of an element whose convergence is judged, with the least range that counts."""


class State(NamedTuple):
    """All that changes in time."""

    elements: tuple[Any, ...]
    mechanism: Any


class DriveSignal(NamedTuple):
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
    """Mechanism that the elements pull on."""

    @abstractmethod
    def actuators(self) -> dict[str, Actuator]:
        """Return the actuator at every port."""

    @abstractmethod
    def drives(self) -> list[DriveSignal]:
        """Return the signals that drive it."""

    def signals(self) -> dict[str, str]:
        """Return the drives beside those of the actuators, with their units: of the mechanism, and of what cools."""
        return self.mechanism.signals()

    @abstractmethod
    def label(self, port: str, name: str) -> str:
        """Return the name of an output of the actuator at a port."""

    @abstractmethod
    def drive_at(self, port: str) -> str:
        """Return the name of the drive of the actuator at a port."""

    @abstractmethod
    def outputs(self) -> dict[str, Output]:
        """Return the outputs, by name; rows of `observe` come in this order."""

    @abstractmethod
    def description(self) -> str:
        """Describe its parts in words."""

    def sample_time(self) -> float:
        """Return the time from sample to sample [s] of a system in discrete time; else 0."""
        return self.mechanism.sample_time()

    def profile(self, state: Any) -> list[Column]:
        """Return the quantities that vary along the element, for a system with one element."""
        return []

    @abstractmethod
    def convergence_scales(self) -> dict[str, float]:
        """Return the outputs whose convergence is judged, with the least range that counts."""

    @abstractmethod
    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """Return the state at rest, at ambient temperature, under the first drive signals."""

    @abstractmethod
    def step(self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar) -> tuple[Any, StepReport]:
        """Advance by `dt` [s] under constant drive signals, or what they bring in that time."""

    def exchanges(self) -> bool:
        """Return whether it offers `step_rosenbrock`."""
        return False

    def step_rosenbrock(self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar) -> tuple[Any, Any, Any]:
        """Return the states after a step of `dt` [s], in its middle, and after it to a lower order."""
        raise make_missing_error(type(self), ["step_rosenbrock"])

    @abstractmethod
    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """Everything that can be measured in a state under drive signals."""

    def heat_contents(self, xp: Namespace, state: Any) -> list[Scalar | None]:
        """Return the heat [J] that the element at every drive holds, but for a constant; None if unknown."""
        return [None] * len(self.drives())

    def flows(self, xp: Namespace, state: Any, *drives: Scalar | Feed) -> Scalar:
        """Return the power [W] into the elements whose heat is known, in the mean."""
        return 0.0

    def losses(self, xp: Namespace, state: Any, *drives: Scalar | Feed) -> Scalar | None:
        """Return power [W] out of those elements, in the mean; None where the state alone decides, as `entries` say."""
        return None

    def entries(self, xp: Namespace, state: Any, *drives: Scalar) -> Entries:
        """Return the energy accounts of a state under drive signals; by default empty."""
        return Entries()

    def points(self, xp: Namespace, state: Any) -> list[list[MaterialPoint]]:
        """Return the places at which laws without rates act, of every element."""
        return []

    def rates(self, state: Any) -> list[Scalar]:
        """Return the numbers of a state that only tell a solve where to look: rates of the last step."""
        return []


class AbstractSystemAround(AbstractSystem, init=False):
    """A system around another one, whose actuators and names are its own."""

    plant: AbstractSystem = part("the system inside")

    @property
    def mechanism(self) -> AbstractMechanism:  # type: ignore[override]
        """Return the mechanism of the plant."""
        return self.plant.mechanism

    def actuators(self) -> dict[str, Actuator]:
        """Return the actuators of the plant."""
        return self.plant.actuators()

    def signals(self) -> dict[str, str]:
        """Return the signals of the plant."""
        return self.plant.signals()

    def label(self, port: str, name: str) -> str:
        """Return the name as on the plant."""
        return self.plant.label(port, name)

    def drive_at(self, port: str) -> str:
        """Return the name as on the plant."""
        return self.plant.drive_at(port)

    def outputs(self) -> dict[str, Output]:
        """Return the outputs of the plant."""
        return self.plant.outputs()

    def convergence_scales(self) -> dict[str, float]:
        """Return the scales of the plant."""
        return self.plant.convergence_scales()


class AbstractAssembly(AbstractSystem):
    """Interface of a mechanism with actuators at its ports."""

    mechanism: AbstractMechanism = part("what the elements pull on", MECHANISMS)

    def drives(self) -> list[DriveSignal]:
        """Return one signal per actuator, then signals of the mechanism, then signals of the cooling."""
        own = [
            DriveSignal(self.drive_at(port), one.source.unit, one.source.sets_temperature)
            for port, one in self.actuators().items()
        ]
        ends = self.mechanism.signals()
        return own + [DriveSignal(name, unit, name in ends) for name, unit in self.signals().items()]

    def signals(self) -> dict[str, str]:
        """Return the signals of the mechanism, then those of the cooling of the elements."""
        return self.mechanism.signals() | self._cooling_signals()

    def _cooling_signals(self) -> dict[str, str]:
        return {n: unit for one in self._actuators() for n, unit in one.environment.cooling.signals().items()}

    def of_mechanism(self) -> dict[str, Output]:
        """Return the outputs of the mechanism, with its drive signals."""
        driven = {name: Output(unit, f"signal {name}", "u") for name, unit in self.signals().items()}
        return self.mechanism.outputs() | driven

    @abstractmethod
    def arrange_outputs(self, seen: list[dict[str, Scalar]], mechanism: dict[str, Scalar]) -> dict[str, Scalar]:
        """Merge the outputs of the actuators and of the mechanism, by name, in the order of `outputs`."""

    def convergence_scales(self) -> dict[str, float]:
        """Return the temperatures, fractions, and what the mechanism names."""
        found: dict[str, float] = {}
        for port in self.actuators():
            found |= {self.label(port, name): least for name, least in JUDGED.items()}
        return found | self.mechanism.convergence_scales()

    def init(self, xp: Namespace, *drives: Scalar) -> State:
        """Return the assembled system at rest, in equilibrium at ambient temperature."""
        actuators, signals = self._actuators(), self.mechanism_signals(drives)
        forces = self.mechanism.first_forces(xp, signals)
        rows = start_actuators(xp, list(zip(actuators, forces, drives, strict=False)))
        elongations = [elongation for _, elongation in rows]
        elements = [one.element for one in actuators]
        own = self.mechanism.init(xp, elements, elongations, signals)
        return State(tuple(state for state, _ in rows), own)

    def step(self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar) -> tuple[State, StepReport]:
        """Advance by `dt` [s] under constant drive signals, or what they bring in that time."""
        loads, signals = self._loads(xp, state, drives), self.mechanism_signals(drives)
        own, states, report = self.mechanism.advance(xp, state.mechanism, loads, signals, dt)
        return State(tuple(states), own), report

    def exchanges(self) -> bool:
        """Return whether it is one element with a rate-dependent law on a load line."""
        return self.mechanism.static and self._actuators()[0].element.exchanges

    def step_rosenbrock(
        self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar
    ) -> tuple[State, State, State]:
        """Return the states after a step of `dt` [s], in its middle, and after it to a lower order."""
        ((element, own, heating),) = self._loads(xp, state, drives)
        pull = self.mechanism.load_line(state.mechanism)
        after, middle, coarse = (
            State((one,), state.mechanism) for one in element.advance_rosenbrock(xp, own, heating, pull, dt)
        )
        return after, middle, coarse

    def differentiate(self, xp: Namespace, state: State, *drives: Scalar) -> tuple[State, Column]:
        """Return the state that follows from its continuous numbers under drive signals, and their rates in time."""
        ((element, own, heating),) = self._loads(xp, state, drives)
        own, rates = element.differentiate(xp, own, heating, self.mechanism.load_line(state.mechanism))
        return State((own,), state.mechanism), rates

    def heat_contents(self, xp: Namespace, state: State) -> list[Scalar | None]:
        """Return the heat [J] that the element at every drive holds, but for a constant; None if unknown."""
        rows = zip(self._actuators(), state.elements, strict=True)
        own = [one.element.heat_content(xp, element) for one, element in rows]
        return own + [None] * len(self.signals())

    def flows(self, xp: Namespace, state: State, *drives: Scalar | Feed) -> Scalar:
        """Return the power [W] into the elements whose heat is known, in the mean."""
        given: Scalar = 0.0
        for element, own, heating in self._loads(xp, state, drives):
            if _is_balanced(xp, element, own, heating):
                seen = element.condition(xp, own, element.force(own), heating.environment)
                given = given + heating.heat(xp, seen.resistance).mean
        return given

    def losses(self, xp: Namespace, state: State, *drives: Scalar | Feed) -> Scalar | None:
        """Return the mean cooling power [W] out of the elements; None if no signal drives their cooling."""
        return self._sum_losses(xp, self._loads(xp, state, drives)) if self._cooling_signals() else None

    def _sum_losses(self, xp: Namespace, loads: Sequence[Load]) -> Scalar:
        lost: Scalar = 0.0
        for element, own, heating in loads:
            if _is_balanced(xp, element, own, heating):
                lost = lost + element.condition(xp, own, element.force(own), heating.environment).heat_loss
        return lost

    def entries(self, xp: Namespace, state: State, *drives: Scalar) -> Entries:
        """Return the energy accounts of a state under drive signals."""
        found, loads = Entries(), self._loads(xp, state, drives)
        self._enter_heat(xp, found, loads)
        signals = self.mechanism_signals(drives)
        mechanics = self.mechanism.mechanics(xp, state.mechanism, loads, signals)
        if mechanics is None:
            name = self.mechanism.registered_name
            found.unknown += (f"work: not balanced, since `{name}` does not say what it holds",)
            return found
        found.work = True
        energy = mechanics.energy
        found.held.update(zip(energy._fields, energy, strict=True))
        self._enter_work(xp, found, loads, mechanics.ways)
        found.efforts += [("dissipated", one) for one in mechanics.dissipated]
        found.efforts += [("outside", one) for one in mechanics.outside]
        return found

    def _enter_heat(self, xp: Namespace, found: Entries, loads: Sequence[Load]) -> None:
        """Heat that elements hold and lose, if all that are heated say it."""
        fed = [load for load in loads if load.heating.temperature is None]
        rows = [(load, load.element.stored_heat(xp, load.state)) for load in fed]
        known = [(load, stored) for load, stored in rows if stored is not None]
        found.heat = bool(fed) and len(known) == len(fed)
        found.unknown += _say_unknown(rows) if loads else ()
        if not found.heat:
            return
        found.held["sensible"] = sum_column([stored.sensible for _, stored in known])
        found.efforts += [("latent", effort) for _, stored in known for effort in stored.latent]
        if not self._cooling_signals():
            found.lost = self._sum_losses(xp, loads)

    def _enter_work(self, xp: Namespace, found: Entries, loads: Sequence[Load], ways: Column) -> None:
        """Work of elements, and the elastic energy in them if all say it."""
        elastic = [element.elastic_energy(xp, state) for element, state, _ in loads]
        known = [one for one in elastic if one is not None]
        if known and len(known) == len(loads):
            found.held["elastic"] = sum_column(known)
        rows = zip(loads, ways, strict=True)
        found.efforts += [("work", Effort(one.element.force(one.state), way)) for one, way in rows]

    def points(self, xp: Namespace, state: State) -> list[list[MaterialPoint]]:
        """Return the places at which laws without rates act, of every element."""
        rows = zip(self._actuators(), state.elements, strict=True)
        return [one.element.points(xp, element) for one, element in rows]

    def rates(self, state: State) -> list[Scalar]:
        """Return the numbers of a state that only tell a solve where to look: rates of the last step."""
        rows = zip(self._actuators(), state.elements, strict=True)
        return [rate for one, element in rows for rate in one.element.rates(element)]

    def observe(self, xp: Namespace, state: State, *drives: Scalar) -> list[Scalar]:
        """Everything that can be measured in a state under drive signals."""
        loads, signals = self._loads(xp, state, drives), self.mechanism_signals(drives)
        forces, own = self.mechanism.observe(xp, state.mechanism, loads, signals)
        rows = zip(self._driven_actuators(xp, state, drives), state.elements, forces, drives, strict=False)
        seen = [one.observe_element(xp, element, force, drive) for one, element, force, drive in rows]
        mechanism = dict(
            zip(self.of_mechanism(), [*own, *drives[len(seen) :], *self._observe_rig(xp, state, drives)], strict=True)
        )
        return list(self.arrange_outputs(seen, mechanism).values())

    def _actuators(self) -> list[Actuator]:
        return list(self.actuators().values())

    def _loads(self, xp: Namespace, state: State, drives: Sequence[Scalar | Feed]) -> list[Load]:
        rows = zip(self._driven_actuators(xp, state, drives), state.elements, drives, strict=False)
        return [one.load(element, drive) for one, element, drive in rows]

    def _observe_rig(self, xp: Namespace, state: State, drives: Sequence[Scalar]) -> Column:
        """Observe all actuators together."""
        return []

    def _driven_actuators(self, xp: Namespace, state: State, drives: Sequence[Scalar | Feed]) -> list[Actuator]:
        """Return the actuators, cooled as the signals of that have it."""
        actuators, names = self._actuators(), self._cooling_signals()
        given = [one.moments if isinstance(one, Feed) else one for one in drives]
        signals = dict(zip(names, given[len(drives) - len(names) :], strict=True))
        return [one.with_cooling_signals(xp, signals) for one in actuators] if names else actuators

    def mechanism_signals(self, drives: Sequence[Scalar | Feed]) -> Column:
        """Return the drive signals of the mechanism itself, which are never fed."""
        first = len(self._actuators())
        own = drives[first : first + len(self.mechanism.signals())]
        return [one for one in own if not isinstance(one, Feed)]

    def _check_signals(self) -> None:
        """Raise `ParameterError` if a signal of what cools is called as something else is."""
        units = self.mechanism.signals()
        taken = {*units, *self.mechanism.outputs(), *self.mechanism.ports(), *OUTPUTS}
        for one in self._actuators():
            for name, unit in one.environment.cooling.signals().items():
                if name in taken or units.setdefault(name, unit) != unit or not name.isidentifier():
                    raise ParameterError(
                        f"`signal` of the cooling must be a unique name in its system, but is `{name}`."
                    )


def _is_balanced(xp: Namespace, element: AbstractElement, state: Any, heating: Heating) -> bool:
    """Return whether the heat of an element is known, and its temperature is not prescribed."""
    return heating.temperature is None and element.stored_heat(xp, state) is not None


def _say_unknown(rows: Sequence[tuple[Load, StoredHeat | None]]) -> tuple[str, ...]:
    """Return the reasons for a missing ledger of the heat."""
    if not rows:
        return ("heat: not balanced, since the temperature is prescribed",)
    names = {load.element.registered_name for load, stored in rows if stored is None}
    return tuple(f"heat: not balanced, since `{name}` does not say what it holds" for name in sorted(names))
