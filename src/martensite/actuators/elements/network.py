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

import operator
from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.elements.base import Spring
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import map_rows, sum_column, sum_columns

Column = Sequence[Scalar]


def fold_others(xp: Namespace, diagonal: Column, links: Column, *rights: Column) -> list[Column]:
    """Return b, and s for each right-hand side: the effect of all other cells on each.

    `links` has one entry less than there are cells.
    """
    ends = [diagonal, [*links, 0.0], *rights]
    below = _eliminate_before(xp, *ends)
    ends = [diagonal[::-1], [*links[::-1], 0.0], *(right[::-1] for right in rights)]
    above = [column[::-1] for column in _eliminate_before(xp, *ends)]
    return [map_rows(xp, operator.add, *pair) for pair in zip(below, above, strict=True)]


def solve_tridiagonal(xp: Namespace, diagonal: Column, right: Column, links: Column) -> Column:
    """Return the solution of the linear system."""
    return solve_cells(xp, diagonal, right, *fold_others(xp, diagonal, links, right))


def solve_cells(xp: Namespace, diagonal: Column, right: Column, slope: Column, source: Column) -> Column:
    """Return the temperature of each cell with the effect of all others."""

    def solve(d: Scalar, r: Scalar, b: Scalar, s: Scalar) -> Scalar:
        return (r + s) / (d + b)

    return map_rows(xp, solve, diagonal, right, slope, source)


def _eliminate_before(xp: Namespace, diagonal: Column, links: Column, *rights: Column) -> list[Column]:
    """Return the effect on each cell of the cells before it."""
    size = 1 + len(rights)

    def eliminate(*numbers: Scalar) -> list[Scalar]:
        (slope, *sources), (d, g, *r) = numbers[:size], numbers[size:]
        share = g / (d + slope + g)
        after = [share * (d + slope), *(share * (a + b) for a, b in zip(r, sources, strict=True))]
        return [*after, *numbers[:size]]

    return list(xp.scan(eliminate, [0.0] * size, diagonal, links, *rights)[size:])


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
        long, soft = sum_columns(xp, free, compliance)
        return Spring(self.copies * long, self.copies * soft)

    def rests(self, xp: Namespace, free: Column, compliance: Column, force: Column) -> tuple[Column, Column]:
        """Return the sums over all other cells, for each cell, at its force [N]."""
        long, soft = sum_columns(xp, free, compliance)
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
