"""Finger: one hinge, bent by a wire that passes it several times, against a spring.

The wire slides through brackets with holes at (∓g, -r) from the hinge. With h = θ/2 its path across the hinge is
shorter by ΔL, with the moment arm m, on each of its n passes:

    ΔL(θ) = 2 [r sin h + g (1 - cos h)],        m(θ) = dΔL/dθ = r cos h + g sin h
    J θ'' + b θ' + τ_s(θ) + τ_stop(θ) = n η F m(θ)

The element is the whole wire of n equal passes, so it shortens by n ΔL. The return spring k acts at the distance a from
the hinge and has the extension δ₀ at θ = 0: always across its arm (`follower`), or from a fixed end at the distance H
(`fixed`),

    follower   τ_s = k a (δ₀ + a θ)
    fixed      τ_s = k (l - H + δ₀) dl/dθ,      l = |(a cos θ, -a sin θ) - (a, H)|,
               dl/dθ = a (H cos θ + a sin θ)/l

The fixed spring pulls over centre at tan θ = -H/a, beyond 90°. The brackets meet at θ = 2 φ with tan φ = g/r; there,
and at the end stops, a stiff spring acts. With `contact` they are rigid instead, with a moment that only pushes: 0 ≤ λ
⊥ γ ≥ 0 with the smallest gap γ of θ - θ_lowest, θ_highest - θ and 2 sin(φ - θ/2)
(`martensite.actuators.mechanics.complementarity`); a fixed `cylinder` acts on the far phalanx (`grasp`).

Weight, off by default, adds m g₀ c sin(θ - β) on the left: for the mass m at the fraction c/l of the phalanx, with
gravity in the direction β from the straight phalanx towards the inside. The inertia J is about the hinge and includes
that mass.

Friction: the wire is wrapped by θ/2 over each of the two brackets of the hinge. A contracting wire is drawn out of the
span between them on both sides, so that the tension in the span, which alone has the moment arm m, is by Euler and
Eytelwein the fraction

    η = exp(-μ |θ|/2 · tanh(θ'/v₀)),

below 1 while the wire pulls, above 1 while it is drawn back. At one angle the two tensions differ by exp(μ θ). The
turning points of the passes do not move by symmetry and lose nothing. The different stress in the short span is
neglected. Zero of θ is the finger as assembled, with spring and wire in balance.

Source: the finger prototype of `finger-paper`, its geometry completed for this project; every completion is a parameter
here. Sign convention: θ grows as the wire pulls.
"""

import math

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms import grasp
from martensite.actuators.mechanisms.base import MECHANISMS, Column, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import (
    ARC,
    DrawingShape,
    DrawingState,
    Point,
    draw_bar,
    draw_cylinder,
    draw_force,
    draw_pin,
    lead_wire,
    measure_length,
    trace_arc,
)
from martensite.actuators.mechanisms.joints import bowstring_arm, find_stop_energy, shorten_bowstring, stop_torque
from martensite.actuators.mechanisms.multibody import Coordinate
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp


