"""How the hand is drawn: fingers that hang from a palm, the thumb opposite to the two others.

Every finger is drawn in a plane of its own: `along` it as it hangs straight, and `inwards`, where it bends to. Holes of
flexors at (∓g, r) from a hinge and knuckles of radius ρ, as in `martensite.actuators.mechanisms.hand`. What does not
bend the proximal joint runs through its axis. Where the fingers stand on the palm, and how tendons run on into the
forearm, the mechanism leaves open. Once brackets have met, a flexor is drawn through the point where they did.
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
    measure_length,
    trace_arc,
)
from martensite.kernels.recorded import xp

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.hand import Hand

Flat = tuple[float, float]
"""Along the finger and inwards [m]."""
LEAST_WRAP, MOST_WRAP = 0.15, 0.6
"""Angle by which a proximal extensor lies on its knuckle as assembled [rad]."""


class FingerPlace(NamedTuple):
    """Where a finger hangs."""

    x: float
    y: float
    inwards: float
    """1 or -1: which way along x it bends."""

    def at(self, point: Flat, aside: float = 0.0) -> Point:
        """A point of its plane in space, so far beside it [m]."""
        return self.x + self.inwards * point[1], self.y + aside, -point[0]


class FingerLengths(NamedTuple):
    """Lengths of a finger [m]."""

    offset: float
    bracket: float
    knuckle: float
    proximal: float
    distal: float
    wrapped: float
    """Angle by which its proximal extensor lies on the knuckle as assembled [rad]."""


def drawn_hand(hand: Hand, reading: DrawingState) -> list[DrawingShape]:
    """Palm, holder of the thumb, forearm, and all fingers."""
    reach = hand.proximal_length + hand.distal_length
    apart, wide = 3.0 * xp.maximum(hand.offset, hand.knuckle), 0.7 * reach
    wide = 0.5 * hand.span if hand.contact == "cylinder" else wide
    places = (FingerPlace(wide, 0.0, -1.0), FingerPlace(-wide, apart, 1.0), FingerPlace(-wide, -apart, 1.0))
    thick, edge = 0.25 * hand.offset, 1.5 * hand.knuckle
    above = _compute_lift(hand, 4)
    far = wide - reduce(xp.maximum, reading.lengths.values(), 2.5 * wide)
    arm = ((wide, 0.0, above), (far, 0.0, above))
    found = [
        DrawingShape("palm", "plate", _draw_upright(-wide, apart + edge, above), thick),
        DrawingShape("holder of the thumb", "plate", _draw_upright(wide, edge, above), thick),
        draw_bar("forearm", thick, *arm, kind="ground"),
    ]
    if hand.contact == "cylinder":
        axis = (hand.cylinder_aside, 0.0, -hand.cylinder_depth)
        found.append(draw_cylinder(axis, apart + edge, hand.cylinder_radius))
    words = zip(hand.ports()[::4], hand.sizes(), places, strict=True)
    for first, size, place in words:
        found += _draw_finger(hand, first.split("_")[0], size, place, reading)
    return found


def _draw_upright(x: float, half: float, above: float) -> tuple[Point, ...]:
    """Corners of a plate that stands on the hinges, across x."""
    return (x, -half, 0.0), (x, half, 0.0), (x, half, above), (x, -half, above)


def _compute_lift(hand: Hand, tendon: int) -> float:
    """How far above the hinges a tendon turns into the forearm: clear of bent fingers [m]."""
    return reduce(xp.maximum, hand.sizes()) * (hand.distal_length + (0.5 + 0.5 * tendon) * hand.offset)


def _draw_finger(
    hand: Hand, name: str, size: float, place: FingerPlace, reading: DrawingState
) -> Iterator[DrawingShape]:
    wrapped = xp.clip(-hand.lowest, LEAST_WRAP, MOST_WRAP)
    sizes = FingerLengths(
        size * hand.offset,
        size * hand.bracket,
        size * hand.knuckle,
        size * hand.proximal_length,
        size * hand.distal_length,
        wrapped,
    )
    first, second = (reading.outputs[f"{name}_{joint}"] for joint in ("proximal", "distal"))
    thick, half = 0.4 * sizes.offset, 0.7 * sizes.offset
    thick = 0.5 * size * hand.thickness if hand.contact == "cylinder" else thick
    hinge, tip = _locate_proximal(sizes, first, sizes.proximal, 0.0), (sizes.distal, 0.0)
    start = place.at((0.0, 0.0))
    yield draw_bar(f"{name} proximal", thick, start, place.at(hinge))
    yield draw_bar(f"{name} distal", thick, place.at(hinge), place.at(_locate_distal(sizes, first, second, *tip)))
    for joint, at in (("proximal", (0.0, 0.0)), ("distal", hinge)):
        ends = (place.at(at, -half), place.at(at, half))
        yield DrawingShape(f"{name} {joint} knuckle", "joint", ends, sizes.knuckle)
    if hand.contact == "cylinder":
        axis = place.at((hand.cylinder_depth, place.inwards * (hand.cylinder_aside - place.x)))
        along = [reading.outputs[f"{name}_{joint}_contact_place"] for joint in ("proximal", "distal")]
        ways = _locate_proximal(sizes, first, along[0], thick), _locate_distal(sizes, first, second, along[1], thick)
        for joint, way in zip(("proximal", "distal"), ways, strict=True):
            force = reading.outputs[f"{name}_{joint}_contact_force"]
            yield draw_force(f"{name} {joint} force", place.at(way), axis, force)
    yield from _draw_brackets(name, sizes, place, first, second)
    passing = hand.tendons == "passing"
    ways, straight = (_trace_tendons(sizes, *angles, passing) for angles in ((first, second), (0.0, 0.0)))
    for k, (way, home) in enumerate(zip(ways, straight, strict=True)):
        port = "_".join((name, ("proximal", "distal")[k // 2], ("flexor", "extensor")[k % 2]))
        aside, lift = (k - 1.5) * 0.4 * sizes.offset, _compute_lift(hand, k)
        # an extensor comes on to its knuckle along the tangent
        turn = _find_height(way[0], lift, wrapped if k == 1 else 0.0)
        path = [place.at(point, aside) for point in (turn, *way)]
        whole = measure_length([(a, b, 0.0) for a, b in (turn, way[0])])
        whole += measure_length([(a, b, 0.0) for a, b in home])
        yield from lead_wire(port, path, reading.lengths[port] - whole, (-1.0, 0.0, 0.0))


def _find_height(point: Flat, lift: float, leaning: float) -> Flat:
    """Where a line through a point, leaning inwards by an angle, is so far above the hinges."""
    return -lift, point[1] + xp.tan(leaning) * (lift + point[0])


def _draw_brackets(
    name: str, sizes: FingerLengths, place: FingerPlace, first: float, second: float
) -> Iterator[DrawingShape]:
    r, g, far = sizes.offset, sizes.bracket, sizes.proximal - sizes.bracket
    posts = (
        [(-g, 0.0), (-g, r)],
        [_locate_proximal(sizes, first, g, 0.0), _locate_proximal(sizes, first, g, r)],
        [_locate_proximal(sizes, first, far, 0.0), _locate_proximal(sizes, first, far, r)],
        [_locate_distal(sizes, first, second, g, 0.0), _locate_distal(sizes, first, second, g, r)],
    )
    for k, post in enumerate(posts, start=1):
        yield draw_bar(f"{name} bracket {k}", 0.12 * r, *map(place.at, post))


def _trace_tendons(sizes: FingerLengths, first: float, second: float, passing: bool) -> list[list[Flat]]:
    """Ways of flexor and extensor of the proximal joint, then of the distal one."""
    r, g, knuckle, reach, _, wrapped = sizes
    met = 2.0 * xp.atan2(g, r)
    one, two = xp.minimum(first, met), xp.minimum(second, met)
    ends = 0.3 * reach, 0.3 * sizes.distal
    axis = [(-g, 0.0), (0.0, 0.0)]
    over = [(-g, r), _locate_proximal(sizes, one, g, r)]
    at_joint = [_locate_proximal(sizes, first, reach - g, r), *_trace_distal(sizes, first, two, (g, g + ends[1]), r)]
    touching = xp.asin(xp.minimum(knuckle / reach, 0.9))
    return [
        [*over, _locate_proximal(sizes, one, g + ends[0], r)],
        [*_wind_extensor(knuckle, first, wrapped), _locate_proximal(sizes, first, ends[0], -knuckle)],
        [*(over if passing else axis), *at_joint],
        [
            *axis,
            *(_locate_proximal(sizes, first, reach + a, b) for a, b in _wind_extensor(knuckle, second, touching)),
            *_trace_distal(sizes, first, second, (ends[1],), -knuckle),
        ],
    ]


def _wind_extensor(radius: float, angle: float, wrapped: float) -> list[Flat]:
    """An extensor on its knuckle, from where it comes on to where the bent phalanx takes it."""
    quarter = 0.5 * math.pi
    return trace_arc(radius, -wrapped - quarter, xp.maximum(angle, -wrapped) - quarter, ARC)


def _trace_distal(
    sizes: FingerLengths, first: float, second: float, ways: tuple[float, ...], inwards: float
) -> list[Flat]:
    return [_locate_distal(sizes, first, second, way, inwards) for way in ways]


def _locate_proximal(sizes: FingerLengths, angle: float, along: float, inwards: float) -> Flat:
    c, s = xp.cos(angle), xp.sin(angle)
    return c * along - s * inwards, s * along + c * inwards


def _locate_distal(sizes: FingerLengths, first: float, second: float, along: float, inwards: float) -> Flat:
    c, s = xp.cos(second), xp.sin(second)
    return _locate_proximal(sizes, first, sizes.proximal + c * along - s * inwards, s * along + c * inwards)
