"""Smooth hardening: the part of a transformation range that corresponds to a martensite fraction.

    h(ξ) = ½ [1 + ξ^m - (1 - ξ)^n],      0 < m, n ≤ 1,      h(0) = 0, h(1) = 1

For m = n = 1 it is h = ξ; smaller exponents round the corners at the start (m) and at the end (n), where the slope of h
is infinite. The inversion avoids that singularity by logarithms. Below ξ = ½ it solves, with u = ln x and x = ξ,

    ln[x^m + 1 - (1 - x)^n] = ln 2h,

above ξ = ½ the same equation for x = 1 - ξ, with exchanged exponents and 1 - h. The left side is the logarithm of a sum
of powers of x with positive factors, so it is convex in u, and nearly straight. One or two of Halley's steps come near
the root, and a last step reaches rounding for exponents from 0.05 to 1. Only the last step is differentiated, which
gives the slopes of the root. Source: Hartl and Lagoudas, in Lagoudas et al. (2012), Int. J. Plasticity 32–33; the
inversion is this package's.

The waist contracts the middle of a range: with y = 2h - 1, from -1 to 1,

    y_w = (1 - b) y + b y³,     h_w = ½ (1 + y_w),     0 ≤ b < 1

keeps both ends. In the middle h_w rises 1 - b times as fast as h, at the ends 1 + 2b times: most of the fraction
changes within a narrow part of the range, between long tails. b = 0 gives h. The mean of y³ over all fractions, for the
energy of hardening, is a sum of beta functions.

The inverse is the one real root of the cubic, in the hyperbolic form of Cardano's solution without cancellation and
without division by b,

    y = 3 y_w/[(1 - b)(1 + u² + u⁻²)],    u³ = s + √(1 + s²),    s² = 27 b y_w²/[4 (1 - b)³] .

Its slopes come from one step of Newton's method, bounded also at b = 0. Source: an unpublished extension of this
package.
"""

import math

from martensite.kernels.namespace import Namespace, Scalar

LEAST_EXPONENT = 0.05
MOST_ITERATIONS = 8
NEAR = 1e-2
"""Step in ln x after which one more step reaches rounding; a step cubes the error."""
NOTHING = 1e-60
"""Bases below this value count as 0: their logarithm has no bounded slope."""


def raise_positive(xp: Namespace, base: Scalar, exponent: Scalar) -> Scalar:
    """Return `base` to a positive power; 0 for bases that are not positive."""
    safe = xp.exp(exponent * xp.log(xp.maximum(base, NOTHING)))
    return xp.where(base > NOTHING, safe, 0.0)


def compute_hardening(xp: Namespace, fraction: Scalar, start: Scalar, end: Scalar) -> Scalar:
    """Return h(ξ) [-] with the exponents at start and end of the range."""
    left = raise_positive(xp, 1.0 - fraction, end)
    return 0.5 * (1.0 + raise_positive(xp, fraction, start) - left)


def hardening_integral(xp: Namespace, fraction: Scalar, start: Scalar, end: Scalar) -> Scalar:
    """Return an antiderivative of h over ξ [-]."""
    rest = 1.0 - fraction
    left = rest * raise_positive(xp, rest, end) / (end + 1.0)
    return 0.5 * (fraction + fraction * raise_positive(xp, fraction, start) / (start + 1.0) + left)


def invert_hardening(xp: Namespace, share: Scalar, start: Scalar, end: Scalar) -> Scalar:
    """Return the fraction ξ with h(ξ) = share, limited to [0, 1]. Shares up to 0 and from 1 need no iterations."""
    share = xp.clip(share, 0.0, 1.0)
    below = share < compute_hardening(xp, 0.5, start, end)
    near, far = xp.where(below, start, end), xp.where(below, end, start)
    twice = 2.0 * xp.where(below, share, 1.0 - share)
    some = twice > NOTHING
    goal = xp.log(xp.where(some, twice, 1.0))
    fixed = xp.detach(goal), xp.detach(near), xp.detach(far)

    def turn(_: Scalar, u: Scalar) -> tuple[Scalar, Scalar]:
        better = xp.minimum(_improve_logarithm(xp, u, *fixed), LOG_HALF)
        return xp.abs(better - u) - NEAR, better

    begin = xp.minimum(xp.minimum(fixed[0] / fixed[1], fixed[0] - xp.log(fixed[2])), LOG_HALF)
    u = xp.iterate(MOST_ITERATIONS, turn, xp.where(some, 1.0, 0.0), begin)[1]
    part = xp.where(some, xp.exp(_improve_logarithm(xp, u, goal, near, far)), 0.0)
    return xp.where(below, part, 1.0 - part)


