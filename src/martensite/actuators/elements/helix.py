"""Helical spring at large deflection: Kirchhoff's and Love's rod, ends held against rotation.

A helix of wire length l keeps its N turns, and thus the angle per length κ₀ = 2πN/l. With pitch angle a, length H = l
sin a and subscript 0 for the unloaded helix of the reference phase, the changes of curvature and twist are κ₀ (cos a -
cos a₀) and κ₀ (sin a - sin a₀). A transformation strain is a natural twist of the wire, dt_tr = 2 γ_tr/d:

    U = (l/2) { E I κ₀² (cos a - cos a₀)² + G J [κ₀ (sin a - sin a₀) - dt_tr]² }

F = dU/dH, written with the slope t = tan a, E I = (1 + ν) G J and w = F/(κ₀² E I), reads

    w = t cos a₀ - [ν sin a + sin a₀ + dt_tr/κ₀]/(1 + ν)

which is nearly linear in t. dF/dH has a closed form. For a flat spring (a₀ = 0) and small t it is the linear law F = G
d⁴ (H - H_tr)/(8 N D³).

Source: Love (1927), on thin rods bent into helices; the form in t and the natural twist are this package's.
"""

from typing import NamedTuple

from martensite.kernels.namespace import Namespace, Scalar

TURNS = 5
"""Newton steps from force to slope."""

HALVINGS = 4
"""Steps of Heron's rule."""


class Helix(NamedTuple):
    """Helix of one phase mixture."""

    length: Scalar
    """Length of the wire [m]."""
    angle: Scalar
    """Angle about the axis per wire length, κ₀ [rad/m]."""
    sine: Scalar
    """Sine of the unloaded pitch angle."""
    bending: Scalar
    """E I [N m²]."""
    poisson: Scalar
    """E/(2G) - 1 [-]."""
    twist: Scalar
    """Natural twist dt_tr [rad/m]."""

    def scale(self) -> Scalar:
        """Return κ₀² E I [N]."""
        return self.angle * self.angle * self.bending

    def cosine(self, xp: Namespace) -> Scalar:
        """Return the cosine of the unloaded pitch angle."""
        return xp.sqrt(1.0 - self.sine * self.sine)

    def natural(self) -> Scalar:
        """Return the contribution of unloaded pitch and natural twist to w [-]."""
        return (self.sine + self.twist / self.angle) / (1.0 + self.poisson)

    def slenderness(self) -> Scalar:
        """Return ν/(1 + ν) [-] = 1 - GJ/EI."""
        return self.poisson / (1.0 + self.poisson)


class HelixPoint(NamedTuple):
    """Point of the force–length curve."""

    length: Scalar
    """H [m]."""
    force: Scalar
    """[N]"""
    compliance: Scalar
    """dH/dF [m/N]."""


def compute_secant(slope: Scalar) -> Scalar:
    """Return √(1 + t²) for |t| ≤ 1 by Heron's rule, without a namespace."""
    square = 1.0 + slope * slope
    root = 0.5 * (1.0 + square)
    for _ in range(HALVINGS):
        root = 0.5 * (root + square / root)
    return root


def at_slope(xp: Namespace, helix: Helix, slope: Scalar) -> HelixPoint:
    """Return the point at a slope t of the pitch angle."""
    cosine = 1.0 / xp.sqrt(1.0 + slope * slope)
    sine, cubed = slope * cosine, cosine * cosine * cosine
    share, steep = helix.slenderness(), helix.cosine(xp)
    force = helix.scale() * (steep * slope - share * sine - helix.natural())
    rise = helix.scale() * (steep - share * cubed)
    return HelixPoint(helix.length * sine, force, helix.length * cubed / rise)


def at_length(xp: Namespace, helix: Helix, length: Scalar) -> HelixPoint:
    """Return the point at a length H [m] below the wire length."""
    sine = length / helix.length
    return at_slope(xp, helix, sine / xp.sqrt(1.0 - sine * sine))


def find_elastic_energy(xp: Namespace, helix: Helix, length: Scalar) -> Scalar:
    """Return U [J] at a length H [m] below the wire length."""
    sine = length / helix.length
    bent = xp.sqrt(1.0 - sine * sine) - helix.cosine(xp)
    twisted = sine - helix.sine - helix.twist / helix.angle
    square = bent * bent + twisted * twisted / (1.0 + helix.poisson)
    return 0.5 * helix.length * helix.scale() * square


def at_force(xp: Namespace, helix: Helix, force: Scalar) -> HelixPoint:
    """Return the point at a force [N], by Newton's method for the slope."""
    share, steep = helix.slenderness(), helix.cosine(xp)
    wanted = force / helix.scale() + helix.natural()
    slope = wanted / (steep - share)
    for _ in range(TURNS):
        cosine = 1.0 / xp.sqrt(1.0 + slope * slope)
        excess = slope * (steep - share * cosine) - wanted
        slope = slope - excess / (steep - share * cosine * cosine * cosine)
    return at_slope(xp, helix, slope)
