"""Systems: one element on a mechanism, or an actuator at every port of one; and a system through some equal steps."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from martensite.actuators.assembly.actuator import Actuator, Group
from martensite.actuators.assembly.base import AbstractAssembly, AbstractSystem, State
from martensite.actuators.assembly.outputs import OBSERVABLES
from martensite.actuators.mechanisms.base import Column, Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.laws.coupling import StepReport

T = TypeVar("T")


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
        """The plain name: there is one actuator."""
        return name

    def drive_at(self, port: str) -> str:
        """`drive`."""
        return "drive"

    def outputs(self) -> dict[str, Output]:
        """Those of the element, and after the force those of the mechanism."""
        own = self.own_outputs()
        found = _insert_mechanism(own, self.of_mechanism())
        return found | {"drive": own["drive"]._replace(unit=self.source.unit)}

    def description(self) -> str:
        """Such as `wire (brinson) on bias-spring, driven by power`."""
        element, load = self.element, self.mechanism.registered_name
        names = f"{element.registered_name} ({element.law.registered_name})"
        return f"{names} on {load}, driven by {self.source.registered_name}"

    def arrange_outputs(self, seen: list[dict[str, Scalar]], mechanism: dict[str, Scalar]) -> dict[str, Scalar]:
        """Those of the element, and after the force those of the mechanism."""
        (one,) = seen
        return _insert_mechanism(one, mechanism)

    def profile(self, state: State) -> list[Column]:  # type: ignore[override]
        """What differs along the element; described in `PROFILES`."""
        return list(self.element.profile(state.elements[0]))


def _insert_mechanism(own: Mapping[str, T], mechanism: Mapping[str, T]) -> dict[str, T]:
    later = {name: one for name, one in own.items() if OBSERVABLES[name].after_mechanism}
    first = {name: one for name, one in own.items() if name not in later}
    return {**first, **mechanism, **later}


class Machine(AbstractAssembly):
    """A mechanism and the actuators at its ports; outputs are called `port.temperature`."""

    group: Group = part("actuators by port", default=Group())

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
        """The name of the port."""
        return port

    def outputs(self) -> dict[str, Output]:
        """Those of the mechanism, then those of every actuator."""
        found = self.of_mechanism()
        for port, one in self.actuators().items():
            for name, (unit, words, symbol) in one.own_outputs().items():
                unit = one.source.unit if name == "drive" else unit
                found[self.label(port, name)] = Output(unit, f"{words}, {port}", symbol)
        return found

    def description(self) -> str:
        """Such as `parallel-platform with 3 × coil-spring (liang-rogers)`."""
        kinds = Counter(
            f"{one.element.registered_name} ({one.element.law.registered_name})" for one in self.actuators().values()
        )
        words = ", ".join(f"{count} × {kind}" for kind, count in kinds.items())
        return f"{self.mechanism.registered_name} with {words or 'no elements'}"

    def arrange_outputs(self, seen: list[dict[str, Scalar]], mechanism: dict[str, Scalar]) -> dict[str, Scalar]:
        """Those of the mechanism, then those of every actuator."""
        rows = zip(self.actuators(), seen, strict=True)
        own = {self.label(port, name): value for port, one in rows for name, value in one.items()}
        return mechanism | own


Piece = tuple[Sequence[Scalar], Scalar]
"""Signals, and for how long [s]."""


def advance_steps(
    xp: Namespace, system: AbstractSystem, state: Any, pieces: Sequence[Piece], turns: int
) -> tuple[Any, StepReport]:
    """The state after some turns of the same pieces, and the worst report of all steps."""
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