def _improve_logarithm(xp: Namespace, u: Scalar, goal: Scalar, near: Scalar, far: Scalar) -> Scalar:
    """Return ln x after one of Halley's steps, at most twice or half as long as Newton's."""
    x, power = xp.exp(u), xp.exp(near * u)
    left = 1.0 - x
    rest = xp.exp(far * xp.log(left))
    odds = x / left
    other = far * rest * odds
    total = power + (1.0 - rest)
    per = 1.0 / total
    slope = (near * power + other) * per
    bend = (near * near * power + other * (1.0 + (1.0 - far) * odds)) * per - slope * slope
    newton = (xp.log(total) - goal) / slope
    return u - newton / xp.clip(1.0 - 0.5 * newton * bend / slope, 0.5, 2.0)


MOST_WAIST = 0.98
"""Largest b; there the middle is fifty times as steep as without a waist."""
LOG_HALF = math.log(0.5)
HALF_LOG = 0.5 * math.log(2.0 * math.pi)
SHIFT = 6
"""Steps to the range where Stirling's series of four terms is accurate to 3e-11."""


def apply_waist(share: Scalar, waist: Scalar) -> Scalar:
    """Return h_w [-] of h = `share`, with b = `waist`."""
    y = 2.0 * share - 1.0
    return 0.5 + 0.5 * y * (1.0 - waist + waist * y * y)


def remove_waist(xp: Namespace, share: Scalar, waist: Scalar) -> Scalar:
    """Return the h [-] with h_w = share, limited to [0, 1]."""
    share = xp.clip(share, 0.0, 1.0)
    wanted = 2.0 * share - 1.0
    root = _find_waist_root(xp, xp.detach(wanted), xp.detach(waist))
    rest = root * (1.0 - waist + waist * root * root) - wanted
    slope = xp.detach(1.0 - waist + 3.0 * waist * root * root)
    y = xp.clip(xp.implicit_root(root, root - rest / slope), -1.0, 1.0)
    return xp.where(xp.abs(wanted) < 1.0, 0.5 + 0.5 * y, share)


def _find_waist_root(xp: Namespace, wanted: Scalar, waist: Scalar) -> Scalar:
    """Return y of the module's equations, without its slopes."""
    thin = 1.0 - waist
    s = xp.abs(wanted) * xp.sqrt(6.75 * waist / (thin * thin * thin))
    u = xp.exp(2.0 / 3.0 * xp.log(s + xp.sqrt(1.0 + s * s)))
    return 3.0 * wanted / (thin * (1.0 + u + 1.0 / u))


def waist_energy(xp: Namespace, start: Scalar, end: Scalar) -> Scalar:
    """Return ∫ (y³ - y) dξ [-] over all fractions; b times this value is added to 2 ∫ h dξ.

    Args:
        xp: namespace.
        start: exponent m of h at the start.
        end: exponent n at the end.
    """
    cross = _compute_beta(xp, start + 1.0, 2.0 * end + 1.0) - _compute_beta(xp, 2.0 * start + 1.0, end + 1.0)
    cube = 1.0 / (3.0 * start + 1.0) - 1.0 / (3.0 * end + 1.0) + 3.0 * cross
    return cube - 1.0 / (start + 1.0) + 1.0 / (end + 1.0)


def _compute_beta(xp: Namespace, a: Scalar, b: Scalar) -> Scalar:
    """Return Euler's beta function for arguments from 1."""
    return xp.exp(_log_gamma(xp, a) + _log_gamma(xp, b) - _log_gamma(xp, a + b) + HALF_LOG)


def _log_gamma(xp: Namespace, x: Scalar) -> Scalar:
    """Return ln Γ(x) - ½ ln 2π for x from 1, by Stirling's series and recursion."""
    product = x
    for k in range(1, SHIFT):
        product = product * (x + k)
    z = x + SHIFT
    q = 1.0 / (z * z)
    series = (1.0 / 12.0 - q * (1.0 / 360.0 - q * (1.0 / 1260.0 - q / 1680.0))) / z
    return (z - 0.5) * xp.log(z) - z + series - xp.log(product)
