r"""Inertia and weight of the top plate of a platform, in its two angles α and β.

The plate turns by α about X after β about Y (`platform_kinematics`), about a joint that its
centroid stands e = h - z_p above. In axes fixed to the plate its angular velocity is
(α', β' cos α, -β' sin α), and its centroid moves with the square velocity
e² (α'² + β'² cos² α). A thin plate has I_z = 2 I, hence

    T = ½ A α'² + ½ (A + D sin² α) β'²,    A = I + M e²,    D = I - M e²

    Q_α = A α'' - D sin α cos α β'²
    Q_β = (A + D sin² α) β'' + 2 D sin α cos α α' β'

For a uniform equilateral triangle I = M s²/24 about every axis in its plane through the
centroid. The weight M g of a plate above its joint turns it further over:

    Q_α = M g e sin α cos β,    Q_β = M g e cos α sin β

Source: Lagrange's equations; the paper of Ranjith Pillai, Murali and Gopal (2018), eqs. 3 and 4,
has one angle and an area moment. With the joint at the centroid e = 0 and A = D = I.
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.actuators.mechanics.platform_kinematics import Plates
from martensite.kernels.namespace import Namespace, Scalar


class TopPlate(NamedTuple):
    """A thin plate on a universal joint."""

    mass: Scalar
    """M [kg]"""
    inertia: Scalar
    """Moment of inertia about an axis in the plate through its centroid, I [kg m²]."""
    above: Scalar
    """Of the centroid over the joint, e [m]; negative below it."""


class AngleRates(NamedTuple):
    """First or second derivatives of both angles over time."""

    alpha: Scalar
    """[rad/s] or [rad/s²]"""
    beta: Scalar
    """[rad/s] or [rad/s²]"""


class Torques(NamedTuple):
    """What belongs to the two angles."""

    alpha: Scalar
    """[N m]"""
    beta: Scalar
    """[N m]"""


def thin_plate(plates: Plates, mass: Scalar) -> TopPlate:
    """A uniform top plate of a mass [kg]: I = M s²/24, e = h - z_p."""
    inertia = mass * plates.side * plates.side * (1.0 / 24.0)
    return TopPlate(mass, inertia, plates.height - plates.pivot)


def inertia_forces(
    xp: Namespace, plate: TopPlate, alpha: Scalar, rates: AngleRates, accelerations: AngleRates
) -> Torques:
    """Torques [N m] that a motion takes: inertia, Coriolis and centrifugal terms; any β."""
    sine, cosine = xp.sin(alpha), xp.cos(alpha)
    least, more = _compute_moments(plate)
    turning = more * sine * cosine * rates.beta
    return Torques(
        least * accelerations.alpha - turning * rates.beta,
        (least + more * sine * sine) * accelerations.beta + 2.0 * turning * rates.alpha,
    )


def compute_accelerations(
    xp: Namespace, plate: TopPlate, alpha: Scalar, rates: AngleRates, applied: Torques
) -> AngleRates:
    """Angular accelerations [rad/s²] under applied torques [N m]: the inverse of the above."""
    sine = xp.sin(alpha)
    least, more = _compute_moments(plate)
    own = inertia_forces(xp, plate, alpha, rates, AngleRates(0.0, 0.0))
    return AngleRates((applied.alpha - own.alpha) / least, (applied.beta - own.beta) / (least + more * sine * sine))


def kinetic_energy(xp: Namespace, plate: TopPlate, alpha: Scalar, rates: AngleRates) -> Scalar:
    """T [J]."""
    sine = xp.sin(alpha)
    least, more = _compute_moments(plate)
    spin = (least + more * sine * sine) * rates.beta * rates.beta
    return 0.5 * (least * rates.alpha * rates.alpha + spin)


def weight_torques(xp: Namespace, plate: TopPlate, gravity: Scalar, alpha: Scalar, beta: Scalar) -> Torques:
    """Torques of the plate's weight [N m]; `gravity` [m/s²] is negative for a hanging platform."""
    moment = plate.mass * gravity * plate.above
    return Torques(moment * xp.sin(alpha) * xp.cos(beta), moment * xp.cos(alpha) * xp.sin(beta))


def weight_energy(xp: Namespace, plate: TopPlate, gravity: Scalar, alpha: Scalar, beta: Scalar) -> Scalar:
    """Energy of the plate's weight [J], 0 at home: what its torques are less the slopes of."""
    moment = plate.mass * gravity * plate.above
    return moment * (xp.cos(alpha) * xp.cos(beta) - 1.0)


def _compute_moments(plate: TopPlate) -> tuple[Scalar, Scalar]:
    """A and D [kg m²]."""
    shifted = plate.mass * plate.above * plate.above
    return plate.inertia + shifted, plate.inertia - shifted
