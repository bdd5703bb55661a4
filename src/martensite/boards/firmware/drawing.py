"""Circuit diagram of a firmware, `wiring.svg`."""

from __future__ import annotations

from martensite.boards.firmware.channels import Channel
from martensite.boards.firmware.circuit import AMPLIFIER, DIFFERENCES, MARGIN, choose_fuse
from martensite.boards.firmware.settings import FirmwarePlan
from martensite.boards.firmware.symbols import (
    POWER,
    SIGNAL,
    draw_amplifier,
    draw_battery,
    draw_box,
    draw_capacitor,
    draw_dot,
    draw_fuse,
    draw_ground,
    draw_line,
    draw_mosfet,
    draw_resistor,
    write_words,
)

TOP, CELL, PLAIN, ROW = 90, 380, 300, 84
"""Top of the first drive, heights of a drive with and without measured resistance, and of a sensor [px]."""
SENSORS, BOARD, AMPLIFIERS, COLUMN, RAIL, SUPPLY = (20, 250), (420, 130), 700, 850, 1060, 1210
"""Left edge and width of sensors and board; places of amplifiers, elements, plus line and supply [px]."""


def draw_wiring(plan: FirmwarePlan, elements: list[str]) -> str:
    """Return `wiring.svg`: sensors, board, drives and supply; lines with the current of the supply are red."""
    inputs, height = plan.inputs, CELL if plan.inputs.measures_resistance else PLAIN
    steady = [one for one in inputs.channels if one.drive < 0]
    bottom = TOP + max(height * plan.drives, ROW * len(steady)) + 20
    left, width = BOARD
    parts = [draw_box(left, TOP - 20, width, bottom - TOP + 20)]
    parts += [write_words(left + width / 2, TOP - 30, plan.board.title.partition(" (")[0], "middle", 13)]
    for k, one in enumerate(steady):
        parts += _draw_sensor(plan, one, TOP + ROW * k)
    for k in range(plan.drives):
        parts += _draw_drive(plan, k, TOP + height * k, elements[k])
    parts += _draw_supply(plan, TOP + height * (plan.drives - 1), bottom)
    size = f'viewBox="0 0 {SUPPLY + 110} {bottom + 50}" width="{SUPPLY + 110}" height="{bottom + 50}"'
    words = f"{plan.core.description} on {plan.board.title}. Emulated, not built: check every line."
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12">',
            '<rect width="100%" height="100%" fill="white"/>',
            write_words(20, 28, words, size=14),
            *parts,
            "</svg>",
            "",
        ]
    )


def _draw_sensor(plan: FirmwarePlan, one: Channel, y: float) -> list[str]:
    """Return a channel that no switch interrupts, from its sensor to its pin at the left of the board."""
    left, width = SENSORS
    words, _, more = one.parts.partition(" over ")
    parts = [draw_box(left, y, width, 44), write_words(left + 8, y + 18, f"{one.name} [{one.unit}]")]
    parts += [write_words(left + 8, y + 36, words + (f" / {more}" if more else ""), size=10)]
    pins = (plan.board.name_pin(one.pin),) if one.pin >= 0 else (str(-1 - one.pin), str(-one.pin))
    for pin, shift in zip(pins, (22,) if len(pins) == 1 else (12, 32), strict=True):
        parts += [draw_line((left + width, y + shift), (BOARD[0], y + shift), ink=SIGNAL)]
        parts += [write_words(BOARD[0] + 6, y + shift + 4, pin)]
    if one.pin >= 0:
        parts += _draw_filter(left + width + 30, BOARD[0] - 40, y + 22, "1 uF")
    return parts


def _draw_filter(resistor: float, capacitor: float, y: float, farads: str) -> list[str]:
    """Return the low-pass before a pin."""
    parts = [
        draw_resistor(resistor, y, 40, upright=False),
        write_words(resistor + 20, y - 11, "1 kilohm", "middle", 10),
    ]
    return [
        *parts,
        draw_dot(capacitor, y),
        draw_capacitor(capacitor, y),
        write_words(capacitor + 12, y + 20, farads, size=10),
    ]


