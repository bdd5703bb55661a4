"""A machine: a mechanism with any number of ports, and an actuator at every one of them."""

from __future__ import annotations

from collections import Counter

from martensite.actuators.assembly.actuator import Actuator, Group
from martensite.actuators.assembly.base import AbstractAssembly
from martensite.actuators.assembly.outputs import OUTPUTS
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import part
from martensite.kernels.namespace import Scalar


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
            for name, (unit, words, symbol) in OUTPUTS.items():
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
