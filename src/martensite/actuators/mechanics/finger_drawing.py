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
    Point,
    Reading,
    Shape,
    arc,
    bar,
    led,
    length,
    pin,
)

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.finger import Finger


def drawn_finger(finger: Finger, reading: Reading) -> list[Shape]:
    """All shapes of the finger."""
    angle, (port,) = reading.outputs["angle"], finger.ports()
    r, g = finger.offset, finger.bracket
    thick, tip, hinge = 0.45 * r, 4.0 * g, (0.0, 0.0, 0.0)
    # what every pass has on either side of the hinge
    rest = (reading.lengths[port] - length(_path(finger, 0.0, 0.0, 0.0))) / _passes(finger)
    beyond = min(2.0 * g, 0.4 * max(rest, 0.0))
    behind = max(rest - beyond, 0.0)
    path = _path(finger, angle, behind, beyond)
    return [
        bar("near phalanx", thick, (-1.1 * behind - 2.0 * g, 0.0, 0.0), hinge, kind="ground"),
        bar("far phalanx", thick, hinge, turned(angle, tip, 0.0)),
        bar("near bracket", 0.5 * thick, (-g, 0.0, 0.0), (-g, 0.0, -r), kind="ground"),
        bar("far bracket", 0.5 * thick, turned(angle, g, 0.0), turned(angle, g, -r)),
        pin("hinge", hinge, 0.8 * r, 0.5 * r),
        *led(port, path, min(rest, 0.0) * _passes(finger), (-1.0, 0.0, 0.0)),
        *_spring(finger, angle),
    ]


def turned(angle: float, x: float, z: float, y: float = 0.0) -> Point:
    """A point of the far phalanx, turned about +y."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x + s * z, y, c * z - s * x


def _passes(finger: Finger) -> int:
    return max(round(finger.passes), 1)


def _path(finger: Finger, angle: float, behind: float, beyond: float) -> list[Point]:
    """All passes over the hinge, side by side, with so much [m] on either side of it."""
    r, g, passes = finger.offset, finger.bracket, _passes(finger)
    apart, met = min(0.6, 1.6 / passes) * r, min(angle, 2.0 * math.atan2(g, r))
    found: list[Point] = []
    for k in range(passes):
        y = apart * (k - 0.5 * (passes - 1))
        way = [
            (-g - behind, y, -r), (-g, y, -r),
            turned(met, g, -r, y), turned(met, g + beyond, -r, y),
        ]  # fmt: skip
        found += way if k % 2 == 0 else way[::-1]
    return found


def _spring(finger: Finger, angle: float) -> list[Shape]:
    """The return spring, of the kind that it is."""
    a, wide = finger.arm, 0.25 * finger.arm
    if finger.spring == "fixed":
        fixed = (a, 0.0, finger.height)
        post = ((a - wide, 0.0, finger.height), (a + wide, 0.0, finger.height))
        return [
            bar("holder of the spring", 0.3 * wide, *post, kind="ground"),
            Shape("spring", "spring", (fixed, turned(angle, a, 0.0)), 0.4 * wide),
        ]
    stretched = finger.extension + a * angle
    start, slim = -a * (3.0 + finger.highest), 0.4 * wide
    end = start + max(2.0 * a + stretched, 0.5 * a)
    top, bottom = 0.5 * math.pi, 0.5 * math.pi - 0.4
    rim = [(x, 0.0, z) for x, z in arc(a, top, bottom - max(angle, -0.4), ARC)]
    axis = ((0.0, -wide, 0.0), (0.0, wide, 0.0))
    return [
        bar("holder of the spring", slim, (start, 0.0, 0.0), (start, 0.0, a), kind="ground"),
        Shape("spring", "spring", ((start, 0.0, a), (end, 0.0, a)), slim),
        Shape("thread", "tether", ((end, 0.0, a), *rim), 0.0),
        Shape("drum", "pulley", axis, a, turn=angle),
    ]
