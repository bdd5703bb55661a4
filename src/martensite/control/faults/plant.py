"""How a fault gets into a plant: a twin of it in which parts of its actuators are exchanged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised

Change = Callable[[Actuator], Mapping[str, Any]]
"""An actuator -> what is exchanged in it, by path, such as `source.supply`."""


def change_plant(plant: AbstractSystem, drive: str, change: Change) -> AbstractSystem:
    """A twin of a plant with the actuator of one drive changed, or with all of them.

    Args:
        plant: the plant; its numbers may be traced.
        drive: name of the drive; all of the actuators if it is empty.
        change: what is exchanged in an actuator.

    Raises:
        ParameterError: the drive is that of a mechanism, not of an actuator.
    """
    at = {plant.drive_at(port): one for port, one in plant.actuators().items()}
    if drive and drive not in at:
        raise ParameterError(f"A fault of an actuator needs the drive of one, not `{drive}`. {suggest_name(drive, at)}")
    places = {id(one): prefix for prefix, one in _list_placed(plant, "")}
    found: dict[str, Any] = {}
    for name, one in at.items():
        if drive in ("", name):
            prefix = places[id(one)]
            found |= {prefix + path: value for path, value in change(one).items()}
    return plant.rebuilt(found)


def _list_placed(part: Parametrised, prefix: str) -> Iterator[tuple[str, Parametrised]]:
    """Everything in a tree, with its path."""
    yield prefix, part
    for name, child in part.children():
        yield from _list_placed(child, f"{prefix}{name}.")
