"""Hinges with tendons: paths, end stops, and the inertia of two links in series.

A tendon led through holes at (∓g, -r) on both sides of a hinge has the straight path of a bowstring. Bent by θ it is
shorter by

    ΔL(θ) = 2 [r sin h + g (1 - cos h)],        dΔL/dθ = r cos h + g sin h,        h = θ/2

The plane inertia of two links of lengths l₁ and l₂, uniform rods of masses m₁ and m₂ with the relative angles θ₁ and
θ₂, is, with d = m₂ l₂²/3, b = m₂ l₁ l₂/2 and a = m₁ l₁²/3 + m₂ l₁² + d,

    τ₁ = (a + 2 b cos θ₂) θ₁'' + (d + b cos θ₂) θ₂'' - b sin θ₂ (2 θ₁' + θ₂') θ₂'
    τ₂ = (d + b cos θ₂) θ₁'' + d θ₂'' + b sin θ₂ θ₁'²

A link with its centre of mass at the fraction κ of its length, uniform about it, has κ in place of 1/2 and 1/12 + κ² in
place of 1/3. Sign convention: angles grow as the tendon pulls. Textbook results.
"""

from typing import NamedTuple

from martensite.kernels.namespace import Namespace, Scalar

Pair = tuple[Scalar, Scalar]
"""A value for each of two joints in series."""


def shorten_bowstring(xp: Namespace, angle: Scalar, offset: Scalar, bracket: Scalar) -> Scalar:
    """Return ΔL [m] of a tendon with r = `offset` and g = `bracket` [m]."""
    h = 0.5 * angle
    return 2.0 * (offset * xp.sin(h) + bracket * (1.0 - xp.cos(h)))


def bowstring_arm(xp: Namespace, angle: Scalar, offset: Scalar, bracket: Scalar) -> Scalar:
    """Return dΔL/dθ [m], the moment arm of the same tendon."""
    h = 0.5 * angle
    return offset * xp.cos(h) + bracket * xp.sin(h)


def stop_torque(xp: Namespace, angle: Scalar, lowest: Scalar, highest: Scalar, stiffness: Scalar) -> Scalar:
    """Return the torque [N m] of end stops: a stiff spring outside of the range [rad]."""
    past = xp.maximum(angle - highest, 0.0) + xp.minimum(angle - lowest, 0.0)
    return stiffness * past


def find_stop_energy(xp: Namespace, angle: Scalar, lowest: Scalar, highest: Scalar, stiffness: Scalar) -> Scalar:
    """Return the energy [J] of end stops."""
    past = xp.maximum(angle - highest, 0.0) + xp.minimum(angle - lowest, 0.0)
    return 0.5 * stiffness * past * past


class Rod(NamedTuple):
    """Link of a length [m] and a mass [kg]."""

    length: Scalar
    mass: Scalar
    centre: Scalar = 0.5
    """Centre of mass as a fraction of the length."""
    spread: Scalar = 1.0 / 3.0
    """Moment of inertia about its hinge, in m l²."""


def two_rods(xp: Namespace, first: Rod, second: Rod, angles: Pair, rates: Pair, accelerations: Pair) -> Pair:
    """Return the torques [N m] that accelerate two links in series."""
    end = second.mass * second.length * second.length * second.spread
    across = second.centre * second.mass * first.length * second.length
    base = (first.mass * first.spread + second.mass) * first.length * first.length + end
    c, s = across * xp.cos(angles[1]), across * xp.sin(angles[1])
    (v1, v2), (a1, a2) = rates, accelerations
    near = (base + 2.0 * c) * a1 + (end + c) * a2 - s * (2.0 * v1 + v2) * v2
    return near, (end + c) * a1 + end * a2 + s * v1 * v1


def hanging_rods(xp: Namespace, first: Rod, second: Rod, angles: Pair, gravity: Scalar) -> Pair:
    """Return the torques [N m] that hold two links against their weight; they hang down at angles zero."""
    far = second.centre * second.mass * second.length * xp.sin(angles[0] + angles[1])
    near = (first.centre * first.mass + second.mass) * first.length * xp.sin(angles[0])
    return gravity * (near + far), gravity * far


def find_kinetic_energy(xp: Namespace, first: Rod, second: Rod, angles: Pair, rates: Pair) -> Scalar:
    """Return the kinetic energy [J] of two links in series."""
    end = second.mass * second.length * second.length * second.spread
    across = second.centre * second.mass * first.length * second.length * xp.cos(angles[1])
    base = (first.mass * first.spread + second.mass) * first.length * first.length
    near, both = rates[0], rates[0] + rates[1]
    return 0.5 * (base * near * near + end * both * both) + across * near * both


def find_weight_energy(xp: Namespace, first: Rod, second: Rod, angles: Pair, gravity: Scalar) -> Scalar:
    """Return the potential energy [J] of two links; zero when they hang down at angles zero."""
    far = second.centre * second.mass * second.length * (1.0 - xp.cos(angles[0] + angles[1]))
    near = (first.centre * first.mass + second.mass) * first.length * (1.0 - xp.cos(angles[0]))
    return gravity * (near + far)
