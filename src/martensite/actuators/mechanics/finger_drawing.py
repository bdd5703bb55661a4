"""How the finger is drawn: hinge in the origin, phalanges along -x and +x, the wire below them.

Holes of the brackets at (∓g, -r), the spring at a and its fixed end at (a, H), as in
`martensite.actuators.mechanisms.finger`; θ turns the far phalanx about +y. The wire comes from the
left,
passes the hinge n times, side by side, and the rest of it runs on along the phalanges; it is drawn
to scale for whole n. A follower spring pulls a thread that is wound on a drum of radius a. Once
the brackets have met, the wire is drawn through the point where they did.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from martensite.actuators.mechanisms.drawing import (
    ARC,
    DrawingShape,
    DrawingState,
    Point,
    draw_bar,
    draw_pin,
    lead_wire,
    measure_length,
    trace_arc,
)

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.finger import Finger


def drawn_finger(finger: Finger, reading: DrawingState) -> list[DrawingShape]:
    """All shapes of the finger."""
    angle, (port,) = reading.outputs["angle"], finger.ports()
    r, g = finger.offset, finger.bracket
    thick, tip, hinge = 0.45 * r, 4.0 * g, (0.0, 0.0, 0.0)
    # what every pass has on either side of the hinge
    rest = (reading.lengths[port] - measure_length(_trace_path(finger, 0.0, 0.0, 0.0))) / _count_passes(finger)
    beyond = min(2.0 * g, 0.4 * max(rest, 0.0))
    behind = max(rest - beyond, 0.0)
    path = _trace_path(finger, angle, behind, beyond)
    return [
        draw_bar("near phalanx", thick, (-1.1 * behind - 2.0 * g, 0.0, 0.0), hinge, kind="ground"),
        draw_bar("far phalanx", thick, hinge, turn_point(angle, tip, 0.0)),
        draw_bar("near bracket", 0.5 * thick, (-g, 0.0, 0.0), (-g, 0.0, -r), kind="ground"),
        draw_bar("far bracket", 0.5 * thick, turn_point(angle, g, 0.0), turn_point(angle, g, -r)),
        draw_pin("hinge", hinge, 0.8 * r, 0.5 * r),
        *lead_wire(port, path, min(rest, 0.0) * _count_passes(finger), (-1.0, 0.0, 0.0)),
        *_draw_spring(finger, angle),
    ]


def turn_point(angle: float, x: float, z: float, y: float = 0.0) -> Point:
    """A point of the far phalanx, turned about +y."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x + s * z, y, c * z - s * x


def _count_passes(finger: Finger) -> int:
    return max(round(finger.passes), 1)


def _trace_path(finger: Finger, angle: float, behind: float, beyond: float) -> list[Point]:
    """All passes over the hinge, side by side, with so much [m] on either side of it."""
    r, g, passes = finger.offset, finger.bracket, _count_passes(finger)
    apart, met = min(0.6, 1.6 / passes) * r, min(angle, 2.0 * math.atan2(g, r))
    found: list[Point] = []
    for k in range(passes):
        y = apart * (k - 0.5 * (passes - 1))
        way = [(-g - behind, y, -r), (-g, y, -r), turn_point(met, g, -r, y), turn_point(met, g + beyond, -r, y)]
        found += way if k % 2 == 0 else way[::-1]
    return found


def _draw_spring(finger: Finger, angle: float) -> list[DrawingShape]:
    """The return spring, of the kind that it is."""
    a, wide = finger.arm, 0.25 * finger.arm
    if finger.spring == "fixed":
        fixed = (a, 0.0, finger.height)
        post = ((a - wide, 0.0, finger.height), (a + wide, 0.0, finger.height))
        return [
            draw_bar("holder of the spring", 0.3 * wide, *post, kind="ground"),
            DrawingShape("spring", "spring", (fixed, turn_point(angle, a, 0.0)), 0.4 * wide),
        ]
    stretched = finger.extension + a * angle
    start, slim = -a * (3.0 + finger.highest), 0.4 * wide
    end = start + max(2.0 * a + stretched, 0.5 * a)
    top, bottom = 0.5 * math.pi, 0.5 * math.pi - 0.4
    rim = [(x, 0.0, z) for x, z in trace_arc(a, top, bottom - max(angle, -0.4), ARC)]
    axis = ((0.0, -wide, 0.0), (0.0, wide, 0.0))
    return [
        draw_bar("holder of the spring", slim, (start, 0.0, 0.0), (start, 0.0, a), kind="ground"),
        DrawingShape("spring", "spring", ((start, 0.0, a), (end, 0.0, a)), slim),
        DrawingShape("thread", "tether", ((end, 0.0, a), *rim), 0.0),
        DrawingShape("drum", "pulley", axis, a, turn=angle),
    ]
