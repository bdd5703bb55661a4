"""Cells in a row, each linked to its neighbours: what one of them sees of all the others.

In the linear system

    (d_i + g_{i-1} + g_i) T_i - g_{i-1} T_{i-1} - g_i T_{i+1} = r_i

elimination from both ends leaves, for every cell, its own equation with all others folded in,

    (d_i + b_i) T_i = r_i + s_i.

b and s do not depend on d_i and r_i: a cell whose own equation is not linear may solve it
alone, in a bracket, while the others answer as they were linearised.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.kernels.namespace import Scalar

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
    """The solution of the linear system."""
    seen = fold_others(diagonal, right, links)
    rows = zip(diagonal, right, seen.slope, seen.source, strict=True)
    return [(r + s) / (d + b) for d, r, b, s in rows]


def _eliminate_before(diagonal: Column, right: Column, links: Column) -> Others:
    """What every cell sees of those before it."""
    slope, source = [0.0], [0.0]
    for d, r, g in zip(diagonal[:-1], right[:-1], links, strict=True):
        share = g / (d + slope[-1] + g)
        source.append(share * (r + source[-1]))
        slope.append(share * (d + slope[-1]))
    return Others(slope, source)
