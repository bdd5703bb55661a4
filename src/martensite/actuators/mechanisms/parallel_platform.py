"""Parallel platform: a triangular plate on a universal joint, turned by springs at its vertices.

With the angles α about X and β about Y, the lengths L_i of `platform_kinematics` and the tension F_i of the spring at
vertex i, each spring is shorter by h - L_i than at home, and

    I α'' - … + b α' = -Σ F_i ∂L_i/∂α + M g e sin α cos β
    I (1 + sin² α) β'' + … + b β' = -Σ F_i ∂L_i/∂β + M g e cos α sin β

with the Coriolis and centrifugal terms … of `TopPlate`, the damping b of each axis of the joint, and the height e of
the plate's centroid over the joint: for e = 0 weight has no moment. The moment of inertia I about an axis in the plate
is by default M s²/24 of a uniform triangle. All three springs are assembled with the same preload; a spring without
tension is slack.

Source: Ranjith Pillai, Murali and Gopal (2018), eqs. 1 to 4, completed (see the errata in the documentation). Sign
convention: a positive α lowers the vertex on +Y, so it grows as the `first` spring pulls; a positive β lowers the
vertex of the `second`.
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanics.platform_kinematics import Plates, compute_lengths, locate_corners, locate_vertices
from martensite.actuators.mechanisms.base import MECHANISMS, Column, MechanicalEnergy
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_bar, lead_wire
from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp


@MECHANISMS.register("parallel-platform")
class ParallelPlatform(AbstractMultibody):
    """Plate on a universal joint that three springs tilt about two axes."""

    typical_scenario = "closed_loop_platform"

    cites = ("ranjith2018",)

    side: Number = param("m", "side s of the triangular plates", above=0.0, high=10.0, typical="100 mm")
    height: Number = param("m", "distance h of the plates at home", above=0.0, high=10.0, typical="50 mm")
    mass: Number = param("kg", "mass M of the top plate", above=0.0, high=1e6, typical="100 g")
    inertia: Number = param(
        "kg*m^2",
        "moment of inertia about an axis in the plate through its centroid; 0 for that of a uniform triangle, M s²/24",
        low=0.0,
        high=1e6,
        default=0.0,
    )
    eccentricity: Number = param(
        "m",
        "height e of the plate's centroid over the joint; 0 if the joint is there",
        low=-10.0,
        high=10.0,
        default=0.0,
        typical="-10 mm",
    )
    gravity: Number = param(
        "m/s^2",
        "acceleration of gravity towards the base; negative for a hanging platform",
        low=-100.0,
        high=100.0,
        default=9.80665,
    )
    damping: Number = param(
        "N*m*s/rad", "damping b of each axis of the joint", low=0.0, high=1e6, default=0.0, typical="1e-3 N*m*s/rad"
    )
    preload: Number = param("N", "force in all springs at assembly", low=0.0, high=1e6, default=0.0, typical="3 N")

    @override
    def check(self) -> None:
        if self.eccentricity > self.height:
            raise ParameterError(
                f"Parameter `eccentricity` of `parallel-platform` must be at most `height`, {1e3 * self.height:.6g} "
                f"mm, but is {1e3 * self.eccentricity:.6g} mm: the joint would be below the base."
            )

    def ports(self) -> tuple[str, ...]:
        """Return the springs at vertices 0 (on +Y), 1 (at -X) and 2 (at +X)."""
        return ("first", "second", "third")

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        return (
            Coordinate("alpha", "rad", "rotation about X", "α", 1.0),
            Coordinate("beta", "rad", "rotation about Y", "β", 1.0),
        )

    def plates(self) -> Plates:
        """Return the geometry."""
        return Plates(self.side, self.height, self.height - self.eccentricity)

    def top_plate(self, xp: Namespace) -> TopPlate:
        """Return the mass, moment of inertia and height over the joint of the moving plate."""
        plate = thin_plate(self.plates(), self.mass)
        given = self.inertia > 0.0
        return plate._replace(inertia=xp.where(given, self.inertia, plate.inertia))

    def plate_inertia(self) -> float:
        """Return the moment of inertia [kg m^2] of the top plate about an axis in it."""
        return self.top_plate(floats).inertia

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Return h - L_i [m]."""
        alpha, beta = position
        return [self.height - length for length in compute_lengths(xp, self.plates(), alpha, beta)]

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        (alpha, beta), rates = motion.position, AngleRates(*motion.velocity)
        plate, moving = self.top_plate(xp), (0.0, 0.0)
        if self.moves:
            moving = inertia_forces(xp, plate, alpha, rates, AngleRates(*motion.acceleration))
        weight = weight_torques(xp, plate, self.gravity, alpha, beta)
        return [inertia + self.damping * rate - pull for inertia, rate, pull in zip(moving, rates, weight, strict=True)]

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        (alpha, beta), plate = motion.position, self.top_plate(xp)
        lifted = weight_energy(xp, plate, self.gravity, alpha, beta)
        moved = kinetic_energy(xp, plate, alpha, AngleRates(*motion.velocity))
        return MechanicalEnergy(gravity=lifted, kinetic=moved)

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [self.preload] * 3

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Return both plates, the post of the joint, and the springs; z is up, -Z of the kinematics."""
        alpha, beta = reading.outputs["alpha"], reading.outputs["beta"]
        plates, thick = self.plates(), 0.012 * self.side
        base = tuple((x, -y, 0.0) for x, y in locate_corners(self.side))
        top = tuple((x, -y, -z) for x, y, z in locate_vertices(xp, plates, alpha, beta))
        joint = (0.0, 0.0, plates.pivot)
        x, y, z = (sum(v[k] for v in top) / 3.0 for k in range(3))
        shapes = [
            DrawingShape("base", "plate", base, thick),
            draw_bar("post", 1.5 * thick, (0.0, 0.0, 0.0), joint, kind="ground"),
            DrawingShape("joint", "object", (joint,), 2.5 * thick),
            draw_bar("neck", thick, joint, (x, y, z)),
            DrawingShape("plate", "plate", top, thick),
        ]
        for port, first, last in zip(self.ports(), base, top, strict=True):
            rest = reading.lengths[port] - self.height
            shapes += lead_wire(port, [first, last], rest, (0.0, 0.0, -1.0))
        return shapes


class TopPlate(NamedTuple):
    """Thin plate on a universal joint.

    The plate turns by α about X after β about Y (`platform_kinematics`), about a joint at the distance e = h - z_p
    below its centroid. In axes fixed to the plate its angular velocity is (α', β' cos α, -β' sin α), and its centroid
    has the squared velocity e² (α'² + β'² cos² α). A thin plate has I_z = 2 I, hence

        T = ½ A α'² + ½ (A + D sin² α) β'²,    A = I + M e²,    D = I - M e²
        Q_α = A α'' - D sin α cos α β'²
        Q_β = (A + D sin² α) β'' + 2 D sin α cos α α' β'

    For a uniform equilateral triangle I = M s²/24 about every in-plane axis through the centroid. The weight M g of a
    plate above its joint increases the tilt:

        Q_α = M g e sin α cos β,    Q_β = M g e cos α sin β

    Source: Lagrange's equations; the paper of Ranjith Pillai, Murali and Gopal (2018), eqs. 3 and 4, has one angle and
    an area moment. With the joint at the centroid e = 0 and A = D = I.
    """

    mass: Scalar
    """M [kg]"""
    inertia: Scalar
    """Moment of inertia about an in-plane axis through its centroid, I [kg m²]."""
    above: Scalar
    """Height of the centroid above the joint, e [m]; negative below it."""


class AngleRates(NamedTuple):
    """First or second time derivatives of both angles [rad/s] or [rad/s²]."""

    alpha: Scalar
    beta: Scalar


class Torques(NamedTuple):
    """Torques for the two angles [N m]."""

    alpha: Scalar
    beta: Scalar


def thin_plate(plates: Plates, mass: Scalar) -> TopPlate:
    """Return a uniform top plate of a mass [kg]: I = M s²/24, e = h - z_p."""
    inertia = mass * plates.side * plates.side * (1.0 / 24.0)
    return TopPlate(mass, inertia, plates.height - plates.pivot)


def inertia_forces(
    xp: Namespace, plate: TopPlate, alpha: Scalar, rates: AngleRates, accelerations: AngleRates
) -> Torques:
    """Return the torques [N m] of inertia, Coriolis and centrifugal terms; any β."""
    sine, cosine = xp.sin(alpha), xp.cos(alpha)
    least, more = _compute_moments(plate)
    turning = more * sine * cosine * rates.beta
    return Torques(
        least * accelerations.alpha - turning * rates.beta,
        (least + more * sine * sine) * accelerations.beta + 2.0 * turning * rates.alpha,
    )


def kinetic_energy(xp: Namespace, plate: TopPlate, alpha: Scalar, rates: AngleRates) -> Scalar:
    """Return T [J]."""
    sine = xp.sin(alpha)
    least, more = _compute_moments(plate)
    spin = (least + more * sine * sine) * rates.beta * rates.beta
    return 0.5 * (least * rates.alpha * rates.alpha + spin)


def weight_torques(xp: Namespace, plate: TopPlate, gravity: Scalar, alpha: Scalar, beta: Scalar) -> Torques:
    """Return the torques of the plate's weight [N m]; `gravity` [m/s²] is negative for a hanging platform."""
    moment = plate.mass * gravity * plate.above
    return Torques(moment * xp.sin(alpha) * xp.cos(beta), moment * xp.cos(alpha) * xp.sin(beta))


def weight_energy(xp: Namespace, plate: TopPlate, gravity: Scalar, alpha: Scalar, beta: Scalar) -> Scalar:
    """Return the potential energy of the plate's weight [J], 0 at home."""
    moment = plate.mass * gravity * plate.above
    return moment * (xp.cos(alpha) * xp.cos(beta) - 1.0)


def _compute_moments(plate: TopPlate) -> tuple[Scalar, Scalar]:
    """Return A and D [kg m²]."""
    shifted = plate.mass * plate.above * plate.above
    return plate.inertia + shifted, plate.inertia - shifted
