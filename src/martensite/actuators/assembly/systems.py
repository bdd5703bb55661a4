"""Systems: one element on a mechanism, or an actuator at each port; and repeated equal steps of a system."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from martensite.actuators.assembly.actuator import Actuator, Feed, Group
from martensite.actuators.assembly.base import AbstractAssembly, AbstractSystem, State
from martensite.actuators.assembly.outputs import OBSERVABLES
from martensite.actuators.mechanisms.base import Column, Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.interfaces import override
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
    """Element, environment, source and a mechanism of one port."""

    @override
    def check(self) -> None:
        ports = self.mechanism.ports()
        if len(ports) != 1:
            raise ParameterError(
                f"Mechanism `{self.mechanism.registered_name}` takes {len(ports)} elements "
                f"({', '.join(ports) or 'none'}), but a `System` has one; use `Machine`."
            )
        self._check_signals()

    @override
    def actuators(self) -> dict[str, Actuator]:
        return {self.mechanism.ports()[0]: self}

    @override
    def label(self, port: str, name: str) -> str:
        return name

    @override
    def drive_at(self, port: str) -> str:
        return "drive"

    @override
    def outputs(self) -> dict[str, Output]:
        own = self.own_outputs()
        return _insert_mechanism(own, self.of_mechanism()) | {"drive": own["drive"]._replace(unit=self.source.unit)}

    @override
    def description(self) -> str:
        element, load = self.element, self.mechanism.registered_name
        names = f"{element.registered_name} ({element.law.registered_name})"
        return f"{names} on {load}, driven by {self.source.registered_name}"

    @override
    def arrange_outputs(
        self, actuator_outputs: list[dict[str, Scalar]], mechanism: dict[str, Scalar]
    ) -> dict[str, Scalar]:
        (one,) = actuator_outputs
        return _insert_mechanism(one, mechanism)

    @override
    def profile(self, state: State) -> list[Column]:  # type: ignore[override]
        return list(self.element.profile(state.elements[0]))


def _insert_mechanism(own: Mapping[str, T], mechanism: Mapping[str, T]) -> dict[str, T]:
    later = {name: one for name, one in own.items() if OBSERVABLES[name].after_mechanism}
    first = {name: one for name, one in own.items() if name not in later}
    return {**first, **mechanism, **later}


class Machine(AbstractAssembly):
    """Mechanism and the actuators at its ports; outputs have names such as `port.temperature`.

    The voltage of a shared supply is computed at the start of each step. The step is then repeated with the mean of the
    resistances before and after it, which gives second order.
    """

    group: Group = part("actuators by port", default=Group())
    supply: SharedSupply | None = part("supply that the sources share; each has its own if left out", default=None)

    @override
    def check(self) -> None:
        ports, members = self.mechanism.ports(), self.group.members()
        name = self.mechanism.registered_name
        for port in members:
            if port not in ports:
                raise ParameterError(f"`{name}` has no port `{port}`. {suggest_name(port, ports)}")
        missing = [port for port in ports if port not in members]
        if missing:
            raise ParameterError(
                f"`{name}` needs an actuator at each of its ports {', '.join(ports)}; "
                f"none given for {', '.join(missing)}."
            )
        self._check_signals()

    @override
    def actuators(self) -> dict[str, Actuator]:
        members = self.group.members()
        return {port: members[port] for port in self.mechanism.ports()}

    @override
    def label(self, port: str, name: str) -> str:
        return f"{port}.{name}"

    @override
    def drive_at(self, port: str) -> str:
        return port

    def exchanges(self) -> bool:
        """Return False with a shared supply."""
        return self.supply is None and super().exchanges()

    def has_surface(self) -> bool:
        """Return False with a shared supply."""
        return self.supply is None and super().has_surface()

    @override
    def step(self, xp: Namespace, state: State, *drives: Scalar | Feed, dt: Scalar) -> tuple[State, StepReport]:
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
        """Return the outputs of the mechanism, its signals, and a shared supply."""
        return super().of_mechanism() | (SUPPLIED if self.supply is not None else {})

    def _observe_rig(self, xp: Namespace, state: State, drives: Sequence[Scalar]) -> Column:
        if self.supply is None:
            return []
        actuators = super()._driven_actuators(xp, state, drives)
        return list(self.supply.observe(xp, _list_consumers(actuators, drives, self._resistances(xp, state))))

    def _driven_actuators(
        self, xp: Namespace, state: State, drives: Sequence[Scalar | Feed], ohms: Sequence[Scalar] = ()
    ) -> list[Actuator]:
        """Return the actuators at the supply voltage for these resistances [ohm], or those of the state."""
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

    @override
    def outputs(self) -> dict[str, Output]:
        outputs = self.of_mechanism()
        for port, one in self.actuators().items():
            for name, (unit, words, symbol) in one.own_outputs().items():
                unit = one.source.unit if name == "drive" else unit
                outputs[self.label(port, name)] = Output(unit, f"{words}, {port}", symbol)
        return outputs

    @override
    def description(self) -> str:
        kinds = Counter(
            f"{one.element.registered_name} ({one.element.law.registered_name})" for one in self.actuators().values()
        )
        words = ", ".join(f"{count} × {kind}" for kind, count in kinds.items())
        return f"{self.mechanism.registered_name} with {words or 'no elements'}"

    @override
    def arrange_outputs(
        self, actuator_outputs: list[dict[str, Scalar]], mechanism: dict[str, Scalar]
    ) -> dict[str, Scalar]:
        rows = zip(self.actuators(), actuator_outputs, strict=True)
        own = {self.label(port, name): value for port, one in rows for name, value in one.items()}
        return mechanism | own


def _list_consumers(
    actuators: Sequence[Actuator], drives: Sequence[Scalar | Feed], ohms: Sequence[Scalar]
) -> list[Consumer]:
    means = [one.moments.mean if isinstance(one, Feed) else one for one in drives]
    return [Consumer(one.source, u, r) for one, u, r in zip(actuators, means, ohms, strict=False)]


Piece = tuple[Sequence[Scalar], Scalar]
"""Signals and their duration [s]."""


def advance_steps(
    xp: Namespace, system: AbstractSystem, state: Any, pieces: Sequence[Piece], turns: int
) -> tuple[Any, StepReport]:
    """Return the state after some turns of the same pieces, and the worst report of all steps."""
    shape, size = NestedShape(state), len(flatten_numbers(state))

    def turn(*numbers: Any) -> list[Any]:
        now, worst = shape.rebuild(numbers[:size]), StepReport(*numbers[size:])
        for signals, length in pieces:
            now, report = system.step(xp, now, *signals, dt=length)
            worst = StepReport(*map(xp.maximum, worst, report))
        return flatten_numbers(now) + flatten_numbers(worst)

    begin = [*flatten_numbers(state), *(0.0 for _ in StepReport._fields)]
    after = turn(*begin) if turns == 1 else xp.repeat(turns, turn, *begin)
    return shape.rebuild(after[:size]), StepReport(*after[size:])
