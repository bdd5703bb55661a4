"""Symbols of electronics as SVG, after IEC 60617; every function returns elements around a point [px]."""

from __future__ import annotations

from html import escape

INK, POWER, SIGNAL = "#222", "#b3261e", "#1f4e79"
"""Colours of symbols, of lines with the current of the supply, and of signals."""
Point = tuple[float, float]


def draw_line(*points: Point, ink: str = INK) -> str:
    """Return a line through points."""
    places = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{places}" fill="none" stroke="{ink}" stroke-width="1.4"/>'


def draw_box(x: float, y: float, width: float, height: float, ink: str = INK) -> str:
    """Return a rectangle with its upper left corner at a point."""
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" fill="white" stroke="{ink}" '
        'stroke-width="1.4"/>'
    )


def draw_dot(x: float, y: float, ink: str = INK) -> str:
    """Return a connection of lines."""
    return f'<circle cx="{x:g}" cy="{y:g}" r="3" fill="{ink}"/>'


def write_words(x: float, y: float, words: str, anchor: str = "start", size: int = 12) -> str:
    """Return a text."""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-size="{size}">{escape(words)}</text>'


def draw_resistor(x: float, y: float, length: float = 40, upright: bool = True, ink: str = INK) -> str:
    """Return a resistor that starts at a point and goes down, or to the right."""
    return draw_box(x - 7, y, 14, length, ink) if upright else draw_box(x, y - 7, length, 14, ink)


def draw_fuse(x: float, y: float, length: float = 44) -> str:
    """Return a fuse that starts at a point and goes to the right."""
    return draw_box(x, y - 7, length, 14, POWER) + draw_line((x, y), (x + length, y), ink=POWER)


def draw_ground(x: float, y: float) -> str:
    """Return ground below a point."""
    widths = ((12, 6), (8, 11), (3, 16))
    return draw_line((x, y), (x, y + 6)) + "".join(draw_line((x - w, y + h), (x + w, y + h)) for w, h in widths)


def draw_capacitor(x: float, y: float) -> str:
    """Return a capacitor from a point down to ground."""
    plates = "".join(draw_line((x - 9, y + h), (x + 9, y + h)) for h in (12, 17))
    return draw_line((x, y), (x, y + 12)) + plates + draw_line((x, y + 17), (x, y + 24)) + draw_ground(x, y + 24)


def draw_battery(x: float, y: float) -> str:
    """Return a direct-current supply with its plus at a point and its minus 40 px below."""
    plates = draw_line((x - 16, y + 14), (x + 16, y + 14)) + draw_line((x - 8, y + 22), (x + 8, y + 22))
    ends = draw_line((x, y), (x, y + 14), ink=POWER) + draw_line((x, y + 22), (x, y + 40))
    return plates + ends + write_words(x + 20, y + 12, "+", size=16) + write_words(x + 20, y + 34, "−", size=16)


def draw_mosfet(x: float, y: float) -> str:
    """Return an n-channel MOSFET around a point; gate, drain and source are 30 px to the left, above and below."""
    channel = "".join(draw_line((x - 12, y + a), (x - 12, y + b)) for a, b in ((-20, -9), (-5, 5), (9, 20)))
    gate = draw_line((x - 30, y), (x - 18, y), ink=SIGNAL) + draw_line((x - 18, y - 16), (x - 18, y + 16))
    drain = draw_line((x - 12, y - 14), (x, y - 14), (x, y - 30), ink=POWER)
    source = draw_line((x - 12, y + 14), (x, y + 14), (x, y + 30), ink=POWER)
    body = draw_line((x - 12, y), (x, y), (x, y + 14))
    arrow = f'<polygon points="{x - 12:g},{y:g} {x - 5:g},{y - 4:g} {x - 5:g},{y + 4:g}" fill="{INK}"/>'
    return channel + gate + drain + source + body + arrow


def draw_amplifier(x: float, y: float) -> str:
    """Return an amplifier with its output at a point; plus and minus are 60 px to the right, 16 px above and below."""
    triangle = f'<polygon points="{x:g},{y:g} {x + 60:g},{y - 32:g} {x + 60:g},{y + 32:g}" fill="white" stroke="{INK}" '
    signs = write_words(x + 47, y - 11, "+", size=15) + write_words(x + 47, y + 21, "−", size=15)
    return triangle + 'stroke-width="1.4"/>' + signs
