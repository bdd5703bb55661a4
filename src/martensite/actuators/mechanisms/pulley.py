"""Antagonistic wires on a pulley: two elements that turn it against each other.

Both act on the rim at the radius r, so one shortens by r φ as the other is elongated by it:

    J φ'' + b φ' + k φ + M sin φ = r F₁ - r F₂

with an elastic joint k and a lever whose weight has the moment M at φ = 90°. Both are assembled with the same preload.
An element without tension is slack. Sign convention: φ grows as the first element, `protagonist`, pulls; zero as
assembled.
"""

import math
from functools import reduce

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import MECHANISMS, Column, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import (
    ARC,
    DrawingShape,
    DrawingState,
    draw_bar,
    draw_pin,
    draw_weight,
    trace_arc,
)
from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace
from martensite.kernels.recordable_numbers import xp


@MECHANISMS.register("antagonistic-pulley")
class AntagonisticPulley(AbstractMultibody):
    """Pulley that two elements turn against each other."""

    typical_scenario = "antagonistic_wires"

    radius: Number = param("m", "radius of the rim", above=0.0, high=10.0, typical="8 mm")
    preload: Number = param("N", "force in both elements at assembly", low=0.0, high=1e6, typical="3 N")
    stiffness: Number = param("N*m/rad", "joint stiffness", low=0.0, high=1e6, default=0.0, typical="0.01 N*m/rad")
    moment: Number = param(
        "N*m", "weight moment of a lever that hangs down", low=0.0, high=1e6, default=0.0, typical="0.02 N*m"
    )
    damping: Number = param("N*m*s/rad", "joint damping", low=0.0, high=1e6, default=0.0, typical="1e-3 N*m*s/rad")
    inertia: Number = param("kg*m^2", "inertia", above=0.0, high=1e6, default=1e-5, typical="1e-4 kg*m^2")

    def ports(self) -> tuple[str, ...]:
        """Return the element that increases φ, and the other."""
        return ("protagonist", "antagonist")

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate("angle", "rad", "angle of the pulley", "φ", 1.0),)

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Return ±r φ [m]."""
        turned = self.radius * position[0]
        return [turned, -turned]

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (angle,), (rate,), (acceleration,) = motion
        torque = self.stiffness * angle + self.moment * xp.sin(angle)
        return [torque + self.damping * rate + self.inertia * acceleration]

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        (angle,), (rate,), _ = motion
        lifted = self.moment * (1.0 - xp.cos(angle))
        moved = 0.5 * self.inertia * rate * rate
        return MechanicalEnergy(0.5 * self.stiffness * angle * angle, lifted, moved)

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [self.preload, self.preload]

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        angle, r = reading.outputs["angle"], self.radius
        wound = math.pi * r
        # the straight part as assembled: the longer element reaches the wall
        straight = reduce(xp.maximum, reading.lengths.values(), 2.0 * wound) - wound
        wide, thick = 0.15 * r, 0.3 * r
        wall = ((-straight - thick, 0.0, -2.0 * r), (-straight - thick, 0.0, 2.0 * r))
        axis = ((0.0, wide, 0.0), (0.0, -wide, 0.0))
        shapes = [
            draw_bar("wall", thick, *wall, kind="wall"),
            draw_pin("axis", (0.0, 0.0, 0.0), 3.0 * wide, 0.15 * r),
            DrawingShape("pulley", "pulley", axis, r, turn=angle),
        ]
        for port, side in zip(self.ports(), (1.0, -1.0), strict=True):
            rim = trace_arc(r, side * 0.5 * math.pi, angle - side * 0.5 * math.pi, 2 * ARC)
            free = reading.lengths[port] - wound
            start = xp.minimum(free, straight) if free > 0.0 else 0.5 * r
            path = [(-start, 0.0, side * r), *((x, 0.0, z) for x, z in rim)]
            shapes += [
                draw_bar(f"tie {port}", 0.04 * r, (-straight, 0.0, side * r), path[0], kind="tether"),
                DrawingShape(port, "wire", tuple(path), 0.0, port),
            ]
        if self.moment > 0.0:
            end = (2.5 * r * xp.sin(angle), -3.0 * wide, -2.5 * r * xp.cos(angle))
            shapes += [
                draw_bar("lever", 0.1 * r, (0.0, -3.0 * wide, 0.0), end),
                draw_weight("weight of the lever", end, 0.0, 0.3 * r, r),
            ]
        return shapes
