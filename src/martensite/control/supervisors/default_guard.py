"""The guard that a loop has if nothing else is said: bounds on the temperature that limit and do not cut.

One for every element that a controller heats, at the `temperature_limit` of the element, in the surroundings and with
the cooling of its environment (`martensite.control.supervisors.from_plant`). Where there can be none, that is said.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.errors import InputError
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.controllers.base import AbstractController
from martensite.control.supervisors.from_plant import find_bound
from martensite.signals.base import DRIVE

ANSWER = "limit"


def list_heated(plant: AbstractSystem, controllers: Mapping[str, AbstractController]) -> dict[str, Actuator]:
    """Return the actuators that a controller heats, by their drive."""
    at = {plant.drive_at(port): one for port, one in plant.actuators().items()}
    return {drive: one for drive, one in at.items() if drive in controllers and not one.source.sets_temperature}


def find_full_signal(one: Actuator, controller: AbstractController | None) -> float:
    """Return the largest signal of an actuator, in the unit of its source: 1 for a duty, else that of its controller.

    Raises:
        InputError: its controller has no largest signal.
    """
    if one.source.unit == "1":
        return 1.0
    levels = [] if controller is None else [leaf.value for leaf in controller.leaves() if leaf.declared.unit == DRIVE]
    most = max((abs(level) for level in levels if math.isfinite(level)), default=0.0)
    if most <= 0.0:
        raise InputError(f"The controller has no largest signal in {one.source.unit}.")
    return most


def find_default_bounds(
    plant: AbstractSystem,
    controllers: Mapping[str, AbstractController],
    *,
    temperature_limit: float | None = None,
    hottest: float | None = None,
    least_cooling: float = 1.0,
    full: float | None = None,
) -> tuple[dict[str, ThermalBound], list[str]]:
    """Return bounds by the name of the check, and sentences on elements that have none; numbers as for `guard_for`."""
    found, said, heated = dict[str, ThermalBound](), list[str](), list_heated(plant, controllers)
    for drive, one in heated.items():
        limit = one.element.limits.temperature_limit if temperature_limit is None else temperature_limit
        if not math.isfinite(limit):
            said.append(
                f"No guard: the element at `{drive}` has no `temperature_limit`; give one in its `limits`, or write "
                f'`from_plant = {{ temperature_limit = "110 degC" }}` in [supervisor].'
            )
            continue
        try:
            most = full or find_full_signal(one, controllers[drive])
            bound = find_bound(one, drive, limit, most, hottest, least_cooling)
        except InputError as error:
            said.append(f"No guard of `{drive}`: {error}")
            continue
        found[f"bound_{drive}"] = bound.with_parts(drives=() if len(plant.actuators()) == 1 else (drive,))
    return found, said