def _draw_drive(plan: FirmwarePlan, k: int, y: float, element: str) -> list[str]:
    """Return element, switch and ground of a drive, with shunt and amplifiers if its resistance is measured."""
    pin, edge, gate = plan.board.name_drive_pin(plan.board.drive_pins[k]), BOARD[0] + BOARD[1], y + 180
    channels = [one for one in plan.inputs.channels if one.drive == k]
    ground = y + (320 if channels else 230)
    parts = [draw_line((RAIL, y), (COLUMN, y), (COLUMN, y + 150), ink=POWER), draw_dot(RAIL, y, POWER)]
    parts += [draw_resistor(COLUMN, y + 40, 70, ink=POWER), write_words(COLUMN + 16, y + 70, element.partition(",")[0])]
    parts += [write_words(COLUMN + 16, y + 86, element.partition(", ")[2], size=10)]
    parts += [draw_mosfet(COLUMN, gate), write_words(COLUMN + 16, gate + 4, "MOSFET, n-channel, logic level")]
    parts += [write_words(COLUMN + 16, gate + 20, plan.core.outputs[k].name, size=10)]
    parts += [draw_line((COLUMN, gate + 30), (COLUMN, ground), ink=POWER), draw_ground(COLUMN, ground)]
    parts += [write_words(edge - 6, gate + 4, pin, "end"), draw_line((edge, gate), (COLUMN - 30, gate), ink=SIGNAL)]
    parts += [draw_resistor(edge + 110, gate, 40, upright=False)]
    parts += [write_words(edge + 130, gate - 11, "100 ohm", "middle", 10), draw_dot(edge + 60, gate)]
    parts += [draw_line((edge + 60, gate), (edge + 60, gate + 62)), draw_resistor(edge + 60, gate + 14)]
    parts += [draw_ground(edge + 60, gate + 62), write_words(edge + 72, gate + 38, "10 kilohm", size=10)]
    return [*parts, *_draw_measurement(plan, channels, y)]


def _draw_measurement(plan: FirmwarePlan, channels: list[Channel], y: float) -> list[str]:
    """Return shunt and amplifiers with their Kelvin leads, from the wire to the pins."""
    if not channels:
        return []
    circuit, edge = plan.inputs.circuit, BOARD[0] + BOARD[1]
    parts = [draw_resistor(COLUMN, y + 240, 50), write_words(COLUMN + 16, y + 262, f"shunt {circuit.shunt:g} ohm")]
    parts += [write_words(COLUMN + 16, y + 278, "four terminals", size=10)]
    words = (
        (-52, f"difference amplifier {circuit.ratio:g} : 1", f"100 kilohm, {DIFFERENCES[circuit.ratio]}, 0.1 %"),
        (46, f"current-sense amplifier x {AMPLIFIER:g}", "such as INA180A2"),
    )
    for one, middle, ends, (down, *labels) in zip(channels, (75, 265), ((32, 118), (234, 296)), words, strict=True):
        at = y + middle
        parts += [draw_line((edge, at), (AMPLIFIERS, at), ink=SIGNAL), draw_amplifier(AMPLIFIERS, at)]
        for sign, end in zip((-16, 16), ends, strict=True):
            bend = (AMPLIFIERS + 90, at + sign)
            lead = ((AMPLIFIERS + 60, at + sign), bend, (bend[0], y + end), (COLUMN, y + end))
            parts += [draw_line(*lead, ink=SIGNAL), draw_dot(COLUMN, y + end, SIGNAL)]
        parts += [write_words(edge - 6, at + 4, plan.board.name_pin(one.pin), "end")]
        parts += [write_words(AMPLIFIERS + 55, at + down, labels[0], "end", 10)]
        parts += [write_words(AMPLIFIERS + 55, at + down + 13, labels[1], "end", 10)]
        parts += _draw_filter(edge + 90, edge + 30, at, "1 nF")
    return parts


def _draw_supply(plan: FirmwarePlan, last: float, bottom: float) -> list[str]:
    """Return the supply with its fuse, the line to all drives, and the common ground of supply and board."""
    inputs, board = plan.inputs, BOARD[0] + BOARD[1] / 2
    fuse = choose_fuse(MARGIN * inputs.largest_current * plan.drives)
    parts = [draw_line((SUPPLY, TOP + 40), (SUPPLY, TOP), (RAIL, TOP), ink=POWER), draw_fuse(RAIL + 50, TOP)]
    parts += [draw_line((RAIL, TOP), (RAIL, last), ink=POWER)] if last > TOP else []
    parts += [write_words(RAIL + 72, TOP - 14, f"fuse {fuse:g} A", "middle"), draw_battery(SUPPLY, TOP + 40)]
    parts += [write_words(SUPPLY + 40, TOP + 66, f"{inputs.supply:g} V DC"), draw_ground(SUPPLY, TOP + 80)]
    return [*parts, draw_ground(board, bottom), write_words(board + 16, bottom + 14, "GND", size=10)]
