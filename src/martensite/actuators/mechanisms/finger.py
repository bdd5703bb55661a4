r"""Finger: one hinge, bent by a wire that is led over it there and back, against a spring.

The wire slides through brackets whose holes lie at (∓g, -r) from the hinge. With h = θ/2 its
path across the hinge is shorter by ΔL, with the moment arm m, on each of its n passes:

    ΔL(θ) = 2 [r sin h + g (1 - cos h)],        m(θ) = dΔL/dθ = r cos h + g sin h
    J θ'' + b θ' + τ_s(θ) + τ_stop(θ) = n η F m(θ)

The element is the whole wire of n equal passes, so it shortens by n ΔL. The return spring k acts
at the distance a from the hinge and has the extension δ₀ at θ = 0: always across its arm
(`follower`), or from a fixed end at the distance H (`fixed`),

    follower   τ_s = k a (δ₀ + a θ)
    fixed      τ_s = k (l - H + δ₀) dl/dθ,      l = |(a cos θ, -a sin θ) - (a, H)|,
               dl/dθ = a (H cos θ + a sin θ)/l

The fixed one pulls over centre where tan θ = -H/a, beyond 90°. The brackets meet at θ = 2 φ with
tan φ = g/r; there, and at the end stops, a stiff spring acts.

Friction: the wire is wrapped by θ/2 over each of the two brackets of the hinge. As it contracts it
is drawn out of the span between them on either side, so that span, which alone has the moment arm
m, keeps of the tension F on both sides the share of Euler and Eytelwein

    η = exp(-μ |θ|/2 · tanh(θ'/v₀)),

less than 1 while the wire pulls, more than 1 while it is drawn back. At one angle the two tensions
differ by exp(μ θ). Where the passes turn back, the wire rests by symmetry and nothing is lost.
The wire has one stress: that of the span, a small part of it, is not accounted for.

Zero of θ is the finger as assembled, where spring and wire are in balance.

Source: the finger prototype of `finger-paper`, its geometry completed for this project; every
completion is a parameter here. Sign convention: θ grows as the wire pulls.
"""

from __future__ import annotations

from martensite.actuators.mechanics.finger_drawing import drawn_finger
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import MECHANISMS, Column, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState
from martensite.actuators.mechanisms.joints import bowstring_arm, find_stop_energy, shorten_bowstring, stop_torque
from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate
from martensite.base.parameters import option, param
from martensite.kernels.namespace import Namespace, Scalar


