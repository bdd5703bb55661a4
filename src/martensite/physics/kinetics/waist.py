r"""The waist: a cubic that draws the middle of a transformation range together.

With the share h of smooth hardening and y = 2h - 1, which runs from -1 to 1,

    y_w = (1 - b) y + b y³,     h_w = ½ (1 + y_w),     0 ≤ b < 1

keeps both ends. In the middle h_w rises 1 - b times as fast as h, at the ends 1 + 2b times: most
of the fraction changes within a narrow part of the range, between long tails. b = 0 is h itself.
The mean of y³ over all fractions, for the energy of hardening, is a sum of beta functions.

The inverse is the one real root of the cubic. With the hyperbolic form of Cardano's solution,
rearranged so that nothing cancels and nothing is divided by b,

    y = 3 y_w/[(1 - b)(1 + u² + u⁻²)],    u³ = s + √(1 + s²),    s² = 27 b y_w²/[4 (1 - b)³] .

Its slopes are those of a step of Newton's method from there, which are bounded also at b = 0.

Source: this package's own extension; it is not published. The root is Cardano's.
"""

from __future__ import annotations

import math

from martensite.kernels.namespace import Namespace, Scalar

MOST = 0.98
"""Largest b: there the middle is fifty times as steep as without a waist."""
HALF_LOG = 0.5 * math.log(2.0 * math.pi)
SHIFT = 6
"""Steps up to where Stirling's series of four terms is right to 3e-11."""


def apply_waist(share: Scalar, waist: Scalar) -> Scalar:
    """h_w [-] of a share h [-], with b = `waist`."""
    y = 2.0 * share - 1.0
    return 0.5 + 0.5 * y * (1.0 - waist + waist * y * y)


def remove_waist(xp: Namespace, share: Scalar, waist: Scalar) -> Scalar:
    """The h [-] with h_w = share, limited to [0, 1]; exactly 0 and 1 at and beyond them."""
    share = xp.clip(share, 0.0, 1.0)
    wanted = xp.store(2.0 * share - 1.0)
    root = xp.store(_find_waist_root(xp, xp.detach(wanted), xp.detach(waist)))
    rest = root * (1.0 - waist + waist * root * root) - wanted
    slope = xp.detach(1.0 - waist + 3.0 * waist * root * root)
    y = xp.clip(xp.implicit_root(root, root - rest / slope), -1.0, 1.0)
    return xp.where(xp.abs(wanted) < 1.0, 0.5 + 0.5 * y, share)


def _find_waist_root(xp: Namespace, wanted: Scalar, waist: Scalar) -> Scalar:
    """y of the module's equations; its slopes are not used."""
    thin = 1.0 - waist
    s = xp.abs(wanted) * xp.sqrt(6.75 * waist / (thin * thin * thin))
    u = xp.exp(2.0 / 3.0 * xp.log(s + xp.sqrt(1.0 + s * s)))
    return 3.0 * wanted / (thin * (1.0 + u + 1.0 / u))


def waist_energy(xp: Namespace, start: Scalar, end: Scalar) -> Scalar:
    """∫ (y³ - y) dξ [-] over all fractions: b times it is added to 2 ∫ h dξ.

    Args:
        xp: namespace.
        start: exponent m of h at the start.
        end: exponent n at the end.
    """
    cross = _compute_beta(xp, start + 1.0, 2.0 * end + 1.0) - _compute_beta(xp, 2.0 * start + 1.0, end + 1.0)
    cube = 1.0 / (3.0 * start + 1.0) - 1.0 / (3.0 * end + 1.0) + 3.0 * cross
    return cube - 1.0 / (start + 1.0) + 1.0 / (end + 1.0)


def _compute_beta(xp: Namespace, a: Scalar, b: Scalar) -> Scalar:
    """Euler's beta function of arguments from 1 on."""
    return xp.exp(_log_gamma(xp, a) + _log_gamma(xp, b) - _log_gamma(xp, a + b) + HALF_LOG)


def _log_gamma(xp: Namespace, x: Scalar) -> Scalar:
    """ln Γ(x) - ½ ln 2π for x from 1 on, by Stirling's series above and steps down."""
    product = x
    for k in range(1, SHIFT):
        product = product * (x + k)
    z = x + SHIFT
    q = 1.0 / (z * z)
    series = (1.0 / 12.0 - q * (1.0 / 360.0 - q * (1.0 / 1260.0 - q / 1680.0))) / z
    return (z - 0.5) * xp.log(z) - z + series - xp.log(product)
