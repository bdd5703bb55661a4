"""Lever: a wire turns it about a pivot and lifts a weight on the other arm.

The wire runs straight from a fixed point W to the point P at the end of its arm a. As assembled P is at (a, 0) from the
pivot, and the wire, of length ℓ between the points, leaves the arm at the angle γ, towards the pivot if acute. Turned
by φ,

    P = a (cos φ, sin φ),    W = (a - ℓ cos γ, ℓ sin γ),    l = |P - W|,    ΔL = ℓ - l(φ)
    dΔL/dφ = (P × W)/l                           a sin γ as assembled, 0 at the dead centre
    (J + m b²) φ'' + c φ' + m g b cos(φ₀ + φ) + τ₀ + k φ + τ_stop = F dΔL/dφ

The weight m hangs on the arm b, which rises at the angle φ₀ as assembled: its lift is b [sin(φ₀ + φ) - sin φ₀]. A
return spring about the pivot has the torque τ₀ + k φ. Beyond the end stops a stiff spring acts; put the upper stop
before the dead centre, where pivot, P and W are in line.

Sign convention: φ grows as the wire pulls; zero as assembled, with wire, weight and spring in balance. Textbook
statics.
"""

import math
from collections.abc import Sequence

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import MECHANISMS, Column, Load, MechanicalEnergy, Output, Readout
from martensite.actuators.mechanisms.drawing import (
    DrawingShape,
    DrawingState,
    draw_bar,
    draw_pin,
    draw_weight,
    lead_wire,
)
from martensite.actuators.mechanisms.joints import find_stop_energy, stop_torque
from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate, MultibodyMemory
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp


