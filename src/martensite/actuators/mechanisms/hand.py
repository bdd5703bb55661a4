"""Hand: three fingers of two joints, with a flexor and an extensor at every joint.

The fingers `thumb`, `index` and `middle` differ in size only; each has a `proximal` and a `distal` joint with the
angles θ₁ and θ₂. A port is named after finger, joint and tendon, such as `index_distal_flexor`: twelve elements, such
as bundles of wires, each with its own drive.

Flexors are led through brackets on the inner side (bowstring, at r and g from the hinge), extensors over round knuckles
of radius ρ on the outer side, where a straight path would soon pass over the hinge:

    flexor   ΔL = 2 [r sin h + g (1 - cos h)],   h = θ/2        extensor   ΔL = -ρ θ

The brackets meet at θ = 2 φ with tan φ = g/r: put the upper end stop before it. With tendons `passing`, the distal
flexor runs over the proximal joint as in a human hand, and bends both: its path shortens by ΔL(θ₁) + ΔL(θ₂). The
elements act against joint springs k θ + τ₀, damping, end stops, and optionally the inertia of two uniform rods. Weight,
off by default, is that of hanging fingers; with `weight = "given"` it has a direction, and phalanges have centres of
mass, with uniform mass about them.

With `contact` the end stops are rigid (`stops`), and a fixed `cylinder` across all fingers is gripped
(`martensite.actuators.mechanics.complementarity`, `grasp`); contact forces push only. The hinges of the thumb have the
distance `span` from the others. The axis of the cylinder is given by its depth below the hinges and its offset from the
middle towards the thumb. Fingers do not touch each other.

All flexors are assembled with the same preload; the extensors balance it,

    ρ F_e = Σ r F_f - τ₀        (sum over the flexors that pass the joint)

A finger of size s has all lengths s times and masses s³ times as large. Fingers are independent. Sign convention:
angles grow in flexion, zero as assembled, with straight fingers.
"""

import math
from itertools import product

from martensite.actuators.mechanics.hand_drawing import drawn_hand
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms import grasp
from martensite.actuators.mechanisms.base import MECHANISMS, Column, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState
from martensite.actuators.mechanisms.joints import (
    Pair,
    Rod,
    find_kinetic_energy,
    find_stop_energy,
    find_weight_energy,
    hanging_rods,
    shorten_bowstring,
    stop_torque,
    two_rods,
)
from martensite.actuators.mechanisms.multibody import Coordinate
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column

FINGERS = ("thumb", "index", "middle")
JOINTS = ("proximal", "distal")
SIDES = ("flexor", "extensor")


