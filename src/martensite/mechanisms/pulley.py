r"""Antagonistic wires on a pulley: two elements that turn it against each other.

Each is led to the rim at the radius r, so one shortens by r φ as the other is drawn out by it:

    J φ'' + b φ' + k φ + M sin φ = r F₁ - r F₂

with an elastic joint k and a lever whose weight has the moment M at φ = 90°. Both are assembled
with the same preload. An element without tension hangs slack.

Sign convention: φ grows as the first element, `protagonist`, pulls; zero as assembled.
"""

from __future__ import annotations

from martensite.mechanisms.base import MECHANISMS, Column
from martensite.mechanisms.multibody import AbstractMultibody, Coordinate
from martensite.mechanisms.shared.motion import Motion
from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar


@MECHANISMS.register("antagonistic-pulley")
class AntagonisticPulley(AbstractMultibody):
    """A pulley that two elements turn against each other."""

    radius: Scalar = param("m", "radius of the rim", above=0.0, high=10.0)
    preload: Scalar = param("N", "force in both elements at assembly", low=0.0, high=1e6)
    stiffness: Scalar = param("N*m/rad", "stiffness of the joint", low=0.0, high=1e6, default=0.0)
    moment: Scalar = param(
        "N*m", "weight moment of a lever that hangs down", low=0.0, high=1e6, default=0.0
    )
    damping: Scalar = param("N*m*s/rad", "damping of the joint", low=0.0, high=1e6, default=0.0)
    inertia: Scalar = param("kg*m^2", "inertia", above=0.0, high=1e6, default=1e-5)

    def ports(self) -> tuple[str, ...]:
        """The one that pulls φ up, and the other."""
        return ("protagonist", "antagonist")

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The angle."""
        return (Coordinate("angle", "rad", "angle of the pulley", "φ", 1.0),)

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """±r φ [m]."""
        turned = self.radius * position[0]
        return [turned, -turned]

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """Torque [N m] of joint, lever, damping and inertia."""
        (angle,), (rate,), (acceleration,) = motion
        held = self.stiffness * angle + self.moment * xp.sin(angle)
        return [held + self.damping * rate + self.inertia * acceleration]

    def start_forces(self, xp: Namespace) -> Column:
        """The preload, twice [N]."""
        return [self.preload, self.preload]
