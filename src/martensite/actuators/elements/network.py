"""Cells in a row, each linked to its neighbours: what one of them sees of all the others.

In the linear system

    (d_i + g_{i-1} + g_i) T_i - g_{i-1} T_{i-1} - g_i T_{i+1} = r_i

elimination from both ends leaves, for every cell, its own equation with all others folded in,

    (d_i + b_i) T_i = r_i + s_i.

b and s do not depend on d_i and r_i: a cell whose own equation is not linear may solve it
alone, in a bracket, while the others answer as they were linearised.

How cells share force and elongation: end to end, or side by side.

To one cell all the others are a pair of numbers (what they add up to), taken as they answered before. Cells end to end
carry the same force, and their elongations add. Cells side by side have the same elongation, and their forces add; one
that is longer than that hangs slack.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.elements.base import Spring
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column

Column = Sequence[Scalar]


class Others(NamedTuple):
    """All others as each cell sees them."""

    slope: list[Scalar]
    """b: what they add to its diagonal."""
    source: list[Scalar]
    """s: what they add to its right-hand side."""


def fold_others(diagonal: Column, right: Column, links: Column) -> Others:
    """Fold all other cells into each; `links` has one entry less than there are cells."""
    below = _eliminate_before(diagonal, right, links)
    above = _eliminate_before(diagonal[::-1], right[::-1], links[::-1])
    above = Others(above.slope[::-1], above.source[::-1])
    slope = [a + b for a, b in zip(below.slope, above.slope, strict=True)]
    source = [a + b for a, b in zip(below.source, above.source, strict=True)]
    return Others(slope, source)


def solve_tridiagonal(diagonal: Column, right: Column, links: Column) -> list[Scalar]:
    """Return the solution of the linear system."""
    seen = fold_others(diagonal, right, links)
    rows = zip(diagonal, right, seen.slope, seen.source, strict=True)
    return [(r + s) / (d + b) for d, r, b, s in rows]


def _eliminate_before(diagonal: Column, right: Column, links: Column) -> Others:
    """Return the effect on every cell of the cells before it."""
    slope, source = [0.0], [0.0]
    for d, r, g in zip(diagonal[:-1], right[:-1], links, strict=True):
        share = g / (d + slope[-1] + g)
        source.append(share * (r + source[-1]))
        slope.append(share * (d + slope[-1]))
    return Others(slope, source)


ELONGATION_TOLERANCE = 1e-12
"""Difference of elongations that counts as none [m]."""


class Rest(NamedTuple):
    """Sum over all cells but one: elongation and compliance, or force and stiffness."""

    offset: Scalar
    slope: Scalar


class EndToEnd:
    """Cells of one row, and `copies` equal rows behind each other."""

    def __init__(self, copies: Scalar) -> None:
        self.copies = copies

    def whole(self, xp: Namespace, free: Column, compliance: Column, force: Scalar) -> Spring:
        """Return all cells as one spring, near a force [N]: the sums."""
        return Spring(self.copies * sum_column(free), self.copies * sum_column(compliance))

    def rests(self, xp: Namespace, free: Column, compliance: Column, force: Column) -> tuple[Column, Column]:
        """Return the sums over all other cells, for every cell, at the force that each carries [N]."""
        long, soft = sum_column(free), sum_column(compliance)
        return [long - f for f in free], [soft - c for c in compliance]

    def combine_springs(self, rest: Rest, own: Spring) -> Spring:
        """Return the whole, of one cell and the rest: the sum."""
        free, compliance = rest.offset + own.free, rest.slope + own.compliance
        return Spring(self.copies * free, self.copies * compliance)

    def force_share(self, xp: Namespace, own: Spring, whole: Spring, force: Scalar) -> Scalar:
        """Return the part of a force [N] that one cell carries: all of it."""
        return force


class ParallelCells:
    """Cells with a common elongation, none of which can push."""

    def whole(self, xp: Namespace, free: Column, compliance: Column, force: Scalar) -> Spring:
        """Return the spring of the taut cells. Newton's method from the slack side is exact for lines."""
        alone = [f + c * force for f, c in zip(free, compliance, strict=True)]
        e = alone[0]
        for other in alone[1:]:
            e = xp.maximum(e, other)
        spring = Spring(e, 0.0)
        for _ in free:
            spring = self._taut(xp, free, compliance, e)
            e = spring.free + spring.compliance * force
        return spring

    def _stiffness(self, xp: Namespace, free: Column, compliance: Column, e: Scalar) -> Column:
        """Return the stiffness of every cell at a common elongation; 0 of a slack cell."""
        rows = zip(free, compliance, strict=True)
        return [xp.where(e + ELONGATION_TOLERANCE >= f, 1.0 / c, 0.0) for f, c in rows]

    def _taut(self, xp: Namespace, free: Column, compliance: Column, e: Scalar) -> Spring:
        stiffness = self._stiffness(xp, free, compliance, e)
        soft = 1.0 / sum_column(stiffness)
        return Spring(soft * sum_column([k * f for k, f in zip(stiffness, free, strict=True)]), soft)

    def rests(self, xp: Namespace, free: Column, compliance: Column, force: Column) -> tuple[Column, Column]:
        """Return the sums over the others that are taut: stiffness times free elongation, and stiffness.

        The taut ones are those of the balance of all lines. Which cells carried a force before says less: a cell
        that begins to pull would count as slack in the equation of the one that it relieves.
        """
        whole = self.whole(xp, free, compliance, sum_column(force))
        e = whole.free + whole.compliance * sum_column(force)
        stiffness = self._stiffness(xp, free, compliance, e)
        pull = [k * f for k, f in zip(stiffness, free, strict=True)]
        return _sum_others(pull), _sum_others(stiffness)

    def combine_springs(self, rest: Rest, own: Spring) -> Spring:
        """Forces add at a common elongation."""
        stiffness = 1.0 / own.compliance
        soft = 1.0 / (rest.slope + stiffness)
        return Spring(soft * (rest.offset + stiffness * own.free), soft)

    def force_share(self, xp: Namespace, own: Spring, whole: Spring, force: Scalar) -> Scalar:
        """Return the force of the cell at the elongation of the whole; 0 if the cell is slack."""
        elongation = whole.free + whole.compliance * force
        return xp.maximum((elongation - own.free) / own.compliance, 0.0)


Linkage = EndToEnd | ParallelCells
"""Linkage of the cells of an element."""


def _sum_others(column: Column) -> list[Scalar]:
    """Return the sums of all numbers but one, without cancellation."""
    return [sum_column([0.0, *column[:i], *column[i + 1 :]]) for i in range(len(column))]
