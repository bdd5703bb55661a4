"""A system of one element: what drives it, what surrounds it and what it pulls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from martensite.actuators.assembly.actuator import Actuator
from martensite.actuators.assembly.base import AbstractAssembly, State
from martensite.actuators.assembly.outputs import OBSERVABLES, OUTPUTS
from martensite.actuators.mechanisms.base import Column, Output
from martensite.base.errors import ParameterError
from martensite.kernels.namespace import Scalar

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
        found = _insert_mechanism(OUTPUTS, self.of_mechanism())
        return found | {"drive": OUTPUTS["drive"]._replace(unit=self.source.unit)}

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
    """Entries of the mechanism among those of the element."""
    later = {name: one for name, one in own.items() if OBSERVABLES[name].after_mechanism}
    first = {name: one for name, one in own.items() if name not in later}
    return {**first, **mechanism, **later}
