"""Kinematics of a platform: two triangular plates, a universal joint, three legs.

The base frame has its origin at the centroid of the base plate and Z pointing down, towards the base: the top plate is
at home at z = -h. Both plates are equal equilateral triangles of side s with the vertices

    A₀ = (0, r, 0),    A₁ = (-s/2, -r/2, 0),    A₂ = (s/2, -r/2, 0),    r = s/√3

The plate turns by α about X, then by β about Y, R = R_Y(β) R_X(α), about a joint z_p above the base. The leg from
vertex i of the base to vertex i of the plate is

    l_i = p + R (A_i + u) - A_i,    p = (0, 0, -z_p),    u = (0, 0, -(h - z_p)),    L_i = |l_i|.

A positive α lowers vertex 0 and shortens leg 0; a positive β lowers vertex 1. The pulls F_i turn the plate with Q = -Jᵀ
F, J = ∂L/∂(α, β). Three lengths determine two angles by least squares; a residual indicates lengths without a posture,
such as three equal contractions.

Source: Ranjith Pillai, Murali and Gopal (2018), eqs. 1 to 3, including what eq. 2 omits: the distance h of the plates,
and that the length of a leg is the norm of its vector. The order of the two rotations is theirs.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from martensite.base.errors import ParameterError, SolveError
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column

CORRECTIONS = 40
"""Largest number of Gauss–Newton steps; lengths of a posture need up to 7."""
SETTLED = 1e-11
"""Correction that ends the search [rad]."""
SINGULAR = 1e-12
"""Smallest usable determinant, relative to the square of its trace."""
LEAST_LENGTH = 1e-9
"""Length of a leg below which its direction is undefined [m]."""
ALLOWED = 0.01
"""Largest residual of consistent lengths, relative to the distance of the plates."""


class Plates(NamedTuple):
    """Two equal triangular plates, and the joint between them."""

    side: Scalar
    """Side of the triangles, s [m]."""
    height: Scalar
    """Distance of the plates at home, h [m]."""
    pivot: Scalar
    """Height of the universal joint above the base, z_p [m]; `height` if it is in the top plate."""


class Tilt(NamedTuple):
    """Posture from three lengths."""

    alpha: float
    """Rotation about X [rad]."""
    beta: float
    """Rotation about Y [rad]."""
    residual: float
    """Root of the sum of squared length errors [m], with one degree of freedom."""


# ---------------------------------------------------------------- kernels


def locate_corners(side: Scalar) -> list[tuple[Scalar, Scalar]]:
    """Return X and Y of the three vertices [m]."""
    radius = side * (1.0 / math.sqrt(3.0))
    return [(0.0, radius), (-0.5 * side, -0.5 * radius), (0.5 * side, -0.5 * radius)]


def compute_lengths(xp: Namespace, plates: Plates, alpha: Scalar, beta: Scalar) -> list[Scalar]:
    """Return the lengths of the three legs [m] at angles [rad]."""
    return compute_length_slopes(xp, plates, alpha, beta)[0]


def compute_length_slopes(
    xp: Namespace, plates: Plates, alpha: Scalar, beta: Scalar
) -> tuple[list[Scalar], list[Scalar], list[Scalar]]:
    """Return the lengths [m], and their derivatives over α and β [m/rad]."""
    turns = xp.cos(alpha), xp.sin(alpha), xp.cos(beta), xp.sin(beta)
    _, _, cb, sb = turns
    lengths: list[Scalar] = []
    over_alpha: list[Scalar] = []
    over_beta: list[Scalar] = []
    for x, y in locate_corners(plates.side):
        across, along, down, drop = _turn_vertex(plates, turns, x, y)
        leg_x, leg_y, leg_z = across - x, along - y, down - plates.pivot
        length = xp.sqrt(leg_x * leg_x + leg_y * leg_y + leg_z * leg_z)
        share = 1.0 / xp.maximum(length, LEAST_LENGTH)
        lengths.append(length)
        over_alpha.append(share * ((sb * leg_x + cb * leg_z) * along - leg_y * drop))
        over_beta.append(share * (leg_x * down - leg_z * across))
    return lengths, over_alpha, over_beta


def locate_vertices(xp: Namespace, plates: Plates, alpha: Scalar, beta: Scalar) -> list[tuple[Scalar, Scalar, Scalar]]:
    """Return X, Y, Z of the vertices of the moving plate [m] at angles [rad]."""
    turns = xp.cos(alpha), xp.sin(alpha), xp.cos(beta), xp.sin(beta)
    places = [_turn_vertex(plates, turns, x, y) for x, y in locate_corners(plates.side)]
    return [(across, along, down - plates.pivot) for across, along, down, _ in places]


def _turn_vertex(
    plates: Plates, turns: tuple[Scalar, Scalar, Scalar, Scalar], x: Scalar, y: Scalar
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return a vertex after both rotations, relative to the joint: X, Y, Z; and Z after the first rotation."""
    ca, sa, cb, sb = turns
    above = plates.height - plates.pivot
    drop, along = sa * y - ca * above, ca * y + sa * above
    return cb * x + sb * drop, along, cb * drop - sb * x, drop


