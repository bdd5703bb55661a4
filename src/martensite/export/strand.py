"""An element between two points of a machine: its state, its last forces, its step on a line.

Whatever an element pulls on, over one short step its path ends at

    elongation = reach - give · force,        force ≥ 0,

where `reach` is the elongation at which the path would end without force, and `give` is how much it yields per force
(for a mass, dt² over the mass). Both are signals of the mechanism, so that a simulator of the machine can say them;
the element solves its step on that line, implicit in its own force. It cannot push.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from martensite.actuators.assembly import Actuator, System
from martensite.actuators.elements.base import AbstractElement, Pull, Spring
from martensite.actuators.mechanisms.base import AbstractMechanism, Column, Load, Output
from martensite.base.errors import ParameterError, SolveError
from martensite.base.parameters import Number, param
from martensite.base.status import Status
from martensite.export.balance import LineStepEnd
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import flatten_numbers
from martensite.physics.laws.coupling import StepReport
from martensite.simulate.compiled import compile_system
from martensite.simulate.march import classify_step

NOTICED = 1e5
"""Stress [Pa] that counts as one."""


class ForceWeights(NamedTuple):
    """Which forces of an element act on the machine during a step, as shares that sum to 1."""

    end: float
    """Of the force at the end of the step."""
    start: float
    """Of the force at its start."""
    before: float
    """Of the force at the start of the step before."""


END = ForceWeights(1.0, 0.0, 0.0)
CENTRED = ForceWeights(0.25, 0.5, 0.25)


class ElementEnd(NamedTuple):
    """What is known of the element at the end of a step."""

    force: Scalar
    """[N]"""
    free: Scalar
    """Elongation [m] of its tangent without force; 0 before the first step."""
    compliance: Scalar
    """Of its tangent [m/N]; 0 before the first step."""


class TendonLine(AbstractMechanism):
    """A straight load line, told by two signals."""

    start: Number = param("N", "force at assembly", low=0.0, high=1e6, default=0.0)

    def signals(self) -> dict[str, str]:
        """Where the path would end without force, and how much it yields."""
        return {"reach": "m", "give": "m/N"}

    def outputs(self) -> dict[str, Output]:
        """The elongation of the path."""
        return {"elongation": Output("m", "elongation of the path of the element", "e")}

    def convergence_scales(self) -> dict[str, float]:
        """Nothing: its path is not its own."""
        return {}

    def start_forces(self, xp: Namespace) -> Column:
        """The start force [N]."""
        return [self.start]

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> ElementEnd:
        """The start force."""
        return ElementEnd(self.start, 0.0, 0.0)

    def advance(
        self, xp: Namespace, memory: ElementEnd, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[ElementEnd, list[Any], StepReport]:
        """The element solves the step by itself, against the line."""
        ((element, state, heating),) = loads
        after, report = element.advance(xp, state, heating, _build_pull(signals), dt)
        force = element.force(after)
        return ElementEnd(force, *element.tangent(xp, after, force)), [after], report

    def observe(
        self, xp: Namespace, memory: ElementEnd, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """The force at which element and line meet, and the elongation of the path there."""
        (load,) = loads
        force = load.meet_pull(xp, _build_pull(signals))
        reach, give = signals
        return [force], [reach - give * force]


def _build_pull(signals: Column) -> Pull:
    """The line as the element sees it."""
    reach, give = signals

    def pull(xp: Namespace, spring: Spring) -> Scalar:
        return xp.maximum((reach - spring.free) / (give + spring.compliance), 0.0)

    return pull


class TracedStrand:
    """The step of one element, traced, and what it remembers."""

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
        functions = compiled.program.bind_floats(*compiled.values(self.system))
        self._step, self._observe = functions["step"], functions["observe"]
        self._names = compiled.outputs
        state = self.system.init(floats, self.drive, 0.0, 0.0)
        spring = actuator.element.tangent(floats, state.elements[0], start_force)
        self.state = tuple(flatten_numbers(state))
        self.force = self.before = start_force
        self.line = spring.free + spring.compliance * start_force - slack, 0.0
        self.reference = length - self.line[0]
        """Length of the path at which the element has no elongation [m]."""
        one = actuator.observe_element(floats, state.elements[0], 1.0, self.drive)
        self.least = NOTICED / one["stress"]
        """Force that counts as one [N]."""
        self.status = Status.OK
        """Of the last step."""

    def trial(self, drive: float, dt: float) -> Callable[[float, float], LineStepEnd]:
        """The next step as a function of the line; commits nothing."""

        def answer(reach: float, give: float) -> LineStepEnd:
            return self._answer(drive, dt, reach, give)

        return answer

    def _answer(self, drive: float, dt: float, reach: float, give: float) -> LineStepEnd:
        try:
            *state, residual, crossing = self._step(*self.state, drive, reach, give, dt)
        except ArithmeticError:  # a division by zero or an overflow
            return LineStepEnd(self.state, math.nan, math.nan, math.nan, math.inf, 0.0)
        force, free, compliance = state[-len(ElementEnd._fields) :]  # what the line holds comes last
        return LineStepEnd(tuple(state), force, free, compliance, residual, crossing)

    def held(self, weights: ForceWeights) -> float:
        """The share of the tension of the next step that is known [N]."""
        return weights.start * self.force + weights.before * self.before

    def require(self, answer: LineStepEnd, time: float) -> Status:
        """Status of an answer, or `SolveError` if it cannot be trusted."""
        status = classify_step(answer.residual, answer.crossing)
        if not math.isfinite(sum(answer.state)):
            status = Status.NOT_FINITE
        if status.failed:
            raise SolveError(
                f"The element at tendon `{self.name}` failed in the step at t = {time:.6g} s. {status.sentence}"
            )
        return status

    def commit(self, answer: LineStepEnd, drive: float, length: float, time: float) -> None:
        """Take an answer; `length` [m] is that of the path in the end."""
        self.status = self.require(answer, time)
        self.state, self.before, self.force = answer.state, self.force, answer.force
        self.drive = drive
        self.line = length - self.reference, 0.0

    def observe(self, drive: float) -> dict[str, float]:
        """Everything that can be measured on the element, in SI, by name."""
        row = self._observe(*self.state, drive, *self.line)
        found = dict(zip(self._names, row, strict=True))
        known = self.system.mechanism.signals()
        return {name: value for name, value in found.items() if name not in known}
