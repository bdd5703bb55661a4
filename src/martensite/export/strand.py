"""An element along a path of another simulator: its state, and its step on a load line.

Over one short step the path ends at

    elongation = reach - give · force,        force ≥ 0,

where `reach` is the elongation without force, and `give` its compliance (for a mass, dt² over the mass). Both are
signals from the other simulator. The element solves its step on that line, implicit in its own force. It cannot push.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.assembly import Actuator, System
from martensite.actuators.elements.base import AbstractElement, Pull, Spring
from martensite.actuators.mechanisms.base import AbstractMechanism, Column, Load, Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import flatten_numbers
from martensite.physics.laws.coupling import StepReport
from martensite.simulate.compiled import compile_system


class ElementEnd(NamedTuple):
    """Force and tangent of the element at the end of a step."""

    force: Scalar
    """Force [N]."""
    free: Scalar
    """Elongation of its tangent without force [m]; 0 before the first step."""
    compliance: Scalar
    """Compliance of its tangent [m/N]; 0 before the first step."""


class TendonLine(AbstractMechanism):
    """A straight load line, given by two signals."""

    start: Number = param("N", "force at assembly", low=0.0, high=1e6, default=0.0)

    def signals(self) -> dict[str, str]:
        """Return the path end without force, and the compliance."""
        return {"reach": "m", "give": "m/N"}

    def outputs(self) -> dict[str, Output]:
        """Return the elongation output."""
        return {"elongation": Output("m", "elongation of the path of the element", "e")}

    def convergence_scales(self) -> dict[str, float]:
        """Return an empty table: the path belongs to the other simulator."""
        return {}

    def start_forces(self, xp: Namespace) -> Column:
        """Return the start force [N]."""
        return [self.start]

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> ElementEnd:
        """Return the start force."""
        return ElementEnd(self.start, 0.0, 0.0)

    def advance(
        self, xp: Namespace, memory: ElementEnd, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[ElementEnd, list[Any], StepReport]:
        """Return the step of the element on the line."""
        ((element, state, heating),) = loads
        after, report = element.advance(xp, state, heating, _build_pull(signals), dt)
        force = element.force(after)
        return ElementEnd(force, *element.tangent(xp, after, force)), [after], report

    def observe(
        self, xp: Namespace, memory: ElementEnd, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """Return the force at which element and line meet, and the elongation there."""
        (load,) = loads
        force = load.meet_pull(xp, _build_pull(signals))
        reach, give = signals
        return [force], [reach - give * force]


def _build_pull(signals: Column) -> Pull:
    reach, give = signals

    def pull(xp: Namespace, spring: Spring) -> Scalar:
        return xp.maximum((reach - spring.free) / (give + spring.compliance), 0.0)

    return pull


class TracedStrand:
    """One traced element with its state."""

    def __init__(self, name: str, actuator: Actuator, start_force: float, slack: float, length: float) -> None:
        self.name = name
        if driven := actuator.environment.cooling.signals():
            raise ParameterError(
                f"`{name}` is cooled by the signal `{next(iter(driven))}`, which a model of another simulator cannot "
                "drive; take a cooling without a signal, such as `churchill-bernstein`."
            )
        self.system = System(
            element=actuator.element,
            environment=actuator.environment,
            source=actuator.source,
            mechanism=TendonLine(start=start_force),
        )
        self.drive = actuator.environment.temperature if actuator.source.sets_temperature else 0.0
        compiled = compile_system(self.system)
        self._observe = compiled.program.bind_floats(*compiled.values(self.system))["observe"]
        self._names = compiled.outputs
        state = self.system.init(floats, self.drive, 0.0, 0.0)
        spring = actuator.element.tangent(floats, state.elements[0], start_force)
        self.state = tuple(flatten_numbers(state))
        """Start state."""
        self.force = start_force
        self.reach = spring.free + spring.compliance * start_force - slack
        """Path elongation at the start [m]."""
        self.reference = length - self.reach
        """Path length at zero elongation of the element [m]."""

    def observe(self, state: Sequence[float], drive: float, length: float) -> dict[str, float]:
        """Measure the element.

        Args:
            state: its state.
            drive: the drive signal, in the unit of the source.
            length: length of its path [m].

        Returns:
            Outputs in SI by name.
        """
        row = self._observe(*state, drive, length - self.reference, 0.0)
        inputs = self.system.mechanism.signals()
        return {name: value for name, value in zip(self._names, row, strict=True) if name not in inputs}
