"""A load line that is given anew in every step: how an element meets the rest of a machine.

Whatever an element pulls on, over one short step its path ends at

    elongation = reach - give · force,        force ≥ 0,

where `reach` is the elongation at which the path would end without force, and `give` is how
much it yields per force (for a mass, dt² over the mass). Both are signals of the mechanism, so
that a simulator of the machine can say them; the element solves its step on that line, implicit
in its own force. It cannot push.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.elements.base import AbstractElement, Pull, Spring, equilibrium_force
from martensite.actuators.mechanisms.base import AbstractMechanism, Column, Load, Output
from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport


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

    start: Scalar = param("N", "force at assembly", low=0.0, high=1e6, default=0.0)

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
        ((element, state, _),) = loads

        def tangent(xp: Namespace, force: Scalar) -> Spring:
            return element.tangent(xp, state, force)

        force = equilibrium_force(xp, tangent, _build_pull(signals), element.force(state), element.passes)
        reach, give = signals
        return [force], [reach - give * force]


def _build_pull(signals: Column) -> Pull:
    """The line as the element sees it."""
    reach, give = signals

    def pull(xp: Namespace, spring: Spring) -> Scalar:
        return xp.maximum((reach - spring.free) / (give + spring.compliance), 0.0)

    return pull
