"""Wiring list of a firmware, `WIRING.md`."""

from __future__ import annotations

from martensite.boards.firmware.parts_list import list_wiring_parts
from martensite.boards.firmware.settings import FirmwarePlan


def describe_wiring(name: str, plan: FirmwarePlan, elements: list[str]) -> str:
    """Return the text of `WIRING.md`."""
    board, inputs = plan.board, plan.inputs
    rows = [
        f"# Wiring of `{name}` on {board.title}",
        "",
        "This firmware was compiled and run on emulators, not on a board. Check every line before you wire a supply.",
        "",
        "| from | through | to |",
        "|---|---|---|",
    ]
    ends = "the element, then the switch" + (", then the shunt" if inputs.measures_resistance else "")
    for k, one in enumerate(plan.core.outputs[: plan.drives]):
        pin = board.name_drive_pin(board.drive_pins[k])
        rows.append(
            f"| pin {pin} | 100 ohm, and 10 kilohm from the gate to ground | gate of the switch of `{one.name}` |"
        )
        rows.append(f"| plus of the supply, {inputs.supply:g} V | the fuse, {ends} | ground |")
    for one in inputs.channels:
        pin = board.name_pin(one.pin) if one.pin >= 0 else f"{-1 - one.pin} and {-one.pin}"
        low = "" if one.pin < 0 else f"; then 1 kilohm, and {'1 uF' if one.drive < 0 else '1 nF'} to ground"
        rows.append(f"| {one.name} [{one.unit}] | {one.parts}{low} | pin {pin} |")
    rows += [
        "| minus of the supply | | ground of the board |",
        "",
        describe_measurement(plan),
        "",
        "![wiring](wiring.svg)",
        "",
        "## Parts",
        "",
        "| count | part | rating |",
        "|---|---|---|",
        *(f"| {one.count} | {one.name} | {one.rating} |" for one in list_wiring_parts(plan, elements)),
        "",
        "The gate is held off while the board starts. Signals stay off until the host arms, and go off "
        f"{1e3 * plan.limits.silence:g} ms after it was heard last, below {plan.settings[1].value:.3g} V of supply, "
        f"and above {plan.settings[2].value:.3g} A where a current is measured.",
        "",
    ]
    return "\n".join(rows)


def describe_measurement(plan: FirmwarePlan) -> str:
    """Describe frequency of the pulses, and noise and least duty cycle of a measured resistance."""
    inputs, circuit = plan.inputs, plan.inputs.circuit
    words = f"The switches close at {inputs.frequency:g} Hz."
    if not inputs.measures_resistance:
        return words
    return (
        f"{words} Resistance is read within a pulse, at least {1e6 * circuit.settle:.3g} us after the switch closes, "
        f"at duty cycles from {100.0 * inputs.least_duty:.2g} %. The standard deviation of a reading is "
        f"{100.0 * circuit.noise:.2g} %, from converter and amplifier at the lowest current."
    )
