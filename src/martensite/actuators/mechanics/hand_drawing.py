"""Drawing of the hand: fingers that hang from a palm, the thumb opposite to the two others.

Each finger has its own plane: `along` the straight finger, and `inwards`, the bending direction. Holes of flexors at
(∓g, r) from a hinge and knuckles of radius ρ, as in `martensite.actuators.mechanisms.hand`. Tendons that do not bend
the proximal joint run through its axis. The mechanism does not define the places of fingers on the palm or tendons in
the forearm. Once brackets have met, a flexor is drawn through their meeting point.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import reduce
from typing import TYPE_CHECKING, NamedTuple

from martensite.actuators.mechanisms.drawing import (
    ARC,
    DrawingShape,
    DrawingState,
    Point,
    draw_bar,
    draw_cylinder,
    draw_force,
    lead_wire,
    measure_distance,
    measure_length,
    trace_arc,
)
from martensite.kernels.recordable_numbers import xp

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.hand import Hand

Flat = tuple[float, float]
"""Coordinates along the finger and inwards [m]."""
LEAST_WRAP, MOST_WRAP = 0.15, 0.6
"""Limits of the wrap angle of a proximal extensor on its knuckle as assembled [rad]."""


class FingerPlace(NamedTuple):
    """Place of a finger on the palm."""

    x: float
    y: float
    inwards: float
    """Bending direction along x, 1 or -1."""

    def at(self, point: Flat, aside: float = 0.0) -> Point:
        """Return a point of its plane in space, shifted sideways [m]."""
        return self.x + self.inwards * point[1], self.y + aside, -point[0]


class FingerLengths(NamedTuple):
    """Lengths of a finger [m]."""

    offset: float
    bracket: float
    knuckle: float
    proximal: float
    distal: float
    wrapped: float
    """Wrap angle of its proximal extensor on the knuckle as assembled [rad]."""


def drawn_hand(hand: Hand, reading: DrawingState) -> list[DrawingShape]:
    """Return palm, forearm, tendon plate, and all fingers."""
    apart, wide = 3.0 * xp.maximum(hand.offset, hand.knuckle), 0.7 * (hand.proximal_length + hand.distal_length)
    wide = 0.5 * hand.span if hand.contact == "cylinder" else wide
    places = (FingerPlace(wide, 0.0, -1.0), FingerPlace(-wide, apart, 1.0), FingerPlace(-wide, -apart, 1.0))
    edge, above, top = 1.5 * hand.knuckle, *_locate_plates(hand, reading)
    shapes = [
        DrawingShape("palm", "palm", _draw_plate(wide + edge, apart + edge, above), 0.8 * hand.offset),
        draw_bar("forearm", edge, (0.0, 0.0, above), (0.0, 0.0, top), kind="ground"),
        DrawingShape("plate of the tendons", "plate", _draw_plate(wide + edge, apart + edge, top), 0.3 * hand.offset),
    ]
    if hand.contact == "cylinder":
        axis = (hand.cylinder_aside, 0.0, -hand.cylinder_depth)
        shapes.append(draw_cylinder(axis, apart + edge, hand.cylinder_radius))
    words = zip(hand.ports()[::4], hand.sizes(), places, strict=True)
    for first, size, place in words:
        shapes += _draw_finger(hand, first.split("_")[0], size, place, reading)
    return shapes


def _draw_plate(half: float, wide: float, above: float) -> tuple[Point, ...]:
    """Return the corners of a level plate, narrower at the thumb."""
    return (-half, -wide, above), (half, -0.5 * wide, above), (half, 0.5 * wide, above), (-half, wide, above)


def _locate_plates(hand: Hand, reading: DrawingState) -> tuple[float, float]:
    """Return the heights of palm and tendon plate above the hinges [m]."""
    above = reduce(xp.maximum, hand.sizes()) * (xp.maximum(hand.bracket, 0.6 * hand.distal_length) + 2.0 * hand.offset)
    return above, reduce(xp.maximum, reading.lengths.values(), 2.0 * above) - 0.25 * hand.proximal_length


def _draw_finger(
    hand: Hand, name: str, size: float, place: FingerPlace, reading: DrawingState
) -> Iterator[DrawingShape]:
    wrapped = xp.clip(-hand.lowest, LEAST_WRAP, MOST_WRAP)
    lengths = (hand.offset, hand.bracket, hand.knuckle, hand.proximal_length, hand.distal_length)
    sizes = FingerLengths._make((*(size * length for length in lengths), wrapped))
    first, second = (reading.outputs[f"{name}_{joint}"] for joint in ("proximal", "distal"))
    half = 1.1 * sizes.offset
    thick = 0.5 * size * hand.thickness if hand.contact == "cylinder" else 0.95 * sizes.offset
    hinge, tip = _locate_proximal(sizes, first, sizes.proximal, 0.0), (sizes.distal, 0.0)
    start = place.at((0.0, 0.0))
    end, (lift, top) = place.at(_locate_distal(sizes, first, second, *tip)), _locate_plates(hand, reading)
    yield draw_bar(f"{name} base", thick, place.at((-lift, 0.0)), start, kind="phalanx")
    yield draw_bar(f"{name} proximal", thick, start, place.at(hinge), kind="phalanx")
    yield draw_bar(f"{name} distal", 0.85 * thick, place.at(hinge), end, kind="fingertip")
    for joint, at in (("proximal", (0.0, 0.0)), ("distal", hinge)):
        ends = (place.at(at, -half), place.at(at, half))
        yield DrawingShape(f"{name} {joint} knuckle", "joint", ends, 0.9 * sizes.knuckle)
    if hand.contact == "cylinder":
        axis = place.at((hand.cylinder_depth, place.inwards * (hand.cylinder_aside - place.x)))
        along = [reading.outputs[f"{name}_{joint}_contact_place"] for joint in ("proximal", "distal")]
        ways = _locate_proximal(sizes, first, along[0], thick), _locate_distal(sizes, first, second, along[1], thick)
        for joint, way in zip(("proximal", "distal"), ways, strict=True):
            force = reading.outputs[f"{name}_{joint}_contact_force"]
            yield draw_force(f"{name} {joint} force", place.at(way), axis, force)
    yield from _draw_brackets(name, sizes, place, (first, second))
    passing = hand.tendons == "passing"
    ways, straight = (_trace_tendons(sizes, *angles, passing) for angles in ((first, second), (0.0, 0.0)))
    for k, (way, home) in enumerate(zip(ways, straight, strict=True)):
        port = "_".join((name, ("proximal", "distal")[k // 2], ("flexor", "extensor")[k % 2]))
        aside = (k - 1.5) * 0.4 * sizes.offset
        # an extensor reaches its knuckle along the tangent
        turn = _find_height(way[0], lift, wrapped if k == 1 else 0.0)
        path = [place.at(point, aside) for point in (turn, *way)]
        whole = measure_distance(turn, way[0]) + measure_length([(a, b, 0.0) for a, b in home])
        wires = lead_wire(port, path, reading.lengths[port] - whole, (0.0, 0.0, 1.0))
        (x, y, z) = wires[0].points[0]
        yield from (*wires, draw_bar(f"{port} tie", 0.0, (x, y, xp.maximum(z, top)), (x, y, z), kind="tether"))


def _find_height(point: Flat, lift: float, leaning: float) -> Flat:
    """Return the point at a height above the hinges on an inclined line through a point."""
    return -lift, point[1] + xp.tan(leaning) * (lift + point[0])


def _draw_brackets(
    name: str, sizes: FingerLengths, place: FingerPlace, angles: tuple[float, float]
) -> Iterator[DrawingShape]:
    r, g = sizes.offset, sizes.bracket
    posts: list[list[Flat]] = [[(-g, 0.0), (-g, r)]]
    posts += [[_locate_proximal(sizes, angles[0], way, b) for b in (0.0, r)] for way in (g, sizes.proximal - g)]
    posts.append([_locate_distal(sizes, *angles, g, inwards) for inwards in (0.0, r)])
    for k, post in enumerate(posts, start=1):
        yield draw_bar(f"{name} bracket {k}", 0.15 * r, *map(place.at, post), kind="bracket")


def _trace_tendons(sizes: FingerLengths, first: float, second: float, passing: bool) -> list[list[Flat]]:
    """Return the paths of flexor and extensor of the proximal joint, then of the distal joint."""
    r, g, knuckle, reach, _, wrapped = sizes
    met = 2.0 * xp.atan2(g, r)
    one, two = xp.minimum(first, met), xp.minimum(second, met)
    ends = 0.3 * reach, 0.3 * sizes.distal
    axis = [(-g, 0.0), (0.0, 0.0)]
    over = [(-g, r), _locate_proximal(sizes, one, g, r)]
    at_joint = [_locate_proximal(sizes, first, reach - g, r)]
    at_joint += [_locate_distal(sizes, first, two, way, r) for way in (g, g + ends[1])]
    touching = xp.asin(xp.minimum(knuckle / reach, 0.9))
    return [
        [*over, _locate_proximal(sizes, one, g + ends[0], r)],
        [*_wind_extensor(knuckle, first, wrapped), _locate_proximal(sizes, first, ends[0], -knuckle)],
        [*(over if passing else axis), *at_joint],
        [
            *axis,
            *(_locate_proximal(sizes, first, reach + a, b) for a, b in _wind_extensor(knuckle, second, touching)),
            _locate_distal(sizes, first, second, ends[1], -knuckle),
        ],
    ]


def _wind_extensor(radius: float, angle: float, wrapped: float) -> list[Flat]:
    """Return the points of an extensor on its knuckle."""
    quarter = 0.5 * math.pi
    return trace_arc(radius, -wrapped - quarter, xp.maximum(angle, -wrapped) - quarter, ARC)


def _locate_proximal(sizes: FingerLengths, angle: float, along: float, inwards: float) -> Flat:
    c, s = xp.cos(angle), xp.sin(angle)
    return c * along - s * inwards, s * along + c * inwards


def _locate_distal(sizes: FingerLengths, first: float, second: float, along: float, inwards: float) -> Flat:
    c, s = xp.cos(second), xp.sin(second)
    return _locate_proximal(sizes, first, sizes.proximal + c * along - s * inwards, s * along + c * inwards)
