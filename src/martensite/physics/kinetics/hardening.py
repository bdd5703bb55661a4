r"""Smooth hardening: the share of a transformation range that makes a martensite fraction.

    h(ξ) = ½ [1 + ξ^m - (1 - ξ)^n],      0 < m, n ≤ 1,      h(0) = 0, h(1) = 1

For m = n = 1 it is h = ξ; smaller exponents round the corners at the start (m) and at the end
(n), where the slope of h is infinite. Inverted without that singularity: below ξ = ½ in the
variable p = ξ^m, above it in p = (1 - ξ)^n, with the exponents exchanged,

    φ(p) = p + 1 - (1 - p^(1/m))^n = 2 h

is convex with slopes from 1 on. Newton's iteration from the right therefore comes down to the
root and needs no bracket: six steps reach rounding for all exponents from 0.05 to 1. Only the
last of them is differentiated, which gives the slopes of the root.

Source: Hartl and Lagoudas, in Lagoudas et al. (2012), Int. J. Plasticity 32–33; the inversion
is this package's.
"""

from __future__ import annotations

from martensite.kernels.namespace import Namespace, Scalar

LEAST_EXPONENT = 0.05
ITERATIONS = 6
NOTHING = 1e-60
"""Bases below it count as 0: their logarithm has no bounded slope."""


def raise_positive(xp: Namespace, base: Scalar, exponent: Scalar) -> Scalar:
    """`base` to a positive power; 0 for bases that are not positive."""
    safe = xp.exp(exponent * xp.log(xp.maximum(base, NOTHING)))
    return xp.where(base > NOTHING, safe, 0.0)


def compute_hardening(xp: Namespace, fraction: Scalar, start: Scalar, end: Scalar) -> Scalar:
    """h(ξ) [-] with the exponents at the start and at the end of the range."""
    left = raise_positive(xp, 1.0 - fraction, end)
    return 0.5 * (1.0 + raise_positive(xp, fraction, start) - left)


def hardening_integral(xp: Namespace, fraction: Scalar, start: Scalar, end: Scalar) -> Scalar:
    """An antiderivative of h over ξ [-]."""
    left = raise_positive(xp, 1.0 - fraction, end + 1.0) / (end + 1.0)
    return 0.5 * (fraction + raise_positive(xp, fraction, start + 1.0) / (start + 1.0) + left)


def invert_hardening(xp: Namespace, share: Scalar, start: Scalar, end: Scalar) -> Scalar:
    """The fraction ξ with h(ξ) = share, limited to [0, 1]; exactly 0 and 1 at and beyond them."""
    share = xp.clip(share, 0.0, 1.0)
    middle = compute_hardening(xp, 0.5, start, end)
    below = share < middle
    near = xp.store(xp.where(below, start, end))
    far = xp.store(xp.where(below, end, start))
    twice = xp.store(2.0 * xp.where(below, share, 1.0 - share))
    fixed = xp.detach(twice), xp.detach(near), xp.detach(far)
    p = xp.minimum(fixed[0], raise_positive(xp, 0.5, fixed[1]))
    for _ in range(ITERATIONS - 1):
        p = _improve_root(xp, p, *fixed)
    part = raise_positive(xp, _improve_root(xp, p, twice, near, far), 1.0 / near)
    return xp.where(below, part, 1.0 - part)


def _improve_root(xp: Namespace, p: Scalar, twice: Scalar, near: Scalar, far: Scalar) -> Scalar:
    """One step towards φ(p) = twice; of a root, it has the slopes of the root."""
    part = xp.store(raise_positive(xp, p, 1.0 / near))
    rest = xp.store(raise_positive(xp, 1.0 - part, far))
    slope = 1.0 + rest * part * far / ((1.0 - part) * near * xp.maximum(p, NOTHING))
    return xp.store(xp.maximum(p - (p + 1.0 - rest - twice) / slope, 0.0))
