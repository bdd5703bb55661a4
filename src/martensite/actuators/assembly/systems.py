"""Systems: one element on a mechanism, or an actuator at every port of one; and a system through some equal steps."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from martensite.actuators.assembly.actuator import Actuator, Feed, Group
from martensite.actuators.assembly.base import AbstractAssembly, AbstractSystem, State
from martensite.actuators.assembly.outputs import OBSERVABLES
from martensite.actuators.mechanisms.base import Column, Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.electrical.shared_supply import Consumer, SharedSupply
from martensite.physics.laws.coupling import StepReport

T = TypeVar("T")
SUPPLIED = {
    "supply_voltage": Output("V", "voltage of the supply", "U"),
    "supply_current": Output("A", "current of the supply", "I"),
    "supply_demand": Output("A", "current that the sources ask of the supply", "I_d"),
}
"""Outputs of a supply, in the order of `SharedSupply.observe`."""


class System(Actuator, AbstractAssembly):
    """An element, its environment, a source and a mechanism of one port."""

    def check(self) -> None:
        """Raise `ParameterError` if the mechanism does not take one element."""
        ports = self.mechanism.ports()
        if len(ports) != 1:
            raise ParameterError(
                f"Mechanism `{self.mechanism.registered_name}` takes {len(ports)} elements "
                f"({', '.join(ports) or 'none'}), but a `System` has one; use `Machine`."
            )
        self._check_signals()

    def actuators(self) -> dict[str, Actuator]:
        """Itself."""
        return {self.mechanism.ports()[0]: self}

    def label(self, port: str, name: str) -> str:
        """Return the plain name: there is one actuator."""
        return name

    def drive_at(self, port: str) -> str:
        """`drive`."""
        return "drive"

    def outputs(self) -> dict[str, Output]:
        """Return the outputs of the element, and after the force the outputs of the mechanism."""
        own = self.own_outputs()
        found = _insert_mechanism(own, self.of_mechanism())
        return found | {"drive": own["drive"]._replace(unit=self.source.unit)}

    def description(self) -> str:
        """Return a description such as `wire (brinson) on bias-spring, driven by power`."""
        element, load = self.element, self.mechanism.registered_name
        names = f"{element.registered_name} ({element.law.registered_name})"
        return f"{names} on {load}, driven by {self.source.registered_name}"

    def arrange_outputs(self, seen: list[dict[str, Scalar]], mechanism: dict[str, Scalar]) -> dict[str, Scalar]:
        """Merge the outputs of the element, and after the force the outputs of the mechanism."""
        (one,) = seen
        return _insert_mechanism(one, mechanism)

    def profile(self, state: State) -> list[Column]:  # type: ignore[override]
        """Return the quantities that vary along the element; described in `PROFILES`."""
        return list(self.element.profile(state.elements[0]))


def _insert_mechanism(own: Mapping[str, T], mechanism: Mapping[str, T]) -> dict[str, T]:
    later = {name: one for name, one in own.items() if OBSERVABLES[name].after_mechanism}
    first = {name: one for name, one in own.items() if name not in later}
    return {**first, **mechanism, **later}


class Machine(AbstractAssembly):
    """A mechanism and the actuators at its ports; outputs are called `port.temperature`.

    With a supply that they share, its voltage is found at the start of every step; the step is made twice, with the
    mean of the resistances before and after the first time, which keeps it of second order.
    """

    group: Group = part("actuators by port", default=Group())
    supply: SharedSupply | None = part("supply that the sources share; each has its own if left out", default=None)

    def check(self) -> None:
        """Raise `ParameterError` unless there is one actuator for every port."""
        ports, members = self.mechanism.ports(), self.group.members()
        name = self.mechanism.registered_name
        for given in members:
            if given not in ports:
                raise ParameterError(f"`{name}` has no port `{given}`. {suggest_name(given, ports)}")
        missing = [port for port in ports if port not in members]
        if missing:
            raise ParameterError(
                f"`{name}` needs an actuator at each of its ports {', '.join(ports)}; "
                f"none given for {', '.join(missing)}."
            )
        self._check_signals()

    def actuators(self) -> dict[str, Actuator]:
        """In the order of the ports."""
        members = self.group.members()
        return {port: members[port] for port in self.mechanism.ports()}

    def label(self, port: str, name: str) -> str:
        """`port.name`."""
        return f"{port}.{name}"

    def drive_at(self, port: str) -> str:
        """Return the name of the port."""
        return port

    def exchanges(self) -> bool:
        """Never with a supply that is shared."""
        return self.supply is None and super().exchanges()

    def step(self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar) -> tuple[State, StepReport]:
        """Advance by `dt` [s] under constant drive signals, or what they bring in that time."""
        if self.supply is None:
            return super().step(xp, state, *drives, dt=dt)
        ahead, _ = super().step(xp, state, *drives, dt=dt)
        ends = zip(self._resistances(xp, state), self._resistances(xp, ahead), strict=True)
        middle = [0.5 * (first + last) for first, last in ends]
        rows = zip(self._driven_actuators(xp, state, drives, middle), state.elements, drives, strict=False)
        loads = [one.load(element, drive) for one, element, drive in rows]
        own, states, report = self.mechanism.advance(xp, state.mechanism, loads, self.mechanism_signals(drives), dt)
        return State(tuple(states), own), report

    def of_mechanism(self) -> dict[str, Output]:
        """Return the outputs of the mechanism, its signals, and the outputs of a shared supply."""
        return super().of_mechanism() | (SUPPLIED if self.supply is not None else {})

    def _observe_rig(self, xp: Namespace, state: State, drives: Sequence[Scalar]) -> Column:
        if self.supply is None:
            return []
        actuators = super()._driven_actuators(xp, state, drives)
        return list(self.supply.observe(xp, _list_consumers(actuators, drives, self._resistances(xp, state))))

    def _driven_actuators(
        self, xp: Namespace, state: State, drives: Sequence[Scalar | Feed], ohms: Sequence[Scalar] = ()
    ) -> list[Actuator]:
        """With what the supply leaves them at these resistances [ohm], or at those of the state."""
        actuators = super()._driven_actuators(xp, state, drives)
        if self.supply is None:
            return actuators
        consumers = _list_consumers(actuators, drives, ohms or self._resistances(xp, state))
        voltage = self.supply.find_voltage(xp, consumers)
        rows = zip(actuators, consumers, strict=True)
        return [one.rebuilt({"source": consumer.limit_voltage(xp, voltage)}) for one, consumer in rows]

    def _resistances(self, xp: Namespace, state: State) -> list[Scalar]:
        rows = [(one.element, one.environment, own) for one, own in zip(self._actuators(), state.elements, strict=True)]
        return [one.condition(xp, own, one.force(own), around).resistance for one, around, own in rows]

    def outputs(self) -> dict[str, Output]:
        """Return the outputs of the mechanism, then the outputs of every actuator."""
        found = self.of_mechanism()
        for port, one in self.actuators().items():
            for name, (unit, words, symbol) in one.own_outputs().items():
                unit = one.source.unit if name == "drive" else unit
                found[self.label(port, name)] = Output(unit, f"{words}, {port}", symbol)
        return found

    def description(self) -> str:
        """Return a description such as `parallel-platform with 3 × coil-spring (liang-rogers)`."""
        kinds = Counter(
            f"{one.element.registered_name} ({one.element.law.registered_name})" for one in self.actuators().values()
        )
        words = ", ".join(f"{count} × {kind}" for kind, count in kinds.items())
        return f"{self.mechanism.registered_name} with {words or 'no elements'}"

    def arrange_outputs(self, seen: list[dict[str, Scalar]], mechanism: dict[str, Scalar]) -> dict[str, Scalar]:
        """Merge the outputs of the mechanism, then the outputs of every actuator."""
        rows = zip(self.actuators(), seen, strict=True)
        own = {self.label(port, name): value for port, one in rows for name, value in one.items()}
        return mechanism | own


def _list_consumers(
    actuators: Sequence[Actuator], drives: Sequence[Scalar | Feed], ohms: Sequence[Scalar]
) -> list[Consumer]:
    given = [one.moments.mean if isinstance(one, Feed) else one for one in drives]
    return [Consumer(one.source, u, r) for one, u, r in zip(actuators, given, ohms, strict=False)]


Piece = tuple[Sequence[Scalar], Scalar]
"""Signals, and for how long [s]."""


def advance_steps(
    xp: Namespace, system: AbstractSystem, state: Any, pieces: Sequence[Piece], turns: int
) -> tuple[Any, StepReport]:
    """Return the state after some turns of the same pieces, and the worst report of all steps."""
    shape, size = NestedShape(state), len(flatten_numbers(state))

    def turn(*numbers: Any) -> list[Any]:
        now, worst = shape.rebuild(numbers[:size]), StepReport(*numbers[size:])
        for signals, length in pieces:
            now, found = system.step(xp, now, *signals, dt=length)
            worst = StepReport(*map(xp.maximum, worst, found))
        return flatten_numbers(now) + flatten_numbers(worst)

    begin = [*flatten_numbers(state), *(0.0 for _ in StepReport._fields)]
    after = turn(*begin) if turns == 1 else xp.repeat(turns, turn, *begin)
    return shape.rebuild(after[:size]), StepReport(*after[size:])
