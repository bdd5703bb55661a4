"""Two branches of a hysteresis loop with exact paths along them: a model of Duhem type.

A branch is the fraction F(x) that has transformed when x comes from far below (rising), or has not transformed back
when x comes from far above (falling): a sum of one or two logistic functions. Inner loops are scaled copies,

    dz/dx = (1 - z) F_r'/(1 - F_r) for rising x,    dz/dx = z F_f'/F_f for falling x

which integrate to (1 - z)/(1 - z₀) = (1 - F_r(x))/(1 - F_r(x₀)) and z/z₀ = F_f(x)/F_f(x₀): steps of any size in one
direction are exact (Ivshin and Pence 1994). A small number in both denominators keeps z between 0 and 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.identify.blocks.base import Column
from martensite.kernels.namespace import Namespace, Scalar

GUARD = 1e-6
"""Number that is added to a denominator."""
FLATTEST = 14.0
"""Limit of |log width|."""


class LogisticBranch(NamedTuple):
    """Weights, centres and widths of logistic functions."""

    shares: Sequence[Scalar]
    centres: Sequence[Scalar]
    widths: Sequence[Scalar]


def name_branch(branch: str, logistics: int) -> tuple[str, ...]:
    """Return the free numbers of a branch: centres, logarithms of widths, and the logit of the first weight."""
    places = ("",) if logistics == 1 else ("1", "2")
    centres = tuple(f"{branch}_centre{k}" for k in places)
    widths = tuple(f"log_{branch}_width{k}" for k in places)
    return (*centres, *widths) + ((f"{branch}_logit",) if logistics == 2 else ())


def compute_logistic(xp: Namespace, x: Scalar) -> Scalar:
    """Return 1/(1 + exp(-x))."""
    return 0.5 + 0.5 * xp.tanh(0.5 * x)


def branch_of(xp: Namespace, theta: Column) -> LogisticBranch:
    """Return the branch of 2 free numbers (one logistic function) or 5 (two)."""
    count = len(theta) // 2
    widths = [xp.exp(xp.clip(w, -FLATTEST, FLATTEST)) for w in theta[count : 2 * count]]
    first = compute_logistic(xp, theta[4]) if count == 2 else 1.0
    return LogisticBranch([first, 1.0 - first][:count], theta[:count], widths)


def compute_share(xp: Namespace, branch: LogisticBranch, x: Scalar) -> Scalar:
    """Return F(x)."""
    total: Scalar = 0.0
    for part, centre, width in zip(*branch, strict=True):
        total = total + part * compute_logistic(xp, (x - centre) / width)
    return total


def compute_density(xp: Namespace, branch: LogisticBranch, x: Scalar) -> Scalar:
    """Return F'(x)."""
    total: Scalar = 0.0
    for part, centre, width in zip(*branch, strict=True):
        t = xp.tanh(0.5 * (x - centre) / width)
        total = total + part * 0.25 * (1.0 - t * t) / width
    return total


class BranchLeg(NamedTuple):
    """A path in one direction from (x₀, z₀): z = z₀ + scale (F(x) - F(x₀))."""

    branch: LogisticBranch
    scale: Scalar
    at_start: Scalar
    """F(x₀)."""
    z: Scalar
    """z₀."""

    def fraction(self, xp: Namespace, x: Scalar) -> Scalar:
        """Return z at x; exactly z₀ at x₀."""
        return self.z + self.scale * (compute_share(xp, self.branch, x) - self.at_start)

    def slope(self, xp: Namespace, x: Scalar) -> Scalar:
        """Return dz/dx ≥ 0 at x."""
        return self.scale * compute_density(xp, self.branch, x)


def follow_leg(
    xp: Namespace, rising: LogisticBranch, falling: LogisticBranch, upward: bool, x: Scalar, z: Scalar
) -> BranchLeg:
    """Return the path from x and z, upward or not."""

    def chosen(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
        return [xp.where(upward, p, q) for p, q in zip(a, b, strict=True)]

    branch = LogisticBranch(*(chosen(a, b) for a, b in zip(rising, falling, strict=True)))
    start = compute_share(xp, branch, x)
    reach = xp.where(upward, 1.0 - start, start)
    remaining = xp.where(upward, 1.0 - z, z)
    return BranchLeg(branch, remaining / (reach + GUARD), start, z)


def from_below(xp: Namespace, rising: LogisticBranch, x: Scalar) -> Scalar:
    """Return z after x has come from far below, where z was 0."""
    return compute_share(xp, rising, x) / (1.0 + GUARD)


def from_above(xp: Namespace, falling: LogisticBranch, x: Scalar) -> Scalar:
    """Return z after x has come from far above, where z was 1."""
    return (compute_share(xp, falling, x) + GUARD) / (1.0 + GUARD)
