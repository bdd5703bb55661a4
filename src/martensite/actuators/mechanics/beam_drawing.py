"""Drawing of the motor on a beam: the beam along x, its tip moving along z.

The tip, the rotor, and the way of the wire are those of `martensite.actuators.mechanisms.beam_motor`. How long the beam
is, it does not know: it is drawn as long as the way of the wire along it, or without one fifteen eccentricities. It
bends as if by a force at its tip, w = x_tip (3 s² - s³)/2, whatever the modes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar
from martensite.kernels.recordable_numbers import xp

if TYPE_CHECKING:
    from martensite.actuators.mechanisms.beam_motor import BeamMotor

PIECES = 12
"""Straight pieces that a bent beam is drawn of."""
SHORTEST = 0.05
"""Length of a beam without wire and eccentricity [m]."""


def drawn_beam(mechanism: BeamMotor, reading: DrawingState) -> list[DrawingShape]:
    """Draw clamp, beam, motor, rotor, and the wire if there is one."""
    tip, angle = reading.outputs["displacement"], reading.outputs["rotor_angle"]
    r, (across, reach) = mechanism.eccentricity, _measure_reach(mechanism)
    thick, tall = 0.008 * reach, 0.1 * reach
    shares = [k / PIECES for k in range(PIECES + 1)]
    bent = [(reach * s, 0.0, 0.5 * tip * s * s * (3.0 - s)) for s in shares]
    lowest = -xp.maximum(tall, 1.15 * across)
    arm = xp.maximum(r, 0.03 * reach)
    near, out = 1.5 * thick, 4.0 * thick
    axis = ((reach, -near, tip), (reach, -out, tip))
    found = [
        draw_bar("clamp", 2.0 * thick, (-thick, 0.0, lowest), (-thick, 0.0, tall), kind="wall"),
        draw_bar("beam", thick, *bent, kind="beam"),
        DrawingShape("motor", "motor", ((reach, near, tip), (reach, -near, tip)), 0.6 * arm),
        DrawingShape("rotor", "rotor", (*axis, (reach + arm, -out, tip)), 0.3 * arm, turn=angle),
    ]
    if "rotor_angle_2" in reading.outputs:
        behind = ((reach, near, tip), (reach, out, tip), (reach + arm, out, tip))
        found.append(DrawingShape("second rotor", "rotor", behind, 0.3 * arm, turn=reading.outputs["rotor_angle_2"]))
    if mechanism.ports():
        (port,) = mechanism.ports()
        path = ((0.0, 0.0, -across), (reach, 0.0, tip))
        found.append(DrawingShape(port, "wire", path, 0.0, port))
    return found


def _measure_reach(mechanism: BeamMotor) -> tuple[float, float]:
    """Return the way of the wire across the beam, and length of the beam as it is drawn [m]."""
    if mechanism.ports():
        way, angle = mechanism.wire_length, mechanism.wire_angle
        return way * xp.sin(angle), way * xp.cos(angle)
    return 0.0, xp.maximum(15.0 * mechanism.eccentricity, SHORTEST)
