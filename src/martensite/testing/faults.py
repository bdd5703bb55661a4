"""Suite for faults: active from start to end, and without effect otherwise."""

import math
from functools import cache
from typing import Any

from martensite.actuators.assembly import System
from martensite.control.faults.base import AbstractFault
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.switches import PwmVoltage
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_example, build_plant
from martensite.testing.readings import require_same_traced

MOMENTS = ((0.7, 320.0, 300.0), (0.2, 300.0, 320.0))
"""Signal, reading of a sensor, and the previous reading."""


@cache
def build_switched_plant() -> System:
    """Return the typical wire under a switched supply, which can sag."""
    return build_plant().with_parts(source=build_example(PwmVoltage))


def list_effects(
    fault: AbstractFault, xp: Namespace, time: Scalar, u: Scalar, reading: Scalar, previous: Scalar
) -> list[Scalar]:
    """Return current, heat loss, position, signal, reading, travel, and whether the reading is new, under a fault.

    The fault acts on the first drive and the first sensor that it names.
    """
    names = {kind: name for name, kind in fault.names().items()}
    drive, sensor = names.get("drive", "drive"), names.get("sensor", "temperature")
    active, grown = fault.active(xp, time), fault.fault_at(xp, time)
    plant: Any = fault.plant(xp, build_switched_plant(), active)
    fresh = fault.fresh(xp, sensor, reading > previous, active)
    return [
        plant.source.current(xp, u, 2.0),
        plant.element.heat_loss(xp, 350.0, plant.environment),
        find_position(xp, plant),
        fault.signal(xp, drive, u, active),
        grown.disturb(xp, sensor, grown.reading(xp, sensor, reading, previous, active), 1.0, active),
        fault.travel(xp, sensor, 0.1, active),
        xp.where(fresh, 1.0, 0.0),
    ]


def find_healthy(u: float, reading: float, previous: float) -> list[float]:
    """Return the same list without a fault."""
    plant: System = build_switched_plant()
    loss = plant.element.heat_loss(floats, 350.0, plant.environment)
    return [
        plant.source.current(floats, u, 2.0),
        loss,
        find_position(floats, plant),
        u,
        reading,
        0.1,
        float(reading > previous),
    ]


def find_position(xp: Namespace, plant: Any) -> Scalar:
    """Return the position [m] of the mechanism with an element 1 mm shorter than at assembly."""
    memory = plant.mechanism.init(xp, [plant.element], [2e-3], [])
    return plant.mechanism.position(xp, memory, 1.0, 1e-3)


def find_moments(fault: AbstractFault) -> tuple[list[float], list[float]]:
    """Return times outside and inside the active interval of a fault."""
    end = fault.end if math.isfinite(fault.end) else fault.start + 1.0
    outside = [0.5 * fault.start] if fault.start > 0.0 else []
    outside += [fault.end, fault.end + 1.0] if math.isfinite(fault.end) else []
    return outside, [fault.start, 0.5 * (fault.start + end)]


def check_times(fault: AbstractFault) -> None:
    """A fault is active from its start on, and inactive at its end."""
    outside, inside = find_moments(fault)
    for time, expected in [(t, False) for t in outside] + [(t, True) for t in inside]:
        active = bool(fault.active(floats, time))
        words = "there" if active else "not there"
        require_condition(
            active == expected, f"From {fault.start:g} s to {fault.end:g} s, but at {time:g} s it is {words}."
        )


def check_trace(fault: AbstractFault) -> None:
    """Before its start and after its end a fault changes nothing."""
    for time in find_moments(fault)[0]:
        for u, reading, previous in MOMENTS:
            effects = list_effects(fault, floats, time, u, reading, previous)
            healthy = find_healthy(u, reading, previous)
            require_condition(effects == healthy, f"At {time:g} s, when it is not there, it changes something.")


def check_effect(fault: AbstractFault) -> None:
    """While active, a fault changes something."""
    time = find_moments(fault)[1][-1]
    changed = any(list_effects(fault, floats, time, *row) != find_healthy(*row) for row in MOMENTS)
    require_condition(changed, "While it is there, nothing is other than without it.")


def check_traced(fault: AbstractFault) -> None:
    """The effects of a fault are a straight-line kernel."""

    def show(one: AbstractFault, xp: Namespace, *inputs: Scalar) -> tuple[Scalar, ...]:
        return tuple(list_effects(one, xp, *inputs))

    ranges = {"time": (0.0, 2.0), "u": (0.0, 1.0), "reading": (290.0, 400.0), "held": (290.0, 400)}
    require_same_traced(fault, show, ranges)
