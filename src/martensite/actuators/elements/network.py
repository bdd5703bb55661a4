"""Cells in a row: the effect of all other cells on each cell.

In the linear system

    (d_i + g_{i-1} + g_i) T_i - g_{i-1} T_{i-1} - g_i T_{i+1} = r_i

elimination from both ends gives each cell an equation that includes all others,

    (d_i + b_i) T_i = r_i + s_i.

b and s do not depend on d_i and r_i: a cell with a nonlinear equation can solve it alone, in a bracket, with the others
linearised.

Mechanically the other cells are a pair of sums. Cells end to end carry the same force, and their elongations add. Cells
side by side have the same elongation, and their forces add; a longer cell is slack.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.elements.base import Spring
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column

Column = Sequence[Scalar]


class Others(NamedTuple):
    """Effect of all other cells on each cell."""

    slope: list[Scalar]
    """b, added to its diagonal."""
    source: list[Scalar]
    """s, added to its right-hand side."""


def fold_others(diagonal: Column, right: Column, links: Column) -> Others:
    """Return the effect of all other cells on each; `links` has one entry less than there are cells."""
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
    """Return the effect on each cell of the cells before it."""
    slope, source = [0.0], [0.0]
    for d, r, g in zip(diagonal[:-1], right[:-1], links, strict=True):
        share = g / (d + slope[-1] + g)
        source.append(share * (r + source[-1]))
        slope.append(share * (d + slope[-1]))
    return Others(slope, source)


ELONGATION_TOLERANCE = 1e-12
"""Difference of elongations that counts as zero [m]."""


class Rest(NamedTuple):
    """Sum over all cells but one: elongation and compliance, or force and stiffness."""

    offset: Scalar
    slope: Scalar


class EndToEnd:
    """Cells of one row, and `copies` equal rows in series."""

    def __init__(self, copies: Scalar) -> None:
        self.copies = copies

    def whole(self, xp: Namespace, free: Column, compliance: Column, force: Scalar) -> Spring:
        """Return all cells as one spring, near a force [N]."""
        return Spring(self.copies * sum_column(free), self.copies * sum_column(compliance))

    def rests(self, xp: Namespace, free: Column, compliance: Column, force: Column) -> tuple[Column, Column]:
        """Return the sums over all other cells, for each cell, at its force [N]."""
        long, soft = sum_column(free), sum_column(compliance)
        return [long - f for f in free], [soft - c for c in compliance]

    def combine_springs(self, rest: Rest, own: Spring) -> Spring:
        """Return the whole from one cell and the rest."""
        free, compliance = rest.offset + own.free, rest.slope + own.compliance
        return Spring(self.copies * free, self.copies * compliance)

    def force_share(self, xp: Namespace, own: Spring, whole: Spring, force: Scalar) -> Scalar:
        """Return the part of a force [N] on one cell: all of it."""
        return force


class ParallelCells:
    """Cells with a common elongation that cannot push."""

    def whole(self, xp: Namespace, free: Column, compliance: Column, force: Scalar) -> Spring:
        """Return the spring of the taut cells, by Newton's method from the slack side."""
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
        """Return the stiffness of each cell at a common elongation; 0 if slack."""
        rows = zip(free, compliance, strict=True)
        return [xp.where(e + ELONGATION_TOLERANCE >= f, 1.0 / c, 0.0) for f, c in rows]

    def _taut(self, xp: Namespace, free: Column, compliance: Column, e: Scalar) -> Spring:
        stiffness = self._stiffness(xp, free, compliance, e)
        soft = 1.0 / sum_column(stiffness)
        return Spring(soft * sum_column([k * f for k, f in zip(stiffness, free, strict=True)]), soft)

    def rests(self, xp: Namespace, free: Column, compliance: Column, force: Column) -> tuple[Column, Column]:
        """Return the sums over the other taut cells: stiffness times free elongation, and stiffness.

        Cells are taut in the balance of all lines. Previous forces are no criterion: a cell that begins to pull would
        count as slack in the equation of the cell it relieves.
        """
        whole = self.whole(xp, free, compliance, sum_column(force))
        e = whole.free + whole.compliance * sum_column(force)
        stiffness = self._stiffness(xp, free, compliance, e)
        pull = [k * f for k, f in zip(stiffness, free, strict=True)]
        return _sum_others(pull), _sum_others(stiffness)

    def combine_springs(self, rest: Rest, own: Spring) -> Spring:
        """Return the whole from one cell and the rest: forces add."""
        stiffness = 1.0 / own.compliance
        soft = 1.0 / (rest.slope + stiffness)
        return Spring(soft * (rest.offset + stiffness * own.free), soft)

    def force_share(self, xp: Namespace, own: Spring, whole: Spring, force: Scalar) -> Scalar:
        """Return the force of the cell at the elongation of the whole; 0 if slack."""
        elongation = whole.free + whole.compliance * force
        return xp.maximum((elongation - own.free) / own.compliance, 0.0)


Linkage = EndToEnd | ParallelCells
"""Linkage of the cells of an element."""


def _sum_others(column: Column) -> list[Scalar]:
    """Return the sums of all values but one, without cancellation."""
    return [sum_column([0.0, *column[:i], *column[i + 1 :]]) for i in range(len(column))]
