"""Tables of properties as kernels: linear between the rows, held beyond the first and the last.

    y(x) = y₀ + Σ (yₖ₊₁ - yₖ)/(xₖ₊₁ - xₖ) · clip(x - xₖ, 0, xₖ₊₁ - xₖ)

is the broken line through the rows without a choice between them. Nothing is registered here.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from martensite.kernels.namespace import Namespace, Scalar

Row = tuple[float, ...]


def interpolate_rows(xp: Namespace, x: Scalar, rows: Sequence[Row]) -> list[Scalar]:
    """All columns of the table at `x`; the first entry of a row is its x, ascending."""
    found: list[Scalar] = list(rows[0][1:])
    for (left, *before), (right, *after) in pairwise(rows):
        share = xp.clip(x - left, 0.0, right - left) * (1.0 / (right - left))
        columns = zip(found, before, after, strict=True)
        found = [value + (b - a) * share for value, a, b in columns]
    return found
