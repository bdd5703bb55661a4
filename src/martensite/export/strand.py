"""An element between two points of a machine: its state, and its step on a load line.

Whatever an element pulls on, over one short step its path ends at

    elongation = reach - give · force,        force ≥ 0,

where `reach` is the elongation at which the path would end without force, and `give` is how much it yields per force
(for a mass, dt² over the mass). Both are signals of the mechanism, so that a simulator of the machine can say them;
the element solves its step on that line, implicit in its own force. It cannot push.
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
    """State and outputs of the element at the end of a step."""

    force: Scalar
    """[N]"""
    free: Scalar
    """Elongation [m] of its tangent without force; 0 before the first step."""
    compliance: Scalar
    """Compliance of the tangent of the element [m/N]; 0 before the first step."""


class TendonLine(AbstractMechanism):
    """A straight load line, told by two signals."""

    start: Number = param("N", "force at assembly", low=0.0, high=1e6, default=0.0)

    def signals(self) -> dict[str, str]:
        """Return the signals: end of the path without force, and compliance."""
        return {"reach": "m", "give": "m/N"}

    def outputs(self) -> dict[str, Output]:
        """Return the elongation of the path."""
        return {"elongation": Output("m", "elongation of the path of the element", "e")}

    def convergence_scales(self) -> dict[str, float]:
        """Nothing: its path is not its own."""
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
        """The element solves the step alone, on the line."""
        ((element, state, heating),) = loads
        after, report = element.advance(xp, state, heating, _build_pull(signals), dt)
        force = element.force(after)
        return ElementEnd(force, *element.tangent(xp, after, force)), [after], report

    def observe(
        self, xp: Namespace, memory: ElementEnd, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """Return the force at which element and line meet, and the elongation of the path there."""
        (load,) = loads
        force = load.meet_pull(xp, _build_pull(signals))
        reach, give = signals
        return [force], [reach - give * force]


def _build_pull(signals: Column) -> Pull:
    """Return the line as the element sees it."""
    reach, give = signals

    def pull(xp: Namespace, spring: Spring) -> Scalar:
        return xp.maximum((reach - spring.free) / (give + spring.compliance), 0.0)

    return pull


class TracedStrand:
    """One element, traced, with its state."""

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
        """At the start."""
        self.force = start_force
        self.reach = spring.free + spring.compliance * start_force - slack
        """Elongation of the path at the start [m]."""
        self.reference = length - self.reach
        """Length of the path at which the element has no elongation [m]."""

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
