"""Sums over records that the covariance of the free numbers is made of, in bounded memory.

    H = Σ_t J_tᵀ J_t,    M = Σ_b g_b g_bᵀ,    g_b = Σ_{t in b} J_tᵀ e_t

Residuals e within a block b may depend on each other, those of two blocks are taken to be
independent (Newey and West (1987), Econometrica 55, with a window that is a box of blocks).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.residuals import ResidualSquares
from martensite.search.whiteness import count_effective_samples

TIMES = 3.0
"""Length of a block over the time that the residuals remember, τ of `count_effective_samples`."""
FEWEST = 30
"""Blocks of a record at least, if it has as many samples."""


@dataclass(frozen=True, eq=False)
class Sums:
    """What one pass over the records gives."""

    square: Numbers
    """H."""
    middle: Numbers
    """M."""
    squares: Numbers
    """Sum of the squared weighted residuals of every output of every record."""
    counts: Numbers
    """How many of them count."""
    blocks: int


def block_lengths(squares: ResidualSquares, theta: Numbers) -> list[int]:
    """Samples of a block of every record, from how long its residuals are alike.

    Raises:
        DataError: a residual is not finite.
    """
    found: list[int] = []
    for aim, state in zip(squares.aims, squares.initial(squares.extend_parameters(theta)), strict=True):
        y = squares.engine.simulate(theta, aim.record.inputs, state.copy())
        errors = (aim.record.outputs - y)[aim.skip :]
        longest = 1.0
        for column in errors.T:
            own = np.nan_to_num(column, nan=0.0)
            known = max(int(np.isfinite(column).sum()), 1)
            if np.any(own != 0.0):
                longest = max(longest, known / min(count_effective_samples(own), known))
        most = max(len(errors) // FEWEST, 1)
        found.append(int(min(max(round(TIMES * longest), 1), most)) if longest > 1.5 else 1)
    return found


def sum_blocks(squares: ResidualSquares, theta: Numbers, blocks: Sequence[int]) -> Sums:
    """One pass over all records, with blocks of so many samples in each."""
    p, outputs = squares.columns, len(squares.engine.taps)
    square, middle = np.diag(squares.pull.astype(float)), np.zeros((p, p))
    sizes = np.zeros((len(squares.aims), outputs))
    counts, number = np.zeros_like(sizes), 0
    held: dict[int, Numbers] = {}
    for k, part in squares.parts(theta):
        rows = part.slopes.reshape(-1, p)
        square += rows.T @ rows
        counted = np.isfinite(squares.aims[k].record.outputs[part.rows])
        counted[: max(squares.aims[k].skip - part.rows.start, 0)] = False
        sizes[k] += np.sum(part.residuals**2, axis=0)
        counts[k] += counted.sum(axis=0)
        scores = np.einsum("tip,ti->tp", part.slopes, part.residuals)
        for block, score in _by_block(scores, part.rows.start, blocks[k]):
            if k in held and held[k][0] == block:
                score = score + held[k][1:]
            elif k in held:
                middle += np.outer(held[k][1:], held[k][1:])
                number += 1
            held[k] = np.concatenate([[block], score])
    for last in held.values():
        middle += np.outer(last[1:], last[1:])
    return Sums(square, middle, sizes, counts, number + len(held))


def _by_block(scores: Numbers, first: int, length: int) -> Iterator[tuple[int, Numbers]]:
    """Number of a block, and the sum of the scores that lie in it."""
    numbers = (first + np.arange(len(scores))) // length
    begins = np.flatnonzero(np.diff(numbers, prepend=-1))
    totals = np.add.reduceat(scores, begins, axis=0)
    yield from zip(numbers[begins].tolist(), totals, strict=True)
