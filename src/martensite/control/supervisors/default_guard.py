"""Default guard of a loop: temperature bounds that limit signals and do not cut.

Every element that a controller heats gets a bound at its `temperature_limit`, with the ambient temperature and the
cooling of its environment (`martensite.control.supervisors.from_plant`).
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
    """Return the actuators that a controller heats, by drive."""
    at = {plant.drive_at(port): one for port, one in plant.actuators().items()}
    return {drive: one for drive, one in at.items() if drive in controllers and not one.source.sets_temperature}


def find_full_signal(one: Actuator, controller: AbstractController | None) -> float:
    """Return the largest signal of an actuator: 1 for a duty cycle, else the largest signal of its controller.

    Raises:
        InputError: the controller has no largest signal.
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
    """Return the bounds by the name of the check, and remarks on elements without a bound.

    The options are those described at `build_thermal_guard`.
    """
    bounds, remarks = dict[str, ThermalBound](), list[str]()
    for drive, one in list_heated(plant, controllers).items():
        limit = one.element.limits.temperature_limit if temperature_limit is None else temperature_limit
        if not math.isfinite(limit):
            remarks.append(
                f"No guard: the element at `{drive}` has no `temperature_limit`; give one in its `limits`, or write "
                f'`from_plant = {{ temperature_limit = "110 degC" }}` in [supervisor].'
            )
            continue
        try:
            most = full or find_full_signal(one, controllers[drive])
            bound = find_bound(one, drive, limit, most, hottest, least_cooling)
        except InputError as error:
            remarks.append(f"No guard of `{drive}`: {error}")
            continue
        bounds[f"bound_{drive}"] = bound.with_parts(drives=() if len(plant.actuators()) == 1 else (drive,))
    return bounds, remarks