@MECHANISMS.register("hand")
class Hand(grasp.AbstractGrasp):
    """Three fingers of two joints, bent and stretched by twelve elements."""

    typical_scenario = "hand"

    tendons: str = option(
        "which joints a distal flexor bends: its own, or the proximal one too (`passing`)",
        "separate",
        "passing",
        default="separate",
    )
    offset: Number = param("m", "distance r of a flexor from the hinge", above=0.0, high=1.0, typical="4 mm")
    bracket: Number = param(
        "m", "distance g of a bracket from the hinge, along the phalanx", low=0.0, high=1.0, typical="5 mm"
    )
    knuckle: Number = param("m", "radius ρ of the knuckle under an extensor", above=0.0, high=1.0, typical="5 mm")
    preload: Number = param("N", "force in every flexor at assembly", low=0.0, high=1e6, typical="2 N")
    stiffness: Number = param("N*m/rad", "joint spring rate", low=0.0, high=1e6, default=0.0, typical="2e-3 N*m/rad")
    torque: Number = param("N*m", "joint spring torque τ₀ at θ = 0", low=0.0, high=1e6, default=0.0, typical="1e-3 N*m")
    lowest: Number = param("rad", "lower end stop of a joint", low=-3.1, high=0.0, default=0.0, typical="-0.5 rad")
    highest: Number = param("rad", "upper end stop of a joint", above=0.0, high=3.1, default=1.6)
    stop: Number = param("N*m/rad", "stiffness of the end stops", low=0.0, high=1e6, default=10.0)
    damping: Number = param("N*m*s/rad", "damping of a joint", low=0.0, high=1e6, default=0.0, typical="2e-4 N*m*s/rad")
    proximal_length: Number = param("m", "length of a proximal phalanx", above=0.0, high=10.0, default=0.05)
    proximal_mass: Number = param("kg", "mass of a proximal phalanx", above=0.0, high=1e3, default=0.02)
    distal_length: Number = param("m", "length of a distal phalanx", above=0.0, high=10.0, default=0.04)
    distal_mass: Number = param("kg", "mass of a distal phalanx", above=0.0, high=1e3, default=0.01)
    gravity: Number = param(
        "m/s^2", "gravity along the straight fingers", low=0.0, high=100.0, default=0.0, typical="9.81 m/s^2"
    )
    thumb: Number = param("1", "size of the thumb", above=0.0, high=10.0, default=1.0, typical=0.9)
    index: Number = param("1", "size of the index finger", above=0.0, high=10.0, default=1.0)
    middle: Number = param("1", "size of the middle finger", above=0.0, high=10.0, default=1.0, typical=1.1)
    weight: str = option("uniform rods that hang, or as given", "hanging", "given", default="hanging")
    proximal_centre: Scalar = grasp.CENTRE
    distal_centre: Scalar = grasp.CENTRE
    tilt: Scalar = grasp.TILT
    contact: str = grasp.CONTACT
    thickness: Scalar = grasp.THICKNESS
    span: Number = param("m", "distance of the thumb's hinge from the others", low=0.0, high=10.0, default=0.08)
    cylinder_radius: Scalar = grasp.RADIUS
    cylinder_depth: Number = param("m", "axis of the cylinder, below the palm", low=-10.0, high=10.0, default=0.04)
    cylinder_aside: Number = param(
        "m", "axis of the cylinder, from the middle to the thumb", low=-10.0, high=10.0, default=0.0
    )

    @override
    def check(self) -> None:
        self.check_contact()
        lacking = -min(self.start_forces(floats))
        if lacking > 0.0:
            least = self.preload + lacking * self.knuckle / self.offset
            raise ParameterError(
                f"Parameter `preload` of `hand` must be at least {least:.4g} N, so that the "
                f"flexors hold the joint springs and the weight, but is {self.preload:.4g} N."
            )

    @override
    def cautions(self) -> list[str]:
        meet = 2.0 * math.atan2(self.bracket, self.offset)
        if self.bracket == 0.0 or meet >= self.highest:
            return []
        return [
            f"The brackets of the hand meet at {meet:.4g} rad, before its upper end stop at "
            f"{self.highest:.4g} rad; the fingers are bent on as if they did not."
        ]

    def sizes(self) -> tuple[Scalar, ...]:
        """Return the relative sizes of the fingers."""
        return self.thumb, self.index, self.middle

    def ports(self) -> tuple[str, ...]:
        """Return the flexor and extensor of each joint, such as `thumb_proximal_flexor`."""
        return tuple("_".join(words) for words in product(FINGERS, JOINTS, SIDES))

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        words = product(FINGERS, JOINTS)
        return tuple(
            Coordinate(f"{one}_{joint}", "rad", f"angle of the {joint} joint, {one}", "θ", 1.0) for one, joint in words
        )

    @override
    def contraction(self, xp: Namespace, position: Column) -> Column:
        lengths: list[Scalar] = []
        for i, size in enumerate(self.sizes()):
            bent = [
                size * shorten_bowstring(xp, angle, self.offset, self.bracket) for angle in position[2 * i : 2 * i + 2]
            ]
            if self.tendons == "passing":
                bent[1] = bent[0] + bent[1]
            for flexed, angle in zip(bent, position[2 * i : 2 * i + 2], strict=True):
                lengths += [flexed, -(size * self.knuckle) * angle]
        return lengths

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        torques: list[Scalar] = []
        for i, size in enumerate(self.sizes()):
            angles, rates, accelerations = (_select_pair(numbers, i) for numbers in motion)
            rods = self._rods(size)
            hung = hanging_rods(xp, *rods, self._lean(i, angles), self.gravity)
            moved = two_rods(xp, *rods, angles, rates, accelerations) if self.moves else (0.0, 0.0)
            for k in range(2):
                torques.append(self._hold_joint(xp, angles[k], rates[k]) + hung[k] + moved[k])
        return torques

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        springs = sum_column([self._spring_energy(xp, angle) for angle in motion.position])
        lifted, moved = list[Scalar](), list[Scalar]()
        for i, size in enumerate(self.sizes()):
            rods, angles = self._rods(size), _select_pair(motion.position, i)
            lifted.append(find_weight_energy(xp, *rods, self._lean(i, angles), self.gravity))
            moved.append(find_kinetic_energy(xp, *rods, angles, _select_pair(motion.velocity, i)))
        return MechanicalEnergy(springs, sum_column(lifted), sum_column(moved))

    @override
    def start_forces(self, xp: Namespace) -> Column:
        forces: list[Scalar] = []
        both = 2.0 if self.tendons == "passing" else 1.0
        for i, size in enumerate(self.sizes()):
            leaning = self._lean(i, (0.0, 0.0))
            hung = hanging_rods(xp, *self._rods(size), leaning, self.gravity) if self.weight == "given" else leaning
            for flexors, lifted in zip((both, 1.0), hung, strict=True):
                moment = flexors * self.offset * self.preload - (self.torque + lifted) * (1.0 / size)
                forces += [self.preload, moment * (1.0 / self.knuckle)]
        return forces

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        return drawn_hand(self, reading)

    @override
    def locate_contacts(self, xp: Namespace, position: Column) -> list[grasp.Touch]:
        touches: list[grasp.Touch] = []
        for i, size in enumerate(self.sizes()):
            inwards = 0.5 * self.span + (-self.cylinder_aside if i == 0 else self.cylinder_aside)
            axis, reach = (self.cylinder_depth, inwards), self.cylinder_radius + 0.5 * size * self.thickness
            lengths = size * self.proximal_length, size * self.distal_length
            touches += grasp.find_touches(xp, axis, reach, lengths, _select_pair(position, i))
        return touches

    def _lean(self, finger: int, angles: Pair) -> Pair:
        """Return the angles of a finger relative to gravity."""
        if self.weight == "hanging":
            return angles
        return angles[0] + (self.tilt if finger == 0 else -self.tilt), angles[1]

    def _rods(self, size: Scalar) -> tuple[Rod, Rod]:
        heavier = size * size * size
        if self.weight == "given":
            near, far = self.proximal_centre, self.distal_centre
            return (
                Rod(size * self.proximal_length, heavier * self.proximal_mass, near, 1.0 / 12.0 + near * near),
                Rod(size * self.distal_length, heavier * self.distal_mass, far, 1.0 / 12.0 + far * far),
            )
        return (
            Rod(size * self.proximal_length, heavier * self.proximal_mass),
            Rod(size * self.distal_length, heavier * self.distal_mass),
        )

    def _hold_joint(self, xp: Namespace, angle: Scalar, rate: Scalar) -> Scalar:
        rigid = self.contact != "springs"
        stop = 0.0 if rigid else stop_torque(xp, angle, self.lowest, self.highest, self.stop)
        return self.torque + self.stiffness * angle + stop + self.damping * rate

    def _spring_energy(self, xp: Namespace, angle: Scalar) -> Scalar:
        """Return the energy of spring and stops of a joint [J]."""
        rigid = self.contact != "springs"
        stop = 0.0 if rigid else find_stop_energy(xp, angle, self.lowest, self.highest, self.stop)
        return (self.torque + 0.5 * self.stiffness * angle) * angle + stop


def _select_pair(numbers: Column, finger: int) -> Pair:
    return numbers[2 * finger], numbers[2 * finger + 1]
