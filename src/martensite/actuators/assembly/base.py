"""Base of all systems: one step of all elements and the mechanism.

A step solves laws, heat and mechanism together, second order in the step. The mechanism couples its elements.
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
from martensite.base.interfaces import make_missing_error, override
from martensite.base.parameters import Parametrised, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers, sum_column
from martensite.physics.laws.coupling import StepReport
from martensite.physics.laws.surface_steps import SurfaceStep

JUDGED = {"temperature": 1.0, "martensite_fraction": 0.01, "stress": 1e6}
"""Outputs of an element with a convergence test -> smallest relevant range."""


class State(NamedTuple):
    """Complete dynamic state."""

    elements: tuple[Any, ...]
    mechanism: Any


class DriveSignal(NamedTuple):
    """Drive signal of a system."""

    name: str
    unit: str
    at_end: bool
    """True if the value at the end of a step counts, not at mid-step."""
    ahead: bool = False
    """In discrete time: true if read at the end of a sample, not at its start."""


class AbstractSystem(Parametrised, init=False):
    """Interface of everything that is simulated: elements, mechanism and drives."""

    mechanism: AbstractMechanism

    @abstractmethod
    def actuators(self) -> dict[str, Actuator]:
        """Return the actuator at each port."""

    @abstractmethod
    def drives(self) -> list[DriveSignal]:
        """Return the drive signals."""

    def signals(self) -> dict[str, str]:
        """Return further drives with their units, of mechanism and cooling."""
        return self.mechanism.signals()

    @abstractmethod
    def label(self, port: str, name: str) -> str:
        """Return the name of an output of the actuator at a port."""

    @abstractmethod
    def drive_at(self, port: str) -> str:
        """Return the name of the drive of the actuator at a port."""

    @abstractmethod
    def outputs(self) -> dict[str, Output]:
        """Return the outputs by name, in the order of `observe`."""

    @abstractmethod
    def description(self) -> str:
        """Return its parts in words."""

    def sample_time(self) -> float:
        """Return the sample time [s] of a system in discrete time; else 0."""
        return self.mechanism.sample_time()

    def profile(self, state: Any) -> list[Column]:
        """Return the quantities along the element, for a system with one element."""
        return []

    @abstractmethod
    def convergence_scales(self) -> dict[str, float]:
        """Return the outputs with a convergence test -> smallest relevant range."""

    @abstractmethod
    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """Return the equilibrium at ambient temperature under the first drive signals."""

    @abstractmethod
    def step(self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar) -> tuple[Any, StepReport]:
        """Return the state after `dt` [s] under constant signals or their moments, and the report."""

    def exchanges(self) -> bool:
        """Return whether it offers `step_rosenbrock`."""
        return False

    def step_rosenbrock(self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar) -> tuple[Any, Any, Any]:
        """Return the states after a step of `dt` [s], in its middle, and after it to a lower order."""
        raise make_missing_error(type(self), ["step_rosenbrock"])

    def has_surface(self) -> bool:
        """Return whether it is an assembly that offers `step_on_surface`."""
        return False

    @abstractmethod
    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """Return all outputs in a state under drive signals."""

    def heat_contents(self, xp: Namespace, state: Any) -> list[Scalar | None]:
        """Return the heat [J] in the element of each drive, up to a constant; None if unknown."""
        return [None] * len(self.drives())

    def flows(self, xp: Namespace, state: Any, *drives: Scalar | Feed) -> Scalar:
        """Return the mean power [W] into the elements of known heat."""
        return 0.0

    def losses(self, xp: Namespace, state: Any, *drives: Scalar | Feed) -> Scalar | None:
        """Return the mean power [W] out of those elements; None if `entries` has it as a function of the state."""
        return None

    def entries(self, xp: Namespace, state: Any, *drives: Scalar) -> Entries:
        """Return the energy accounts of a state under drive signals; by default empty."""
        return Entries()

    def points(self, xp: Namespace, state: Any) -> list[list[MaterialPoint]]:
        """Return the material points of rate-independent laws, of each element."""
        return []

    def rates(self, state: Any) -> list[Scalar]:
        """Return the state variables that are first guesses only: rates of the last step."""
        return []


class AbstractSystemAround(AbstractSystem, init=False):
    """System around another system, with the same actuators and names."""

    plant: AbstractSystem = part("the system inside")

    @property
    def mechanism(self) -> AbstractMechanism:  # type: ignore[override]
        """Return the mechanism of the plant."""
        return self.plant.mechanism

    @override
    def actuators(self) -> dict[str, Actuator]:
        return self.plant.actuators()

    @override
    def signals(self) -> dict[str, str]:
        return self.plant.signals()

    @override
    def label(self, port: str, name: str) -> str:
        return self.plant.label(port, name)

    @override
    def drive_at(self, port: str) -> str:
        return self.plant.drive_at(port)

    @override
    def outputs(self) -> dict[str, Output]:
        return self.plant.outputs()

    @override
    def convergence_scales(self) -> dict[str, float]:
        return self.plant.convergence_scales()


class AbstractAssembly(AbstractSystem):
    """Mechanism with actuators at its ports."""

    mechanism: AbstractMechanism = part("what the elements pull on", MECHANISMS)

    @override
    def drives(self) -> list[DriveSignal]:
        own = [
            DriveSignal(self.drive_at(port), one.source.unit, one.source.sets_temperature)
            for port, one in self.actuators().items()
        ]
        ends = self.mechanism.signals()
        return own + [DriveSignal(name, unit, name in ends) for name, unit in self.signals().items()]

    @override
    def signals(self) -> dict[str, str]:
        return self.mechanism.signals() | self._cooling_signals()

    def _cooling_signals(self) -> dict[str, str]:
        return {n: unit for one in self._actuators() for n, unit in one.environment.cooling.signals().items()}

    def of_mechanism(self) -> dict[str, Output]:
        """Return the outputs of the mechanism, with its drive signals."""
        driven = {name: Output(unit, f"signal {name}", "u") for name, unit in self.signals().items()}
        return self.mechanism.outputs() | driven

    @abstractmethod
    def arrange_outputs(
        self, actuator_outputs: list[dict[str, Scalar]], mechanism: dict[str, Scalar]
    ) -> dict[str, Scalar]:
        """Return the outputs of actuators and mechanism, by name, in the order of `outputs`."""

    @override
    def convergence_scales(self) -> dict[str, float]:
        own = {self.label(port, name): least for port in self.actuators() for name, least in JUDGED.items()}
        return own | self.mechanism.convergence_scales()

    @override
    def init(self, xp: Namespace, *drives: Scalar) -> State:
        actuators, signals = self._actuators(), self.mechanism_signals(drives)
        forces = self.mechanism.first_forces(xp, signals)
        rows = start_actuators(xp, list(zip(actuators, forces, drives, strict=False)))
        elongations = [elongation for _, elongation in rows]
        elements = [one.element for one in actuators]
        own = self.mechanism.init(xp, elements, elongations, signals)
        return State(tuple(state for state, _ in rows), own)

    @override
    def step(self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar) -> tuple[State, StepReport]:
        loads, signals = self._loads(xp, state, drives), self.mechanism_signals(drives)
        own, states, report = self.mechanism.advance(xp, state.mechanism, loads, signals, dt)
        return State(tuple(states), own), report

    def exchanges(self) -> bool:
        """Return whether it is one element with a rate-dependent law on a load line."""
        return self.mechanism.static and self._actuators()[0].element.exchanges

    @override
    def step_rosenbrock(
        self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar
    ) -> tuple[State, State, State]:
        ((element, own, heating),) = self._loads(xp, state, drives)
        pull = self.mechanism.load_line(state.mechanism)
        after, middle, coarse = (
            State((one,), state.mechanism) for one in element.advance_rosenbrock(xp, own, heating, pull, dt)
        )
        return after, middle, coarse

    def has_surface(self) -> bool:
        """Return whether it is one heated element with a surface on a load line, without other signals."""
        if not self.mechanism.static or self.signals():
            return False
        one = self._actuators()[0]
        return one.element.has_surface and not one.source.sets_temperature

    def step_on_surface(
        self, xp: Namespace, state: State, first: Sequence[Feed], last: Sequence[Feed], dt: Scalar
    ) -> SurfaceStep:
        """Return the states of a step of order five of `dt` [s], from the moments of the drives in both halves."""
        loads = [self._loads(xp, state, drives)[0] for drives in (first, last)]
        pull = self.mechanism.load_line(state.mechanism)
        heating = [load.heating for load in loads]
        step = loads[0].element.advance_on_surface(xp, state.elements[0], heating, pull, dt)
        rest = NestedShape(state.mechanism).rebuild([0.0] * len(flatten_numbers(state.mechanism)))
        return step.convert(lambda one: State((one,), state.mechanism), lambda _, slope: State((slope,), rest))

    def find_events(self, xp: Namespace, state: State, temperature: Scalar, stress: Scalar) -> list[Scalar]:
        """Return numbers that fall through 0 at kinks of the law, at another temperature [K] and stress [Pa]."""
        return self._actuators()[0].element.find_events(xp, state.elements[0], temperature, stress)

    @override
    def heat_contents(self, xp: Namespace, state: State) -> list[Scalar | None]:
        rows = zip(self._actuators(), state.elements, strict=True)
        own = [one.element.heat_content(xp, element) for one, element in rows]
        return own + [None] * len(self.signals())

    @override
    def flows(self, xp: Namespace, state: State, *drives: Scalar | Feed) -> Scalar:
        power: Scalar = 0.0
        for element, own, heating in self._loads(xp, state, drives):
            if _is_balanced(xp, element, own, heating):
                condition = element.condition(xp, own, element.force(own), heating.environment)
                power = power + heating.heat(xp, condition.resistance).mean
        return power

    @override
    def losses(self, xp: Namespace, state: State, *drives: Scalar | Feed) -> Scalar | None:
        return self._sum_losses(xp, self._loads(xp, state, drives)) if self._cooling_signals() else None

    def _sum_losses(self, xp: Namespace, loads: Sequence[Load]) -> Scalar:
        lost: Scalar = 0.0
        for element, own, heating in loads:
            if _is_balanced(xp, element, own, heating):
                lost = lost + element.condition(xp, own, element.force(own), heating.environment).heat_loss
        return lost

    @override
    def entries(self, xp: Namespace, state: State, *drives: Scalar) -> Entries:
        entries, loads = Entries(), self._loads(xp, state, drives)
        self._enter_heat(xp, entries, loads)
        signals = self.mechanism_signals(drives)
        mechanics = self.mechanism.mechanics(xp, state.mechanism, loads, signals)
        if mechanics is None:
            name = self.mechanism.registered_name
            entries.unknown += (f"work: not balanced, since `{name}` does not say what it holds",)
            return entries
        entries.has_work_balance = True
        energy = mechanics.energy
        entries.energies.update(zip(energy._fields, energy, strict=True))
        self._enter_work(xp, entries, loads, mechanics.ways)
        entries.efforts += [("dissipated", one) for one in mechanics.dissipated]
        entries.efforts += [("outside", one) for one in mechanics.outside]
        return entries

    def _enter_heat(self, xp: Namespace, entries: Entries, loads: Sequence[Load]) -> None:
        """Enter stored and lost heat, if all heated elements provide it."""
        fed = [load for load in loads if load.heating.temperature is None]
        rows = [(load, load.element.stored_heat(xp, load.state)) for load in fed]
        heats = [stored for _, stored in rows if stored is not None]
        entries.has_heat_balance = bool(fed) and len(heats) == len(fed)
        entries.unknown += _describe_unknown(rows) if loads else ()
        if not entries.has_heat_balance:
            return
        entries.energies["sensible"] = sum_column([stored.sensible for stored in heats])
        entries.efforts += [("latent", effort) for stored in heats for effort in stored.latent]
        if not self._cooling_signals():
            entries.lost = self._sum_losses(xp, loads)

    def _enter_work(self, xp: Namespace, entries: Entries, loads: Sequence[Load], ways: Column) -> None:
        """Enter work and, if all elements provide it, elastic energy."""
        energies = [element.elastic_energy(xp, state) for element, state, _ in loads]
        elastic = [one for one in energies if one is not None]
        if elastic and len(elastic) == len(loads):
            entries.energies["elastic"] = sum_column(elastic)
        rows = zip(loads, ways, strict=True)
        entries.efforts += [("work", Effort(one.element.force(one.state), way)) for one, way in rows]

    @override
    def points(self, xp: Namespace, state: State) -> list[list[MaterialPoint]]:
        rows = zip(self._actuators(), state.elements, strict=True)
        return [one.element.points(xp, element) for one, element in rows]

    @override
    def rates(self, state: State) -> list[Scalar]:
        rows = zip(self._actuators(), state.elements, strict=True)
        return [rate for one, element in rows for rate in one.element.rates(element)]

    @override
    def observe(self, xp: Namespace, state: State, *drives: Scalar) -> list[Scalar]:
        loads, signals = self._loads(xp, state, drives), self.mechanism_signals(drives)
        forces, own = self.mechanism.observe(xp, state.mechanism, loads, signals)
        rows = zip(self._driven_actuators(xp, state, drives), state.elements, forces, drives, strict=False)
        outputs = [one.observe_element(xp, element, force, drive) for one, element, force, drive in rows]
        values = [*own, *drives[len(outputs) :], *self._observe_rig(xp, state, drives)]
        mechanism = dict(zip(self.of_mechanism(), values, strict=True))
        return list(self.arrange_outputs(outputs, mechanism).values())

    def _actuators(self) -> list[Actuator]:
        return list(self.actuators().values())

    def _loads(self, xp: Namespace, state: State, drives: Sequence[Scalar | Feed]) -> list[Load]:
        rows = zip(self._driven_actuators(xp, state, drives), state.elements, drives, strict=False)
        return [one.load(element, drive) for one, element, drive in rows]

    def _observe_rig(self, xp: Namespace, state: State, drives: Sequence[Scalar]) -> Column:
        """Return outputs of all actuators together."""
        return []

    def _driven_actuators(self, xp: Namespace, state: State, drives: Sequence[Scalar | Feed]) -> list[Actuator]:
        """Return the actuators under their cooling signals."""
        actuators, names = self._actuators(), self._cooling_signals()
        values = [one.moments if isinstance(one, Feed) else one for one in drives]
        signals = dict(zip(names, values[len(drives) - len(names) :], strict=True))
        return [one.with_cooling_signals(xp, signals) for one in actuators] if names else actuators

    def mechanism_signals(self, drives: Sequence[Scalar | Feed]) -> Column:
        """Return the drive signals of the mechanism."""
        first = len(self._actuators())
        own = drives[first : first + len(self.mechanism.signals())]
        return [one for one in own if not isinstance(one, Feed)]

    def _check_signals(self) -> None:
        """Raise `ParameterError` if a cooling signal has the name of something else."""
        units = self.mechanism.signals()
        taken = {*units, *self.mechanism.outputs(), *self.mechanism.ports(), *OUTPUTS}
        for one in self._actuators():
            for name, unit in one.environment.cooling.signals().items():
                if name in taken or units.setdefault(name, unit) != unit or not name.isidentifier():
                    raise ParameterError(
                        f"`signal` of the cooling must be a unique name in its system, but is `{name}`."
                    )


def _is_balanced(xp: Namespace, element: AbstractElement, state: Any, heating: Heating) -> bool:
    """Return whether the heat of an element is known and its temperature not prescribed."""
    return heating.temperature is None and element.stored_heat(xp, state) is not None


def _describe_unknown(rows: Sequence[tuple[Load, StoredHeat | None]]) -> tuple[str, ...]:
    """Return the reasons for a missing heat balance."""
    if not rows:
        return ("heat: not balanced, since the temperature is prescribed",)
    names = {load.element.registered_name for load, stored in rows if stored is None}
    return tuple(f"heat: not balanced, since `{name}` does not say what it holds" for name in sorted(names))
