"""Standard errors of what the free numbers of a block mean, by the delta method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from martensite.identify.blocks.base import AbstractBlock, Numbers

STEP = 1e-5
"""Of central differences, as a share of the number, or of 1."""
NEGLIGIBLE = 1e-6
"""Change of a value with numbers that are not determined, over the largest value of its kind in
the block, that does not matter: a weight that is 0 whatever the number behind it is."""


class PrintedNumber(NamedTuple):
    """What free numbers mean, with its standard error."""

    block: int
    name: str
    value: float
    error: float
    """Infinite if the records do not determine it."""
    unit: str


def list_rows(
    number: int,
    block: AbstractBlock,
    theta: Numbers,
    slopes: Numbers,
    covariance: Numbers,
    undetermined: Numbers,
    moved: Numbers,
) -> list[PrintedNumber]:
    """The rows of one block.

    Args:
        number: of the block, from 1 on.
        block: the block.
        theta: its free numbers.
        slopes: derivatives of what is shown, shape (rows, numbers).
        covariance: of the free numbers.
        undetermined: whether a row depends on directions that are not determined.
        moved: how much a row changes with numbers that are not determined.
    """
    rows = block.describe_numbers(theta)
    errors = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slopes, covariance, slopes), 0.0))
    found: list[PrintedNumber] = []
    for k, (name, value, unit) in enumerate(rows):
        largest = max(abs(other) for _, other, own in rows if own == unit)
        free = bool(undetermined[k]) and moved[k] > NEGLIGIBLE * largest
        found.append(PrintedNumber(number, name, value, np.inf if free else float(errors[k]), unit))
    return found


def slopes_of_shown(block: AbstractBlock, theta: Numbers) -> Numbers:
    """Derivatives of what is shown with respect to the free numbers, by central differences."""
    found = np.zeros((len(block.describe_numbers(theta)), len(theta)))
    for i, value in enumerate(theta):
        step = STEP * max(abs(float(value)), 1.0)
        ends: list[list[float]] = []
        for sign in (1.0, -1.0):
            moved = np.array(theta, dtype=float)
            moved[i] += sign * step
            ends.append([number for _, number, _ in block.describe_numbers(moved)])
        found[:, i] = (np.array(ends[0]) - np.array(ends[1])) / (2.0 * step)
    return found