@MECHANISMS.register("lever")
class Lever(AbstractMultibody):
    """Lever about a pivot between a wire and a weight."""

    arm: Number = param("m", "arm a of the wire", above=0.0, high=10.0, typical="20 mm")
    distance: Number = param(
        "m", "distance ℓ of the fixed end of the wire from its arm", above=0.0, high=100.0, typical="60 mm"
    )
    wire_angle: Number = param(
        "rad",
        "angle γ between wire and arm as assembled",
        above=0.0,
        high=3.1,
        default=0.5 * math.pi,
        typical="1.3 rad",
    )
    mass: Number = param("kg", "hanging mass", low=0.0, high=1e6, default=0.0, typical="200 g")
    weight_arm: Number = param("m", "arm b of the weight", above=0.0, high=10.0, typical="50 mm")
    weight_angle: Number = param(
        "rad",
        "angle φ₀ at which the arm of the weight rises as assembled",
        low=-1.57,
        high=1.57,
        default=0.0,
        typical="0.2 rad",
    )
    gravity: Number = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)
    stiffness: Number = param("N*m/rad", "return spring rate", low=0.0, high=1e6, default=0.0, typical="0.05 N*m/rad")
    torque: Number = param("N*m", "return spring torque at home", low=0.0, high=1e6, default=0.0, typical="0.02 N*m")
    lowest: Number = param("rad", "lower end stop", low=-3.1, high=0.0, default=-1.0)
    highest: Number = param("rad", "upper end stop", above=0.0, high=3.1, default=1.0)
    stop: Number = param("N*m/rad", "stiffness of the end stops", low=0.0, high=1e6, default=100.0)
    damping: Number = param("N*m*s/rad", "pivot damping", low=0.0, high=1e6, default=0.0, typical="0.01 N*m*s/rad")
    inertia: Number = param(
        "kg*m^2", "inertia of the lever without the weight", above=0.0, high=1e6, default=1e-6, typical="1e-4 kg*m^2"
    )

    def dead_centre(self) -> float:
        """Return the angle [rad] at which pivot, arm and wire are in line."""
        across = self.distance * math.sin(self.wire_angle)
        return math.atan2(across, self.arm - self.distance * math.cos(self.wire_angle))

    @override
    def cautions(self) -> list[str]:
        if self.dead_centre() > self.highest:
            return []
        return [
            f"The lever has its dead centre at {self.dead_centre():.4g} rad, before its upper end "
            f"stop at {self.highest:.4g} rad; there the wire turns it no further."
        ]

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate("angle", "rad", "angle of the lever", "φ", 1.0),)

    @override
    def outputs(self) -> dict[str, Output]:
        return super().outputs() | {"lift": Output("m", "lift of the weight", "z")}

    @override
    def observe(self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column) -> Readout:
        forces, own = super().observe(xp, memory, loads, signals)
        rise = xp.sin(self.weight_angle + own[0]) - xp.sin(self.weight_angle)
        return forces, [*own, self.weight_arm * rise]

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Return ΔL [m]."""
        x = self.arm * (xp.cos(position[0]) - 1.0) + self.distance * xp.cos(self.wire_angle)
        y = self.arm * xp.sin(position[0]) - self.distance * xp.sin(self.wire_angle)
        return [self.distance - xp.sqrt(x * x + y * y)]

    def holding_torque(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return the torque [N m] of weight and return spring."""
        weight = self.mass * self.gravity * self.weight_arm
        return weight * xp.cos(self.weight_angle + angle) + self.torque + self.stiffness * angle

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (angle,), (rate,), (acceleration,) = motion
        stop = stop_torque(xp, angle, self.lowest, self.highest, self.stop)
        moved = self.damping * rate + self._turning() * acceleration
        return [self.holding_torque(xp, angle) + stop + moved]

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        (angle,), (rate,), _ = motion
        rise = xp.sin(self.weight_angle + angle) - xp.sin(self.weight_angle)
        stop = find_stop_energy(xp, angle, self.lowest, self.highest, self.stop)
        return MechanicalEnergy(
            springs=(self.torque + 0.5 * self.stiffness * angle) * angle + stop,
            gravity=self.mass * self.gravity * self.weight_arm * rise,
            kinetic=0.5 * self._turning() * rate * rate,
        )

    def _turning(self) -> Scalar:
        """Return J + m b² [kg m²]."""
        return self.inertia + self.mass * self.weight_arm * self.weight_arm

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [self.holding_torque(xp, 0.0) / (self.arm * xp.sin(self.wire_angle))]

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        angle, (port,) = reading.outputs["angle"], self.ports()
        leaves, a, b = self.wire_angle, self.arm, self.weight_arm
        fixed = (a - self.distance * xp.cos(leaves), 0.0, self.distance * xp.sin(leaves))
        away = (-xp.cos(leaves), 0.0, xp.sin(leaves))
        end = (a * xp.cos(angle), 0.0, a * xp.sin(angle))
        rises = self.weight_angle + angle
        hook = (b * xp.cos(rises), 0.0, b * xp.sin(rises))
        hung = (hook[0], 0.0, hook[2] - 0.3 * b)
        pivot, thick, most = (0.0, 0.0, 0.0), 0.04 * xp.maximum(a, b), 0.3 * b
        block = ((fixed[0] - 2.0 * thick, 0.0, fixed[2]), (fixed[0] + 2.0 * thick, 0.0, fixed[2]))
        shapes = [
            draw_bar("bearing", thick, (0.0, 0.0, -4.0 * thick), pivot, kind="ground"),
            draw_bar("holder", 0.6 * thick, *block, kind="wall"),
            draw_pin("pivot", pivot, 2.0 * thick, 1.2 * thick),
            draw_bar("arm of the wire", thick, pivot, end),
            *lead_wire(port, [fixed, end], reading.lengths[port] - self.distance, away),
        ]
        if self.mass > 0.0:
            shapes += [
                draw_bar("arm of the weight", 0.8 * thick, pivot, hook),
                draw_bar("thread", 0.0, hook, hung, kind="tether"),
                draw_weight("weight", hung, self.mass, 2.0 * thick, most),
            ]
        return shapes
