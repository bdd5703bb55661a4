"""Drawing of the motor on a beam: the beam along x, its tip moving along z.

Tip, rotor and wire are those of `martensite.actuators.mechanisms.beam_motor`, which has no beam length: the beam is
drawn as long as the wire along it, or else fifteen eccentricities. It bends as under a tip force, w = x_tip (3 s² -
s³)/2, for any modes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar
from martensite.kernels.recordable_numbers import xp

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.beam_motor import BeamMotor

PIECES = 12
"""Straight pieces of a drawn bent beam."""
SHORTEST = 0.05
"""Length of a beam without wire and eccentricity [m]."""


def drawn_beam(mechanism: BeamMotor, reading: DrawingState) -> list[DrawingShape]:
    """Return clamp, beam, motor, rotor, and an optional wire."""
    tip, angle = reading.outputs["displacement"], reading.outputs["rotor_angle"]
    r, (across, reach) = mechanism.eccentricity, _measure_reach(mechanism)
    thick, tall = 0.008 * reach, 0.1 * reach
    shares = [k / PIECES for k in range(PIECES + 1)]
    bent = [(reach * s, 0.0, 0.5 * tip * s * s * (3.0 - s)) for s in shares]
    lowest = -xp.maximum(tall, 1.15 * across)
    arm = xp.maximum(r, 0.03 * reach)
    near, out = 1.5 * thick, 4.0 * thick
    axis = ((reach, -near, tip), (reach, -out, tip))
    shapes = [
        draw_bar("clamp", 2.0 * thick, (-thick, 0.0, lowest), (-thick, 0.0, tall), kind="wall"),
        draw_bar("beam", thick, *bent, kind="beam"),
        DrawingShape("motor", "motor", ((reach, near, tip), (reach, -near, tip)), 0.6 * arm),
        DrawingShape("rotor", "rotor", (*axis, (reach + arm, -out, tip)), 0.3 * arm, turn=angle),
    ]
    if "rotor_angle_2" in reading.outputs:
        behind = ((reach, near, tip), (reach, out, tip), (reach + arm, out, tip))
        shapes.append(DrawingShape("second rotor", "rotor", behind, 0.3 * arm, turn=reading.outputs["rotor_angle_2"]))
    if mechanism.ports():
        (port,) = mechanism.ports()
        path = ((0.0, 0.0, -across), (reach, 0.0, tip))
        shapes.append(DrawingShape(port, "wire", path, 0.0, port))
    return shapes


def _measure_reach(mechanism: BeamMotor) -> tuple[float, float]:
    """Return the extent of the wire across the beam and the drawn length of the beam [m]."""
    if mechanism.ports():
        way, angle = mechanism.wire_length, mechanism.wire_angle
        return way * xp.sin(angle), way * xp.cos(angle)
    return 0.0, xp.maximum(15.0 * mechanism.eccentricity, SHORTEST)
