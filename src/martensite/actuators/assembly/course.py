"""A system through a period: some equal steps under constant signals, as one loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from martensite.actuators.assembly.base import AbstractSystem
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.laws.coupling import StepReport

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
