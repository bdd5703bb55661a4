"""Unilateral constraints of a mechanism: contacts that push but do not pull.

With gaps g(q) ≥ 0 and their derivatives G = dg/dq, constraints act on the coordinates with Gᵀλ, and

    g_j ≥ 0,        λ_j ≥ 0,        g_j λ_j = 0.

At a trial position with reactions λ°, the free motion δ° of a mechanism of stiffness A and the compliance W = G A⁻¹Gᵀ
make this a linear complementarity problem in few unknowns,

    w = c + W λ ≥ 0  ⊥  λ ≥ 0,        c = g + G δ° - W λ°

Its solution determines which constraints touch. Principal pivoting solves it exactly in a bounded number of iterations:
the first wrong sign is flipped, until all signs are right (K. G. Murty, Linear Complementarity, Linear and Nonlinear
Programming, 1988). Newton's method then keeps the touching constraints, G δ = -g, including the rotation of their
derivatives under λ°. A may lack stiffness that the motion along the constraints has, so A + ρ GᵀG is eliminated with -ρ
Gᵀg on the right: the same equations for any ρ.

Contacts are rigid. A fraction of 1e-10 of W on its diagonal, relative to λ° and thus without effect on the solution,
keeps W regular if more constraints act than there are coordinates. A stop gives λ in N m for a gap in rad, a contact in
N for a gap in m.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from martensite.actuators.mechanics.elimination import Rows, multiply_inner, solve_linear
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import find_largest

REACH = 0.1
"""Gap [m] or [rad] that counts as a residual of 1; a solved step leaves at most 1e-9 m."""
TURNS = 40
"""Largest number of pivoting iterations."""
NEARBY = 1e-10
"""Relative regularisation of the compliance."""
NONE = 1e-15
"""Gap [m] or [rad] that counts as zero."""
HELD = 1e3
"""ρ over the stiffness in the direction of a constraint."""
FARTHEST = 0.3
"""Largest correction of a coordinate per pass, relative to its size."""

Column = Sequence[Scalar]


class Constraints(NamedTuple):
    """Unilateral constraints at a trial position."""

    gaps: Column
    slopes: Rows
    """G."""
    turning: Sequence[Rows]
    """dG_j/dq of each."""
    reactions: Column
    """λ°: [N] or [N m]."""


def linearise_gaps(xp: Namespace, gaps: Callable[..., Column], at: Column, reactions: Column) -> Constraints:
    """Return the gaps with first and second derivatives."""

    def slopes(xp: Namespace, position: Column) -> list[Scalar]:
        return [x for row in compute_jacobian(xp, gaps, position)[1] for x in row]

    values, rows = compute_jacobian(xp, gaps, at)
    _, turned = compute_jacobian(xp, slopes, at)
    return Constraints(values, rows, [turned[j : j + len(at)] for j in range(0, len(turned), len(at))], reactions)


def hold_touching(xp: Namespace, given: Constraints, stiffness: Rows, sides: Rows, missing: Column) -> Rows:
    """Return the motions under the sides with touching constraints (λ° > 0) kept, and under the missing forces.

    The last motion closes the gaps of touching constraints; its sign is that of the missing forces.
    """
    flags = [reaction > 0.0 for reaction in given.reactions]
    still = [[0.0] * len(flags) for _ in sides]
    return _move_held(xp, given, stiffness, flags, [*sides, missing], [*still, given.gaps])[0]


def meet_constraints(
    xp: Namespace, given: Constraints, stiffness: Rows, side: Column
) -> tuple[list[Scalar], list[Scalar], Scalar]:
    """Return the constrained motion under a side, the reactions, and their error as a gap."""
    gaps, slopes, _, old = given
    motion, *yields = solve_linear(stiffness, [side, *slopes])
    compliance = [[multiply_inner(slope, soft) for soft in yields] for slope in slopes]
    rows = zip(gaps, slopes, compliance, strict=True)
    free = [g + multiply_inner(slope, motion) - multiply_inner(row, old) for g, slope, row in rows]
    flags = _find_touching(xp, compliance, free, old)
    released = [xp.where(flag, 0.0, x) for flag, x in zip(flags, old, strict=True)]
    side = [x - multiply_inner(released, column) for x, column in zip(side, zip(*slopes, strict=True), strict=True)]
    (moved,), (change,) = _move_held(xp, given, stiffness, flags, [side], [[-g for g in gaps]])
    missed, reactions = list[Scalar](), list[Scalar]()
    for j, (flag, x, d) in enumerate(zip(flags, old, change, strict=True)):
        raw, soft = xp.where(flag, x + d, 0.0), compliance[j][j]
        opened = gaps[j] + multiply_inner(slopes[j], moved)
        missed += [xp.abs(xp.minimum(opened, soft * raw)), soft * xp.abs(raw - x)]
        reactions.append(xp.maximum(raw, 0.0))
    return moved, reactions, find_largest(xp, missed)


def measure_mismatch(xp: Namespace, gaps: Column, reactions: Column) -> Scalar:
    """Return the largest gap with a reaction, or overlap, as a residual."""
    rows = zip(gaps, reactions, strict=True)
    missed = [xp.where(push > 0.0, xp.abs(gap), xp.maximum(-gap, 0.0)) for gap, push in rows]
    return find_largest(xp, missed) * (1.0 / REACH)


def _move_held(
    xp: Namespace, given: Constraints, stiffness: Rows, flags: Sequence[Flag], sides: Rows, targets: Rows
) -> tuple[list[list[Scalar]], list[list[Scalar]]]:
    """Return the motions that close the gaps of touching constraints, and the change of reactions."""
    slopes, columns = given.slopes, list(zip(*given.slopes, strict=True))
    matrix, weights = [list(row) for row in stiffness], list[Scalar]()
    for j, soft in enumerate(solve_linear(stiffness, slopes)):
        weights.append(xp.where(flags[j], HELD / (xp.abs(multiply_inner(slopes[j], soft)) + 1e-30), 0.0))
        pushed = xp.where(flags[j], given.reactions[j], 0.0)
        for i, row in enumerate(given.turning[j]):
            more = [weights[j] * slopes[j][i] * b - pushed * t for b, t in zip(slopes[j], row, strict=True)]
            matrix[i] = [x + y for x, y in zip(matrix[i], more, strict=True)]
    pulls = [[w * t for w, t in zip(weights, target, strict=True)] for target in targets]
    solved = solve_linear(matrix, [*_add_products(sides, columns, pulls), *slopes])
    free, yields = solved[: len(sides)], solved[len(sides) :]
    compliance = [[multiply_inner(slope, soft) for soft in yields] for slope in slopes]
    gaps = [
        [t - multiply_inner(slope, x) for t, slope in zip(target, slopes, strict=True)]
        for target, x in zip(targets, free, strict=True)
    ]
    changes = _solve_masked(xp, compliance, flags, gaps)
    return _add_products(free, list(zip(*yields, strict=True)), changes), changes


def _add_products(rows: Rows, columns: Rows, factors: Rows) -> list[list[Scalar]]:
    """Return rows plus the products of columns with the factors of each row."""
    return [
        [x + multiply_inner(column, factor) for x, column in zip(row, columns, strict=True)]
        for row, factor in zip(rows, factors, strict=True)
    ]


def _solve_masked(xp: Namespace, compliance: Rows, flags: Sequence[Flag], sides: Rows) -> list[list[Scalar]]:
    """Return the reactions of touching constraints for given gaps; 0 for the others."""
    shares = [xp.where(flag, 1.0, 0.0) for flag in flags]
    masked = [[a * b * x for b, x in zip(shares, row, strict=True)] for a, row in zip(shares, compliance, strict=True)]
    for j, flag in enumerate(flags):
        masked[j][j] = xp.where(flag, (1.0 + NEARBY) * compliance[j][j], 1.0)
    return solve_linear(masked, [[a * x for a, x in zip(shares, side, strict=True)] for side in sides])


def _find_touching(xp: Namespace, compliance: Rows, free: Column, old: Column) -> list[Flag]:
    """Return the touching constraints by principal pivoting with the least index, from the previous ones."""
    free, compliance = [xp.detach(c) for c in free], [[xp.detach(x) for x in row] for row in compliance]

    def turn(_: Scalar, *shares: Scalar) -> list[Scalar]:
        flags = [share > 0.5 for share in shares]
        (pushed,) = _solve_masked(xp, compliance, flags, [[-c for c in free]])
        left: Scalar = 1.0
        turned = list[Scalar]()
        for j, (flag, c, row) in enumerate(zip(flags, free, compliance, strict=True)):
            sign = xp.where(flag, row[j] * pushed[j], c + multiply_inner(row, pushed))
            wrong = xp.where(sign < -NONE, left, 0.0)
            left = left - wrong
            turned.append(shares[j] + wrong * (1.0 - 2.0 * shares[j]))
        return [1.0 - left, *turned]

    end = xp.iterate(TURNS, turn, 1.0, *(xp.where(one > 0.0, 1.0, 0.0) for one in old))
    return [share > 0.5 for share in end[1:]]
