"""The start of actuators: alike ones in one loop, traced once, however many there are."""

from collections.abc import Sequence
from typing import Any

from martensite.actuators.assembly.actuator import Actuator
from martensite.actuators.mechanics.equal_elements import LEAST_ELEMENTS, group_alike
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

Row = tuple[Actuator, Scalar, Scalar]
"""An actuator, the force on its element [N], and its drive signal."""


def start_actuators(xp: Namespace, rows: Sequence[Row]) -> list[tuple[Any, Scalar]]:
    """Return state and elongation [m] of every element at the start."""
    found: dict[int, tuple[Any, Scalar]] = {}
    for places in group_alike([(one,) for one, _, _ in rows]):
        chosen = [rows[i] for i in places]
        alike = len(places) >= LEAST_ELEMENTS
        found |= zip(
            places, _start_alike(xp, chosen) if alike else [_start_one(xp, *one) for one in chosen], strict=True
        )
    return [found[i] for i in range(len(rows))]


def _start_one(xp: Namespace, one: Actuator, force: Scalar, drive: Scalar) -> tuple[Any, Scalar]:
    state = one.start(xp, force, drive)
    return state, one.element.elongation(xp, state, force)


def _start_alike(xp: Namespace, rows: Sequence[Row]) -> list[tuple[Any, Scalar]]:
    """Return the same for actuators of one structure, whose numbers may differ."""
    first, shapes = rows[0][0], list[NestedShape]()
    paths = [leaf.path for leaf in first.leaves()]

    def start(force: Scalar, drive: Scalar, *values: Scalar) -> list[Scalar]:
        one = first.rebuilt(dict(zip(paths, values, strict=True)))
        found = _start_one(xp, one, force, drive)
        shapes.append(NestedShape(found))
        return flatten_numbers(found)

    numbers = [[force, drive, *(leaf.value for leaf in one.leaves())] for one, force, drive in rows]
    columns = xp.each(start, *zip(*numbers, strict=True))
    return [shapes[0].rebuild(flat) for flat in zip(*columns, strict=True)]
