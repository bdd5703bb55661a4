"""Drawing of the wiring of a firmware, `wiring.svg`."""

from __future__ import annotations

from html import escape

from martensite.boards.firmware.circuit import MARGIN
from martensite.boards.firmware.settings import FirmwarePlan

STEP, TOP = 64, 70
"""Distance of pins, and top of the first one [px]."""
SENSORS, BOARD, SWITCH, SUPPLY = (20, 280), (410, 150), (720, 110), (960, 150)
"""Left edge and width of a column [px]."""


def draw_wiring(plan: FirmwarePlan, elements: list[str]) -> str:
    """Return `wiring.svg`: sensors, board, switches, elements, supply; power lines are red, signals grey."""
    board, inputs = plan.board, plan.inputs
    rows = max(len(inputs.channels), 2 * plan.drives + 1)
    height = TOP + STEP * rows + 40
    measured = any(one.name.startswith("current") for one in inputs.channels)
    ground = height - 24
    parts = [_draw_box(BOARD[0], TOP - 20, BOARD[1], STEP * rows, [board.title.partition(" (")[0]], thick=True)]
    for k, one in enumerate(inputs.channels):
        y = TOP + STEP * k
        pin = board.name_pin(one.pin) if one.pin >= 0 else f"{-1 - one.pin}, {-one.pin}"
        low = ["1 kilohm, 1 uF"] if one.pin >= 0 else []
        parts.append(_draw_box(SENSORS[0], y, SENSORS[1], 44, [f"{one.name} [{one.unit}]", one.parts]))
        parts.append(_draw_line([(SENSORS[0] + SENSORS[1], y + 22), (BOARD[0], y + 22)], "#777", low))
        parts.append(_write_words(BOARD[0] + 6, y + 26, pin))
    for k in range(plan.drives):
        y, middle = TOP + 2 * STEP * k, SWITCH[0] + SWITCH[1] // 2
        pin = board.name_drive_pin(board.drive_pins[k])
        parts.append(
            _draw_line([(BOARD[0] + BOARD[1], y + 86), (SWITCH[0], y + 86)], "#777", ["100 ohm", "10 kilohm to ground"])
        )
        parts.append(_write_words(BOARD[0] + BOARD[1] - 6, y + 90, pin, "end"))
        parts.append(_draw_box(SWITCH[0], y + 64, SWITCH[1], 44, ["MOSFET", plan.core.outputs[k].name]))
        parts.append(_draw_box(SWITCH[0], y - 12, SWITCH[1], 48, ["element", elements[k].partition(",")[0]], "#b3261e"))
        parts.append(_draw_line([(middle, y + 36), (middle, y + 64)], "#b3261e"))
        parts.append(_draw_line([(SUPPLY[0], y + 18), (SWITCH[0] + SWITCH[1], y + 18)], "#b3261e"))
        shunt = [f"shunt {inputs.circuit.shunt:g} ohm"] if measured else []
        parts.append(_draw_line([(middle, y + 108), (middle, ground)], "#222", shunt))
    fuse = MARGIN * inputs.largest_current * plan.drives
    parts.append(_draw_box(SUPPLY[0], TOP - 20, SUPPLY[1], 90, [f"supply {inputs.supply:g} V", f"fuse {fuse:.3g} A"]))
    for x, y in ((SUPPLY[0] + SUPPLY[1] // 2, TOP + 70), (BOARD[0] + BOARD[1] // 2, TOP - 20 + STEP * rows)):
        parts.append(_draw_line([(x, y), (x, ground)], "#222"))
    parts.append(_draw_line([(BOARD[0], ground), (SUPPLY[0] + SUPPLY[1], ground)], "#222"))
    parts.append(_write_words(BOARD[0] + BOARD[1] + 10, ground - 6, "ground, shared"))
    width = SUPPLY[0] + SUPPLY[1] + 20
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    style = ' font-family="sans-serif" font-size="12">\n<rect width="100%" height="100%" fill="white"/>'
    title = _write_words(
        20, 28, f"Wiring of {plan.core.description} on {board.title}. Emulated, not built: check every line."
    )
    return "\n".join([head + style, title, *parts, "</svg>", ""])


def _draw_box(x: int, y: int, width: int, height: int, words: list[str], ink: str = "#222", thick: bool = False) -> str:
    stroke = 2 if thick else 1.2
    box = (
        f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="none" stroke="{ink}" stroke-width="{stroke}"/>'
    )
    lines = [_write_words(x + width // 2, y + 16 + 16 * k, one, "middle") for k, one in enumerate(words)]
    return "\n".join([box, *lines])


def _draw_line(points: list[tuple[int, int]], ink: str, words: list[str] | None = None) -> str:
    way = " ".join(f"{x},{y}" for x, y in points)
    (x, y), (x2, y2) = points[-2:]
    line = f'<polyline points="{way}" fill="none" stroke="{ink}" stroke-width="1.2"/>'
    places = zip((y - 4, y + 14), words or [], strict=False)
    if x == x2:
        return "\n".join([line, *(_write_words(x + 6, (y + y2) // 2, one) for one in words or [])])
    return "\n".join([line, *(_write_words((x + x2) // 2, at, one, "middle") for at, one in places)])


def _write_words(x: int, y: int, words: str, anchor: str = "start") -> str:
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}">{escape(words)}</text>'