def correct_angles(
    xp: Namespace, plates: Plates, wanted: Sequence[Scalar], alpha: Scalar, beta: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the correction of both angles [rad] towards three lengths [m], by one Gauss–Newton step.

    A fixed number of steps is an observer of the posture; near the solution each step squares the error.
    """
    lengths, a, b = compute_length_slopes(xp, plates, alpha, beta)
    off = [w - f for w, f in zip(wanted, lengths, strict=True)]
    aa, ab, bb = _multiply_dot(a, a), _multiply_dot(a, b), _multiply_dot(b, b)
    right_a, right_b = _multiply_dot(a, off), _multiply_dot(b, off)
    least = SINGULAR * (aa + bb) * (aa + bb) + 1e-300
    share = 1.0 / xp.maximum(aa * bb - ab * ab, least)
    return share * (bb * right_a - ab * right_b), share * (aa * right_b - ab * right_a)


def _multiply_dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    return sum_column([x * y for x, y in zip(a, b, strict=True)])


# ---------------------------------------------------------------- edge


def platform_lengths(plates: Plates, alpha: float, beta: float) -> tuple[float, float, float]:
    """Return the lengths of the three legs of a platform: inverse kinematics.

    Args:
        plates: geometry.
        alpha: rotation about X [rad].
        beta: rotation about Y [rad], after the rotation about X.

    Returns:
        Lengths [m] of legs 0, 1 and 2; leg 0 is at +Y.

    Raises:
        ParameterError: the geometry or an angle is invalid.
    """
    check_plates(plates)
    check_number("angle `alpha`", alpha)
    check_number("angle `beta`", beta)
    first, second, third = compute_lengths(floats, plates, alpha, beta)
    return first, second, third


def platform_angles(plates: Plates, wanted: Sequence[float], allowed: float | None = None) -> Tilt:
    """Return the angles at which the legs of a platform have given lengths: forward kinematics.

    Least squares by Gauss–Newton steps with exact derivatives from the home posture. Lengths may belong to two
    postures, one of them beyond the turning point of a leg (46° for leg 0 at s = 100 mm, h = 60 mm); the nearer one is
    returned.

    Args:
        plates: geometry.
        wanted: three lengths [m].
        allowed: largest residual [m]; by default 1 % of the distance of the plates, `math.inf` for the best fit to any
            lengths.

    Returns:
        Both angles [rad] and the residual [m].

    Raises:
        ParameterError: the geometry or a length is invalid, or the lengths belong to no posture.
        SolveError: the iteration did not converge, as may happen far from every posture.
    """
    check_plates(plates)
    if len(wanted) != 3:
        raise ParameterError(f"A platform has three legs, but {len(wanted)} lengths were given.")
    for i, length in enumerate(wanted):
        check_number(f"length of leg {i}", length, positive=True)
    alpha, beta = _settle_angles(plates, wanted)
    nearest = compute_lengths(floats, plates, alpha, beta)
    residual = math.dist(nearest, wanted)
    limit = ALLOWED * plates.height if allowed is None else allowed
    if not residual <= limit:
        raise ParameterError(
            f"The lengths {format_millimetres(wanted)} belong to no posture: the nearest found has "
            f"{format_millimetres(nearest)}, a residual of {1e3 * residual:.3g} mm, where "
            f"{1e3 * limit:.3g} mm are allowed. Pass a larger `allowed` for the best fit."
        )
    return Tilt(alpha, beta, residual)


def _settle_angles(plates: Plates, wanted: Sequence[float]) -> tuple[float, float]:
    alpha = beta = 0.0
    for _ in range(CORRECTIONS):
        more_alpha, more_beta = correct_angles(floats, plates, wanted, alpha, beta)
        alpha, beta = alpha + more_alpha, beta + more_beta
        if max(abs(more_alpha), abs(more_beta)) <= SETTLED:
            return alpha, beta
    raise SolveError(
        f"No posture was found for the lengths {format_millimetres(wanted)}: {CORRECTIONS} corrections did not settle. "
        "Check that the legs can be so long at once: `platform_lengths` tells their lengths at any angles."
    )


def check_plates(plates: Plates) -> None:
    """Raise `ParameterError` unless side and height are positive and all values finite."""
    check_number("`side` of the plates", plates.side, positive=True)
    check_number("`height` of the plates", plates.height, positive=True)
    check_number("`pivot` of the plates", plates.pivot)


def check_number(name: str, value: float, *, positive: bool = False) -> None:
    """Raise `ParameterError` unless a number is finite, and above 0 if `positive`."""
    if not math.isfinite(value) or (positive and value <= 0.0):
        allowed = "finite and above 0" if positive else "finite"
        raise ParameterError(f"The {name} must be {allowed}, but is {value:g}.")


def format_millimetres(values: Sequence[float]) -> str:
    """Return lengths [m] as text in mm."""
    return ", ".join(f"{1e3 * value:.4g}" for value in values) + " mm"
