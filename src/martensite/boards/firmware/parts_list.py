"""List of parts for the wiring of a firmware, from its scenario."""

from __future__ import annotations

from dataclasses import dataclass

from martensite.base.formats import write_quantity
from martensite.boards.firmware.channels import AMPLIFIER, MARGIN, SHUNT
from martensite.boards.firmware.settings import FirmwarePlan
from martensite.control.loop.bench import Bench

SPARE = 2.0
"""Safety factor of the rating of a switch and of the power of a shunt."""


@dataclass(frozen=True)
class WiringPart:
    """One line of a part list."""

    count: int
    name: str
    rating: str


def describe_elements(bench: Bench) -> list[str]:
    """Return the element of every actuator, with diameter and length if it has them."""
    descriptions: list[str] = []
    for one in bench.plant.actuators().values():
        words = [one.element.registered_name]
        for name in ("diameter", "length"):
            value = getattr(one.element, name, None)
            if isinstance(value, float):
                words.append(f"{name} {write_quantity(value, 'm')}")
        descriptions.append(", ".join(words))
    return descriptions


def list_wiring_parts(plan: FirmwarePlan, elements: list[str]) -> list[WiringPart]:
    """Return the parts of the wiring."""
    inputs, drives = plan.inputs, plan.drives
    most, analog = inputs.largest_current, [one for one in inputs.channels if one.pin >= 0]
    shunts = sum(one.name.startswith("current") for one in analog)
    divided = [
        one.parts for one in analog if one.parts.startswith("divider") and not one.parts.startswith("divider 1 :")
    ]
    parts = [
        WiringPart(1, "supply", f"{inputs.supply:g} V, at least {MARGIN * most * drives:.3g} A"),
        WiringPart(1, "fuse, behind the supply", f"{MARGIN * most * drives:.3g} A"),
        *(WiringPart(1, "element", one) for one in elements),
        WiringPart(
            drives,
            "MOSFET, n-channel, logic level",
            f"at least {SPARE * inputs.supply:.3g} V and {SPARE * most:.3g} A, full on at {plan.board.volts:g} V",
        ),
        WiringPart(drives, "resistor, in the line of the gate", "100 ohm"),
        WiringPart(drives, "resistor, from the gate to ground", "10 kilohm"),
    ]
    if shunts:
        heat = SPARE * SHUNT * most**2
        parts.append(WiringPart(shunts, "shunt", f"{SHUNT:g} ohm, 1 %, at least {max(heat, 0.1):.2g} W"))
        parts.append(WiringPart(shunts, "amplifier for a shunt", f"x {AMPLIFIER:g}"))
    parts += [WiringPart(1, one.partition(" across")[0], "10 kilohm to ground, the rest above") for one in divided]
    parts += [
        WiringPart(1, "encoder" if one.pin < 0 else "sensor", f"{one.name}: {one.parts}")
        for one in inputs.channels
        if not one.name.startswith(("current", "voltage", "supply"))
    ]
    if analog:
        parts.append(WiringPart(len(analog), "resistor, before an input", "1 kilohm"))
        parts.append(WiringPart(len(analog), "capacitor, from an input to ground", "1 uF"))
    return parts