@MECHANISMS.register("finger")
class Finger(grasp.AbstractGrasp):
    """Joint bent by a wire over brackets, against a return spring."""

    typical_scenario = "finger"

    cites = ("finger-paper",)

    offset: Number = param("m", "distance r of the wire from the hinge", above=0.0, high=1.0, typical="4 mm")
    bracket: Number = param(
        "m", "distance g of a bracket from the hinge, along the phalanx", above=0.0, high=1.0, typical="5 mm"
    )
    passes: Number = param("1", "how often the wire passes the hinge", low=1.0, high=100.0, default=2.0)
    spring: str = option("return spring: across its arm, or from a fixed end", "follower", "fixed", default="follower")
    stiffness: Number = param("N/m", "rate of the return spring", low=0.0, high=1e6, typical="200 N/m")
    arm: Number = param("m", "distance a of the spring from the hinge", above=0.0, high=1.0, typical="8 mm")
    extension: Number = param("m", "extension of the spring at θ = 0", low=0.0, high=1.0, default=0.0, typical="2 mm")
    height: Number = param("m", "distance H of the fixed end of the spring", above=0.0, high=10.0, default=0.05)
    friction: Number = param("1", "friction of the wire on brackets", low=0.0, high=2.0, default=0.0, typical=0.1)
    friction_rate: Number = param(
        "rad/s", "rate over which friction changes sign", above=0.0, high=100.0, default=1e-2, typical="5 rad/s"
    )
    lowest: Number = param("rad", "lower end stop", low=-6.3, high=0.0, default=-3.0)
    highest: Number = param("rad", "upper end stop", low=0.0, high=6.3, default=3.0)
    stop: Number = param("N*m/rad", "stiffness of the end stops", low=0.0, high=1e6, default=10.0)
    damping: Number = param("N*m*s/rad", "damping of a hinge", low=0.0, high=1e6, default=0.0, typical="2e-4 N*m*s/rad")
    inertia: Number = param("kg*m^2", "inertia of a phalanx", above=0.0, high=1e6, default=1e-5, typical="2e-5 kg*m^2")
    weight: str = option("whether the phalanx has a weight", "none", "given", default="none")
    mass: Number = param("kg", "mass of the phalanx", low=0.0, high=1e3, default=0.01)
    centre: Scalar = grasp.CENTRE
    phalanx_length: Number = param("m", "length of the phalanx", above=0.0, high=10.0, default=0.04)
    gravity: Number = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)
    tilt: Scalar = grasp.TILT
    contact: str = grasp.CONTACT
    thickness: Scalar = grasp.THICKNESS
    cylinder_radius: Scalar = grasp.RADIUS
    cylinder_along: Number = param(
        "m", "axis of the cylinder, along the phalanx at θ = 0", low=-10.0, high=10.0, default=0.02
    )
    cylinder_inwards: Number = param("m", "axis of the cylinder, to the inside", low=-10.0, high=10.0, default=0.03)

    @override
    def check(self) -> None:
        if min(self.start_forces(floats)) < 0.0:
            raise ParameterError(
                "The weight of `finger` bends it as assembled, so that the wire would have to push; raise `extension` "
                f"until the spring holds {-self._weigh(floats, 0.0)[0]:.4g} N m, or turn `tilt`."
            )
        least = self.mass * (self.centre * self.phalanx_length) ** 2
        if self.weight == "given" and self.moves and self.inertia < least:
            raise ParameterError(
                f"Parameter `inertia` of `finger`, about its hinge, must be at least that of its mass at its centre, "
                f"{least:.4g} kg m^2, but is {self.inertia:.4g} kg m^2."
            )
        self.check_contact()
        if self.contact == "cylinder":
            fixed = self._touch_cylinder(floats, -self.cylinder_along, 0.0)
            grasp.check_clearance("the fixed phalanx of `finger`", fixed)

    @override
    def cautions(self) -> list[str]:
        far = math.hypot(self.cylinder_along, self.cylinder_inwards)
        reach = self.cylinder_radius + 0.5 * self.thickness
        if self.contact != "cylinder" or far - reach <= self.phalanx_length:
            return []
        short = 1e3 * (far - reach - self.phalanx_length)
        return [f"The cylinder of the finger cannot be touched: `phalanx_length` is {short:.4g} mm too short."]

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate("angle", "rad", "angle of the joint", "θ", 1.0),)

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Return n ΔL [m]."""
        return [self.passes * shorten_bowstring(xp, position[0], self.offset, self.bracket)]

    def spring_torque(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return τ_s [N m] of the return spring."""
        if self.spring == "follower":
            return self.stiffness * self.arm * (self.extension + self.arm * angle)
        c, s = xp.cos(angle), xp.sin(angle)
        length = self._spring_length(xp, angle)
        lever = self.arm * (self.height * c + self.arm * s) / length
        return self.stiffness * (length - self.height + self.extension) * lever

    def _spring_length(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return l [m] of the spring from a fixed end."""
        across = self.arm * (xp.cos(angle) - 1.0)
        along = self.arm * xp.sin(angle) + self.height
        return xp.sqrt(across * across + along * along)

    def stops(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return τ_stop [N m] of end stops and meeting brackets."""
        if self.contact != "springs":
            return 0.0
        h = 0.5 * xp.clip(angle, 0.0, 3.1)
        c, s = xp.cos(h), xp.sin(h)
        past = (self.offset * s - self.bracket * c) / (self.offset * c + self.bracket * s)
        met = self.stop * xp.maximum(2.0 * past, 0.0)  # 2 tan(θ/2 - φ)
        return met + stop_torque(xp, angle, self.lowest, self.highest, self.stop)

    def transmission(self, xp: Namespace, motion: Motion) -> Column:
        """Return η."""
        way = xp.tanh(motion.velocity[0] * (1.0 / self.friction_rate))
        return [xp.exp(-0.5 * self.friction * xp.abs(motion.position[0]) * way)]

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (angle,), (rate,), (acceleration,) = motion
        torque = self.spring_torque(xp, angle) + self.stops(xp, angle) + self._weigh(xp, angle)[0]
        return [torque + self.damping * rate + self.inertia * acceleration]

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        (angle,), (rate,), _ = motion
        by = self.arm * angle
        if self.spring == "fixed":
            by = self._spring_length(xp, angle) - self.height
        elongation = self.extension + by
        spring = 0.5 * self.stiffness * elongation * elongation
        stop = self._stop_energy(xp, angle)
        _, lifted = self._weigh(xp, angle)
        return MechanicalEnergy(springs=spring + stop, gravity=lifted, kinetic=0.5 * self.inertia * rate * rate)

    def _weigh(self, xp: Namespace, angle: Scalar) -> tuple[Scalar, Scalar]:
        """Return the torque [N m] against the weight, and its energy [J]."""
        if self.weight == "none":
            return 0.0, 0.0
        moment, leaning = self.mass * self.gravity * self.centre * self.phalanx_length, angle - self.tilt
        return moment * xp.sin(leaning), -moment * xp.cos(leaning)

    def _touch_cylinder(self, xp: Namespace, along: Scalar, angle: Scalar) -> grasp.Touch:
        axis, reach = (along, self.cylinder_inwards), self.cylinder_radius + 0.5 * self.thickness
        return grasp.find_touches(xp, axis, reach, [self.phalanx_length], [angle])[0]

    @override
    def locate_contacts(self, xp: Namespace, position: Column) -> list[grasp.Touch]:
        return [self._touch_cylinder(xp, self.cylinder_along, position[0])]

    def stop_gap(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return the gap [rad] to the nearest end stop, including meeting brackets."""
        h = 0.5 * angle
        span = xp.sqrt(self.offset * self.offset + self.bracket * self.bracket)
        met = 2.0 * (self.bracket * xp.cos(h) - self.offset * xp.sin(h)) / span
        return xp.minimum(super().stop_gap(xp, angle), met)

    def _stop_energy(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return the energy of end stops and brackets [J]: ∫ 2 tan(θ/2 - φ) dθ = -4 ln cos(θ/2 - φ)."""
        if self.contact != "springs":
            return 0.0
        bent = xp.clip(angle, 0.0, 3.1)
        c, s = xp.cos(0.5 * bent), xp.sin(0.5 * bent)
        arm = self.offset * c + self.bracket * s
        past = (self.offset * s - self.bracket * c) / arm
        span = xp.sqrt(self.offset * self.offset + self.bracket * self.bracket)
        met = xp.where(past > 0.0, -4.0 * xp.log(arm / span), 0.0)
        met = met + 2.0 * xp.maximum(past, 0.0) * (xp.maximum(angle, bent) - bent)
        stops = find_stop_energy(xp, angle, self.lowest, self.highest, self.stop)
        return self.stop * met + stops

    @override
    def start_forces(self, xp: Namespace) -> Column:
        arm = self.passes * bowstring_arm(xp, 0.0, self.offset, self.bracket)
        return [(self.spring_torque(xp, 0.0) + self._weigh(xp, 0.0)[0]) / arm]

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Return the hinge in the origin, phalanges along -x and +x, the wire below; θ turns the far phalanx about +y.

        The wire passes the hinge n times, side by side, and its rest runs along the phalanges, to scale for whole n. A
        follower spring pulls a thread wound on a drum of radius a. Once the brackets have met, the wire runs through
        their meeting point.
        """
        angle, (port,) = reading.outputs["angle"], self.ports()
        r, g = self.offset, self.bracket
        thick, tip, hinge = 0.85 * r, 4.0 * g, (0.0, 0.0, 0.0)
        grasped = list[DrawingShape]()
        if self.contact == "cylinder":
            thick, tip = 0.5 * self.thickness, self.phalanx_length
            grasped = self._draw_grasp(reading)
        # length of each pass on both sides of the hinge
        rest = (reading.lengths[port] - measure_length(_trace_path(self, 0.0, 0.0, 0.0))) / _count_passes(self)
        beyond = xp.minimum(2.0 * g, 0.4 * xp.maximum(rest, 0.0))
        behind = xp.maximum(rest - beyond, 0.0)
        path, start = _trace_path(self, angle, behind, beyond), -1.1 * behind - 2.0 * g
        return [
            draw_bar("base", 0.7 * r, (start, 0.0, -2.5 * r), (start, 0.0, 2.5 * r), kind="wall"),
            draw_bar("near phalanx", thick, hinge, (start, 0.0, 0.0), kind="phalanx"),
            draw_bar("far phalanx", thick, hinge, turn_point(angle, tip, 0.0), kind="fingertip"),
            draw_bar("near bracket", 0.2 * r, (-g, 0.0, 0.0), (-g, 0.0, -r), kind="bracket"),
            draw_bar("far bracket", 0.2 * r, turn_point(angle, g, 0.0), turn_point(angle, g, -r), kind="bracket"),
            draw_pin("hinge", hinge, 1.1 * r, 0.45 * r),
            *lead_wire(port, path, xp.minimum(rest, 0.0) * _count_passes(self), (-1.0, 0.0, 0.0)),
            *_draw_spring(self, angle),
            *grasped,
        ]

    def _draw_grasp(self, reading: DrawingState) -> list[DrawingShape]:
        width = 2.0 * self.offset
        touching = turn_point(reading.outputs["angle"], reading.outputs["contact_place"], -0.5 * self.thickness)
        axis = (self.cylinder_along, 0.0, -self.cylinder_inwards)
        force = draw_force("contact force", axis, touching, reading.outputs["contact_force"])
        return [draw_cylinder(axis, width, self.cylinder_radius), force]


def turn_point(angle: float, x: float, z: float, y: float = 0.0) -> Point:
    """Return a point of the far phalanx, turned about +y."""
    c, s = xp.cos(angle), xp.sin(angle)
    return c * x + s * z, y, c * z - s * x


def _count_passes(finger: Finger) -> int:
    return max(round(finger.passes), 1)


def _trace_path(finger: Finger, angle: float, behind: float, beyond: float) -> list[Point]:
    """Return all passes over the hinge, side by side, with given lengths [m] on both sides."""
    r, g, passes = finger.offset, finger.bracket, _count_passes(finger)
    apart, met = min(0.6, 1.6 / passes) * r, xp.minimum(angle, 2.0 * xp.atan2(g, r))
    path: list[Point] = []
    for k in range(passes):
        y = apart * (k - 0.5 * (passes - 1))
        way = [(-g - behind, y, -r), (-g, y, -r), turn_point(met, g, -r, y), turn_point(met, g + beyond, -r, y)]
        path += way if k % 2 == 0 else way[::-1]
    return path


def _draw_spring(finger: Finger, angle: float) -> list[DrawingShape]:
    a, wide = finger.arm, 0.25 * finger.arm
    if finger.spring == "fixed":
        fixed = (a, 0.0, finger.height)
        post = ((a - wide, 0.0, finger.height), (a + wide, 0.0, finger.height))
        return [
            draw_bar("holder of the spring", 0.3 * wide, *post, kind="wall"),
            DrawingShape("spring", "spring", (fixed, turn_point(angle, a, 0.0)), 0.4 * wide),
        ]
    stretched = finger.extension + a * angle
    start, slim = -a * (3.0 + finger.highest), 0.4 * wide
    end = start + xp.maximum(2.0 * a + stretched, 0.5 * a)
    top, bottom = 0.5 * math.pi, 0.5 * math.pi - 0.4
    rim = [(x, 0.0, z) for x, z in trace_arc(a, top, bottom - xp.maximum(angle, -0.4), ARC)]
    axis = ((0.0, -wide, 0.0), (0.0, wide, 0.0))
    return [
        draw_bar("holder of the spring", slim, (start, 0.0, 0.0), (start, 0.0, a), kind="bracket"),
        DrawingShape("spring", "spring", ((start, 0.0, a), (end, 0.0, a)), slim),
        DrawingShape("thread", "tether", ((end, 0.0, a), *rim), 0.0),
        DrawingShape("drum", "pulley", axis, a, turn=angle),
    ]
