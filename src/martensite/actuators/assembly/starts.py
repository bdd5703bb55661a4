"""Initial states of actuators; equal structures are traced once, in a loop."""

from collections.abc import Sequence
from typing import Any

from martensite.actuators.assembly.actuator import Actuator
from martensite.actuators.mechanics.equal_elements import LEAST_ELEMENTS, group_alike
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

Row = tuple[Actuator, Scalar, Scalar]
"""Actuator, force on its element [N], drive signal."""


def start_actuators(xp: Namespace, rows: Sequence[Row]) -> list[tuple[Any, Scalar]]:
    """Return the initial state and elongation [m] of each element."""
    starts: dict[int, tuple[Any, Scalar]] = {}
    for places in group_alike([(one,) for one, _, _ in rows]):
        chosen = [rows[i] for i in places]
        alike = len(places) >= LEAST_ELEMENTS
        ends = _start_alike(xp, chosen) if alike else [_start_one(xp, *one) for one in chosen]
        starts |= zip(places, ends, strict=True)
    return [starts[i] for i in range(len(rows))]


def _start_one(xp: Namespace, one: Actuator, force: Scalar, drive: Scalar) -> tuple[Any, Scalar]:
    state = one.start(xp, force, drive)
    return state, one.element.elongation(xp, state, force)


def _start_alike(xp: Namespace, rows: Sequence[Row]) -> list[tuple[Any, Scalar]]:
    """Return the same for actuators of one structure with different parameters."""
    first, shapes = rows[0][0], list[NestedShape]()
    paths = [leaf.path for leaf in first.leaves()]

    def start(force: Scalar, drive: Scalar, *values: Scalar) -> list[Scalar]:
        one = first.rebuilt(dict(zip(paths, values, strict=True)))
        end = _start_one(xp, one, force, drive)
        shapes.append(NestedShape(end))
        return flatten_numbers(end)

    numbers = [[force, drive, *(leaf.value for leaf in one.leaves())] for one, force, drive in rows]
    columns = xp.each(start, *zip(*numbers, strict=True))
    return [shapes[0].rebuild(flat) for flat in zip(*columns, strict=True)]
