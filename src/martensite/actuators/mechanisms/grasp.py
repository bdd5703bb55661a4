"""Joints with rigid end stops, and phalanges that close on a fixed cylinder in the plane of a finger.

A phalanx is a segment of length l from its hinge at p, in the direction u, of thickness 2 w, with round ends; a
cylinder of radius R is perpendicular to the plane at c. With t = u·(c - p) along the phalanx and n = u x (c - p) to its
inside, the phalanx is nearest to the axis at t' = t limited to [0, l], and the gap is

    g = √((t - t')² + n²) - R - w,        g = n - R - w where t' = t and n > -R - w.

The distance from the side of a phalanx is signed, so that a phalanx half through a cylinder is pushed back. Contacts
push and do not pull (`martensite.actuators.mechanics.complementarity`); forces are normal, without friction. Plane:
along the straight finger, and inwards in the bending direction.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.mechanisms.base import Column, Load, Output, Readout
from martensite.actuators.mechanisms.multibody import AbstractMultibody, MultibodyMemory
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column

CONTACT = option("end stops as springs, or rigid, or a cylinder too", "springs", "stops", "cylinder", default="springs")
CENTRE = param("1", "centre of mass of the phalanx, as a share of its length", low=0.0, high=1.0, default=0.5)
TILT = param("rad", "direction of gravity, from along a straight finger inwards", low=-6.3, high=6.3, default=0.0)
RADIUS = param("m", "radius of the cylinder", above=0.0, high=10.0, default=0.015)
THICKNESS = param("m", "thickness of the phalanges", low=0.0, high=1.0, default=0.01)


class Touch(NamedTuple):
    """Position of a phalanx relative to a cylinder [m]."""

    gap: Scalar
    place: Scalar
    """Distance of the nearest point from the hinge."""


TOUCH = {
    "contact_force": Output("N", "force between phalanx and cylinder", "F_c"),
    "gap": Output("m", "gap between phalanx and cylinder", "g"),
    "contact_place": Output("m", "distance from the hinge at which the phalanx is nearest to the cylinder", "t"),
}
"""Outputs of a phalanx that may touch a cylinder."""


def find_touches(xp: Namespace, axis: Column, reach: Scalar, lengths: Column, angles: Column) -> list[Touch]:
    """Return the touches of phalanges at relative angles [rad], for a cylinder axis (along, inwards) and R + w [m]."""
    (along, inwards), angle = axis, 0.0 * angles[0]
    touches: list[Touch] = []
    for length, turned in zip(lengths, angles, strict=True):
        angle = angle + turned
        c, s = xp.cos(angle), xp.sin(angle)
        way, across = c * along + s * inwards, c * inwards - s * along
        place = xp.clip(way, 0.0, length)
        past = way - place
        through = xp.both(past * past <= 0.0, across > -reach)
        distance = xp.where(through, across, xp.sqrt(past * past + across * across))
        touches.append(Touch(distance - reach, place))
        along, inwards = along - length * c, inwards - length * s
    return touches


class AbstractGrasp(AbstractMultibody, init=False):
    """Fingers: each coordinate is the angle of a joint, and turns a phalanx."""

    contact: str
    lowest: Number
    highest: Number

    @abstractmethod
    def locate_contacts(self, xp: Namespace, position: Column) -> list[Touch]:
        """Return the touch of each moving phalanx with the cylinder."""

    def stop_gap(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return the gap [rad] of a joint to its nearer end stop."""
        return xp.minimum(angle - self.lowest, self.highest - angle)

    def check_contact(self) -> None:
        """Raise `ParameterError` if end stops leave no range, or the cylinder overlaps a phalanx as assembled."""
        name = self.registered_name
        if self.contact != "springs" and self.lowest == self.highest:
            raise ParameterError(f"Rigid end stops of `{name}` need a range: `highest` must be above `lowest`.")
        if self.contact == "cylinder":
            home = self.locate_contacts(floats, self.home(floats))
            for coordinate, touch in zip(self.coordinates(), home, strict=True):
                check_clearance(f"the phalanx of `{name}` that `{coordinate.name}` turns", touch)

    @override
    def gaps(self, xp: Namespace, position: Column) -> Column:
        if self.contact == "springs":
            return []
        gaps = [self.stop_gap(xp, angle) for angle in position]
        return gaps if self.contact == "stops" else gaps + [touch.gap for touch in self.locate_contacts(xp, position)]

    @override
    def outputs(self) -> dict[str, Output]:
        outputs = super().outputs()
        several = len(self.coordinates()) > 1
        places = [(f"{c.name}_", f", {c.long_name}") if several else ("", "") for c in self.coordinates()]
        added: dict[str, Output] = {}
        if self.contact != "springs":
            added["stop_moment"] = Output("N*m", "moment of end stops, positive where it bends", "M_stop")
        if self.contact == "cylinder":
            added |= TOUCH
        for name, (unit, words, symbol) in added.items():
            outputs |= {f"{prefix}{name}": Output(unit, words + where, symbol) for prefix, where in places}
        if several and self.contact == "cylinder":
            outputs["grasp_force"] = Output("N", "sum of the forces between phalanges and cylinder", "F_g")
        return outputs

    @override
    def observe(self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column) -> Readout:
        forces, outputs = super().observe(xp, memory, loads, signals)
        if self.contact == "springs":
            return forces, outputs
        angles = memory.course.position
        moments, pushed = memory.reactions[: len(angles)], memory.reactions[len(angles) :]
        sides = [xp.where(q - self.lowest > self.stop_gap(xp, q), -1.0, 1.0) for q in angles]
        values = [*outputs, *(m * side for m, side in zip(moments, sides, strict=True))]
        if self.contact == "stops":
            return forces, values
        gaps, places = zip(*self.locate_contacts(xp, angles), strict=True)
        total = [sum_column(pushed)] if len(pushed) > 1 else []
        return forces, [*values, *pushed, *gaps, *places, *total]


def check_clearance(phalanx: str, touch: Touch) -> None:
    """Raise `ParameterError` if a cylinder overlaps a phalanx."""
    if touch.gap < -1e-12:
        raise ParameterError(
            f"The cylinder overlaps {phalanx} by {-1e3 * touch.gap:.4g} mm as assembled; move it away, or "
            "make `cylinder_radius` or `thickness` smaller."
        )
