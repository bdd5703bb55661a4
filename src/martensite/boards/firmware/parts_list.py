"""List of parts for the wiring of a firmware, from its scenario."""

from __future__ import annotations

from dataclasses import dataclass

from martensite.base.formats import write_quantity
from martensite.boards.firmware.circuit import AMPLIFIER, DIFFERENCES, DIVIDERS, MARGIN, choose_divider, choose_fuse
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
    most, circuit = inputs.largest_current, inputs.circuit
    whole = MARGIN * most * drives
    parts = [
        WiringPart(1, "supply", f"{inputs.supply:g} V DC, at least {whole:.3g} A"),
        WiringPart(1, "fuse, in the positive line of the supply", f"{choose_fuse(whole):g} A, fast"),
        *(WiringPart(1, "element", one) for one in elements),
        WiringPart(
            drives,
            "MOSFET, n-channel, logic level",
            f"at least {SPARE * inputs.supply:.3g} V and {SPARE * most:.3g} A, full on at {plan.board.volts:g} V",
        ),
        WiringPart(drives, "resistor, in the line of the gate", "100 ohm"),
        WiringPart(drives, "resistor, from the gate to ground", "10 kilohm"),
    ]
    if (wires := sum(one.ratio for one in inputs.readings)) > 0:
        heat = max(SPARE * circuit.shunt * most**2, 0.1)
        parts += [
            WiringPart(wires, "shunt, with Kelvin terminals", f"{circuit.shunt:g} ohm, 1 %, at least {heat:.2g} W"),
            WiringPart(wires, "current-sense amplifier", f"x {AMPLIFIER:g}, at least 200 kHz, such as INA180A2"),
            WiringPart(wires, "operational amplifier, rail to rail", f"at least 1 MHz, on {plan.board.volts:g} V"),
            WiringPart(2 * wires, "resistor, before the operational amplifier", "100 kilohm, 0.1 %"),
            WiringPart(2 * wires, "resistor, feedback and to ground", f"{DIFFERENCES[circuit.ratio]}, 0.1 %"),
        ]
    for one in inputs.channels:
        if one.pin < 0 or not one.name.endswith(("current", "voltage")):
            parts.append(WiringPart(1, "encoder" if one.pin < 0 else "sensor", f"{one.name}: {one.parts}"))
    if inputs.supply_channel >= 0 and (upper := DIVIDERS[choose_divider(inputs.supply, plan.board)]):
        parts.append(WiringPart(1, "divider of the supply", f"10 kilohm to ground, {upper} above"))
    pulsed = sum(one.drive >= 0 for one in inputs.channels)
    steady = sum(one.pin >= 0 for one in inputs.channels) - pulsed
    parts.append(WiringPart(pulsed + steady, "resistor, before an input", "1 kilohm"))
    parts += [WiringPart(steady, "capacitor, from an input to ground", "1 uF")] if steady else []
    parts += [WiringPart(pulsed, "capacitor, from an input to ground", "1 nF, at the amplifiers")] if pulsed else []
    return parts
