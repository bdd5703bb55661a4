"""Drawing of a mechanism: named shapes with points in space, at one time.

`draw_shapes(reading)` is called once per picture and uses the functions of `xp`, which accept floats and the recorded
numbers of the browser. All pictures of a run have the same shapes with the same numbers of points; only places and
angles change. Joints and wire paths follow the kinematics; undefined sizes, such as the thickness of a bar, are
proportional.

Frame: right-handed, z up, x to the right, y away from the eye; metres.

A taut wire is drawn at its length. As assembled it is `reading.lengths[port]` long; if its path over the mechanism is
shorter, the rest continues behind the fixed end; if longer, a tether fills the gap (`lead_wire`).
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import NamedTuple

from martensite.kernels.recordable_numbers import xp

Point = tuple[float, float, float]

KINDS: dict[str, str] = {
    "ground": "bar that stands still, along its points",
    "wall": "slab that stands still, along its points",
    "link": "rigid bar along its points",
    "phalanx": "rounded link of a finger, from its first point to its second",
    "fingertip": "the last of these",
    "beam": "flat strip that bends, along its points",
    "bracket": "post with an eye for a wire at its second point",
    "joint": "pin of a hinge, from its first point to its second",
    "wire": "element at a port, along its points; taut, it is as long as this line",
    "spring": "passive spring, along its points",
    "tether": "thread or rod that does not stretch, along its points",
    "force": "arrow from its first point to its second, `NEWTON` long for each newton",
    "weight": "block that hangs at its point",
    "slider": "guided block around its point",
    "pulley": "disc on the axis from its first point to its second",
    "cylinder": "what is gripped, on the axis from its first point to its second",
    "motor": "housing of a motor, on the axis from its first point to its second",
    "plate": "thin plate with its points as corners",
    "palm": "that of a hand",
    "rotor": "disc with an arm, on the axis from its first point to its second; the arm points at "
    "the third, turned about that axis",
    "object": "ball at its point",
}
"""Kind -> description of the shape."""

ARC = 8
"""Segments of a quarter circle."""
THREAD = 0.1
"""Length of the thread of a load without an element [m]."""
DENSITY = 7850.0
"""Density of the steel of a drawn weight [kg/m³]."""
NEWTON = 5e-3
"""Drawn length of a contact force [m/N]."""


class DrawingShape(NamedTuple):
    """Part of the picture of a mechanism at one time."""

    name: str
    kind: str
    """Key of `KINDS`."""
    points: tuple[Point, ...]
    """[m]"""
    size: float
    """Radius of a bar, pin, disc, spring or ball, half the edge of a block, half the thickness of a plate [m]; 0 for a
    wire.
    """
    port: str = ""
    """Port of the element of a wire."""
    turn: float = 0.0
    """Angle of a disc or rotor about its axis, right-handed [rad]; may exceed a full turn."""
    mass: float = 0.0
    """Mass of a weight [kg]; 0 if unknown."""


class DrawingState(NamedTuple):
    """Input of a drawing."""

    outputs: Mapping[str, float]
    """Outputs of the mechanism at one time, in SI."""
    lengths: Mapping[str, float]
    """Length of the element at each port as assembled [m]."""


def measure_length(points: Sequence[Point]) -> float:
    """Return the length of the line through points [m]."""
    return sum(map(measure_distance, points, points[1:]))


def measure_distance(first: Sequence[float], second: Sequence[float]) -> float:
    """Return the distance of two points [m]."""
    return xp.sqrt(sum((a - b) * (a - b) for a, b in zip(first, second, strict=True)))


def locate_along(first: Point, second: Point, way: float) -> Point:
    """Return the point at a distance [m] from the first towards the second."""
    share = way / (measure_distance(first, second) or 1.0)
    x, y, z = ((1.0 - share) * a + share * b for a, b in zip(first, second, strict=True))
    return x, y, z


def move_point(point: Point, direction: Point, way: float) -> Point:
    """Return the point moved along a direction by a distance [m]."""
    return (point[0] + way * direction[0], point[1] + way * direction[1], point[2] + way * direction[2])


def lead_wire(port: str, path: Sequence[Point], rest: float, away: Point) -> list[DrawingShape]:
    """Return a wire along a path [m] that begins at its fixed end, and a tether if the wire is too short.

    `rest` is the length of the element less that of the path, both as assembled [m]; excess wire continues in the
    direction `away` behind the fixed end.
    """
    if rest >= 0.0:
        points = (move_point(path[0], away, rest), *path)
        return [DrawingShape(port, "wire", points, 0.0, port)]
    behind, k = -rest, 0
    while k < len(path) - 2 and behind >= measure_distance(path[k], path[k + 1]):
        behind -= measure_distance(path[k], path[k + 1])
        k += 1
    cut = locate_along(path[k], path[k + 1], xp.minimum(behind, 0.9 * measure_distance(path[k], path[k + 1])))
    tether = DrawingShape(f"{port} tether", "tether", (*path[: k + 1], cut), 0.0)
    return [tether, DrawingShape(port, "wire", (cut, *path[k + 1 :]), 0.0, port)]


def trace_arc(radius: float, first: float, last: float, segments: int) -> list[tuple[float, float]]:
    """Return the points of a circle about 0 between two angles [rad]: a polygon as long as the arc [m]."""
    step = (last - first) / segments
    half = xp.maximum(0.5 * abs(step), 1e-6)
    outside = radius * half / xp.sin(half)
    angles = [first + k * step for k in range(segments + 1)]
    return [(outside * xp.cos(angle), outside * xp.sin(angle)) for angle in angles]


def draw_bar(name: str, size: float, *points: Point, kind: str = "link") -> DrawingShape:
    """Return a bar through points."""
    return DrawingShape(name, kind, points, size)


def draw_pin(name: str, at: Point, half: float, size: float) -> DrawingShape:
    """Return a pin along y with a half length [m]."""
    return DrawingShape(name, "joint", ((at[0], at[1] - half, at[2]), (at[0], at[1] + half, at[2])), size)


def draw_cylinder(axis: Point, half: float, radius: float) -> DrawingShape:
    """Return a cylinder along y with a half length [m], about a point of its axis."""
    ends = (axis[0], axis[1] - half, axis[2]), (axis[0], axis[1] + half, axis[2])
    return DrawingShape("cylinder", "cylinder", ends, radius)


def draw_force(name: str, touching: Point, axis: Point, force: float) -> DrawingShape:
    """Return the force [N] of a cylinder on a touching part, as an arrow from its axis."""
    return DrawingShape(name, "force", (locate_along(touching, axis, NEWTON * force), touching), 0.0)


def draw_weight(name: str, at: Point, mass: float, least: float, most: float) -> DrawingShape:
    """Return a steel block of a mass [kg], with half an edge between two limits [m]."""
    half = 0.5 * xp.power(mass / DENSITY, 1.0 / 3.0)
    return DrawingShape(name, "weight", (at,), xp.clip(half, least, most), mass=mass)


def draw_lifted(by: float) -> list[DrawingShape]:
    """Return a ball on a thread of arbitrary length, lifted by a distance [m]."""
    end, wide = (0.0, 0.0, by - THREAD), 0.2 * THREAD
    return [
        draw_bar("ceiling", 0.02 * THREAD, (-wide, 0.0, 0.0), (wide, 0.0, 0.0), kind="wall"),
        draw_bar("thread", 0.0, (0.0, 0.0, 0.0), end, kind="tether"),
        DrawingShape("load", "object", (end,), 0.05 * THREAD),
    ]


def draw_hanging(
    ports: Sequence[str], shortened: Sequence[float], turned: Sequence[float], reading: DrawingState
) -> list[DrawingShape]:
    """Return elements side by side, `shortened` [m], and discs `turned` [rad], for a mechanism without a drawing."""
    longest = reduce(xp.maximum, reading.lengths.values()) if reading.lengths else 0.1
    apart = 0.3 * longest
    wide = 0.5 * apart * max(len(ports), len(turned), 1)
    shapes = [draw_bar("ceiling", 0.02 * longest, (-wide, 0.0, 0.0), (wide, 0.0, 0.0), kind="wall")]
    for k, (port, by) in enumerate(zip(ports, shortened, strict=True)):
        x = apart * (k - 0.5 * (len(ports) - 1))
        end = (x, 0.0, by - reading.lengths[port])
        shapes.append(DrawingShape(port, "wire", ((x, 0.0, 0.0), end), 0.0, port))
        shapes.append(DrawingShape(f"{port} end", "slider", (end,), 0.03 * longest))
    for k, angle in enumerate(turned):
        x, z = apart * (k - 0.5 * (len(turned) - 1)), -1.4 * longest
        axis = ((x, 0.02 * longest, z), (x, -0.02 * longest, z))
        shapes.append(DrawingShape(f"angle {k + 1}", "pulley", axis, 0.12 * longest, turn=angle))
    return shapes