@MECHANISMS.register("finger")
class Finger(AbstractMultibody):
    """A joint bent by a wire over brackets, against a return spring."""

    typical_scenario = "finger"

    cites = ("finger-paper",)

    offset: Scalar = param("m", "distance r of the wire from the hinge", above=0.0, high=1.0, typical="4 mm")
    bracket: Scalar = param(
        "m", "distance g of a bracket from the hinge, along the phalanx", above=0.0, high=1.0, typical="5 mm"
    )
    passes: Scalar = param("1", "how often the wire passes the hinge", low=1.0, high=100.0, default=2.0)
    spring: str = option(
        "return spring: always across its arm, or from a fixed end", "follower", "fixed", default="follower"
    )
    stiffness: Scalar = param("N/m", "rate of the return spring", low=0.0, high=1e6, typical="200 N/m")
    arm: Scalar = param("m", "distance a of the spring from the hinge", above=0.0, high=1.0, typical="8 mm")
    extension: Scalar = param(
        "m", "extension of the spring at angle zero", low=0.0, high=1.0, default=0.0, typical="2 mm"
    )
    height: Scalar = param("m", "distance H of the fixed end of the spring", above=0.0, high=10.0, default=0.05)
    friction: Scalar = param("1", "friction of the wire on brackets", low=0.0, high=2.0, default=0.0, typical=0.1)
    friction_rate: Scalar = param(
        "rad/s", "rate over which friction changes sign", above=0.0, high=100.0, default=1e-2, typical="5 rad/s"
    )
    lowest: Scalar = param("rad", "lower end stop", low=-6.3, high=0.0, default=-3.0)
    highest: Scalar = param("rad", "upper end stop", low=0.0, high=6.3, default=3.0)
    stop: Scalar = param("N*m/rad", "stiffness of the end stops", low=0.0, high=1e6, default=10.0)
    damping: Scalar = param(
        "N*m*s/rad", "damping of the hinge", low=0.0, high=1e6, default=0.0, typical="2e-4 N*m*s/rad"
    )
    inertia: Scalar = param(
        "kg*m^2", "inertia of the phalanx", above=0.0, high=1e6, default=1e-5, typical="2e-5 kg*m^2"
    )

    def coordinates(self) -> tuple[Coordinate, ...]:
        """The angle."""
        return (Coordinate("angle", "rad", "angle of the joint", "θ", 1.0),)

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """n ΔL [m]."""
        return [self.passes * shorten_bowstring(xp, position[0], self.offset, self.bracket)]

    def spring_torque(self, xp: Namespace, angle: Scalar) -> Scalar:
        """τ_s [N m] of the return spring."""
        if self.spring == "follower":
            return self.stiffness * self.arm * (self.extension + self.arm * angle)
        c, s = xp.cos(angle), xp.sin(angle)
        length = self._spring_length(xp, angle)
        lever = self.arm * (self.height * c + self.arm * s) / length
        return self.stiffness * (length - self.height + self.extension) * lever

    def _spring_length(self, xp: Namespace, angle: Scalar) -> Scalar:
        """l [m] of the spring from a fixed end, at home H."""
        across = self.arm * (xp.cos(angle) - 1.0)
        along = self.arm * xp.sin(angle) + self.height
        return xp.sqrt(across * across + along * along)

    def stops(self, xp: Namespace, angle: Scalar) -> Scalar:
        """τ_stop [N m] of the end stops, and of brackets that have met."""
        h = 0.5 * xp.clip(angle, 0.0, 3.1)
        c, s = xp.cos(h), xp.sin(h)
        past = (self.offset * s - self.bracket * c) / (self.offset * c + self.bracket * s)
        met = self.stop * xp.maximum(2.0 * past, 0.0)  # 2 tan(θ/2 - φ), which grows ever faster
        return met + stop_torque(xp, angle, self.lowest, self.highest, self.stop)

    def transmission(self, xp: Namespace, motion: Motion) -> Column:
        """η: what friction leaves of the tension."""
        way = xp.tanh(motion.velocity[0] * (1.0 / self.friction_rate))
        return [xp.exp(-0.5 * self.friction * xp.abs(motion.position[0]) * way)]

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """Torque [N m] of spring, stops, damping and inertia."""
        (angle,), (rate,), (acceleration,) = motion
        held = self.spring_torque(xp, angle) + self.stops(xp, angle)
        return [held + self.damping * rate + self.inertia * acceleration]

    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        """Of the return spring, of what stops, and of the phalanx that moves."""
        (angle,), (rate,), _ = motion
        by = self.arm * angle
        if self.spring == "fixed":
            by = self._spring_length(xp, angle) - self.height
        drawn = self.extension + by
        spring = 0.5 * self.stiffness * drawn * drawn
        stop = self._stop_energy(xp, angle)
        return MechanicalEnergy(springs=spring + stop, kinetic=0.5 * self.inertia * rate * rate)

    def _stop_energy(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Of end stops and brackets [J]: ∫ 2 tan(θ/2 - φ) dθ = -4 ln cos(θ/2 - φ)."""
        bent = xp.clip(angle, 0.0, 3.1)
        c, s = xp.cos(0.5 * bent), xp.sin(0.5 * bent)
        arm = self.offset * c + self.bracket * s
        past = (self.offset * s - self.bracket * c) / arm
        span = xp.sqrt(self.offset * self.offset + self.bracket * self.bracket)
        met = xp.where(past > 0.0, -4.0 * xp.log(arm / span), 0.0)
        met = met + 2.0 * xp.maximum(past, 0.0) * (xp.maximum(angle, bent) - bent)
        stops = find_stop_energy(xp, angle, self.lowest, self.highest, self.stop)
        return self.stop * met + stops

    def dissipative(self, xp: Namespace, motion: Motion) -> Column:
        """b θ' [N m]; friction on brackets is that of the `transmission`."""
        return [self.damping * motion.velocity[0]]

    def start_forces(self, xp: Namespace) -> Column:
        """Force at angle zero [N]."""
        arm = self.passes * bowstring_arm(xp, 0.0, self.offset, self.bracket)
        return [self.spring_torque(xp, 0.0) / arm]

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Both phalanges, the wire over its brackets, and the return spring."""
        return drawn_finger(self, reading)
