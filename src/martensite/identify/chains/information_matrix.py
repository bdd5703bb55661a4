"""Sums over records for the covariance of the free numbers, in bounded memory.

    H = Σ_t J_tᵀ J_t,    M = Σ_b g_b g_bᵀ,    g_b = Σ_{t in b} J_tᵀ e_t

Residuals e within a block b may be correlated, different blocks are independent (Newey and West (1987), Econometrica
55, with a window of blocks). Physical quantities get standard errors by the delta method.

Undetermined directions follow from JᵀJ with columns of norm 1: eigenvalues below a fraction of the largest. For few
numbers the smallest undetermined sets are searched (`search.weak_direction_sets`); for many, directions are combined
so that each has one number that no other has, and their largest components are named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.residuals import ResidualSquares
from martensite.search.quantity_text import list_names
from martensite.search.weak_direction import find_weak_directions
from martensite.search.whiteness import count_effective_samples

TIMES = 3.0
"""Length of a block over the correlation time of the residuals (`count_effective_samples`)."""
LEAST_BLOCKS = 30
"""Least number of blocks of a record."""


@dataclass(frozen=True, eq=False)
class Sums:
    """Sums over the records."""

    square: Numbers
    middle: Numbers
    squares: Numbers
    """Sum of the squared weighted residuals of every output of every record."""
    counts: Numbers
    """Number of counted samples of the outputs."""
    blocks: int


def block_lengths(squares: ResidualSquares, theta: Numbers) -> list[int]:
    """Return the block length of every record in samples, from the correlation time of its residuals.

    Args:
        squares: minimised sum of squares.
        theta: numbers of the chain, and estimated initial states.

    Raises:
        DataError: a residual is not finite.
    """
    lengths: list[int] = []
    for aim, state in zip(squares.aims, squares.initial(theta), strict=True):
        y = squares.engine.simulate(theta[: squares.columns], aim.record.inputs, state.copy())
        errors = (aim.record.outputs - y)[aim.skip :]
        longest = 1.0
        for column in errors.T:
            finite = np.nan_to_num(column, nan=0.0)
            count = max(int(np.isfinite(column).sum()), 1)
            if np.any(finite != 0.0):
                longest = max(longest, count / min(count_effective_samples(finite), count))
        most = max(len(errors) // LEAST_BLOCKS, 1)
        lengths.append(int(min(max(round(TIMES * longest), 1), most)) if longest > 1.5 else 1)
    return lengths


def sum_blocks(squares: ResidualSquares, theta: Numbers, blocks: Sequence[int]) -> Sums:
    """Return the sums over all records with these block lengths."""
    p, outputs = squares.columns, len(squares.engine.taps)
    square, middle = np.diag(squares.pull.astype(float)), np.zeros((p, p))
    sizes = np.zeros((len(squares.aims), outputs))
    counts, number = np.zeros_like(sizes), 0
    last_scores: dict[int, Numbers] = {}
    for k, part in squares.parts(theta):
        rows = part.slopes.reshape(-1, p)
        square += rows.T @ rows
        counted = np.isfinite(squares.aims[k].record.outputs[part.rows])
        counted[: max(squares.aims[k].skip - part.rows.start, 0)] = False
        sizes[k] += np.sum(part.residuals**2, axis=0)
        counts[k] += counted.sum(axis=0)
        scores = np.einsum("tip,ti->tp", part.slopes, part.residuals)
        for block, score in _by_block(scores, part.rows.start, blocks[k]):
            if k in last_scores and last_scores[k][0] == block:
                score = score + last_scores[k][1:]
            elif k in last_scores:
                middle += np.outer(last_scores[k][1:], last_scores[k][1:])
                number += 1
            last_scores[k] = np.concatenate([[block], score])
    for last in last_scores.values():
        middle += np.outer(last[1:], last[1:])
    return Sums(square, middle, sizes, counts, number + len(last_scores))


def _by_block(scores: Numbers, first: int, length: int) -> Iterator[tuple[int, Numbers]]:
    numbers = (first + np.arange(len(scores))) // length
    begins = np.flatnonzero(np.diff(numbers, prepend=-1))
    totals = np.add.reduceat(scores, begins, axis=0)
    yield from zip(numbers[begins].tolist(), totals, strict=True)


STEP = 1e-5
"""Step of central differences, relative to the parameter or 1."""
NEGLIGIBLE = 1e-6
"""Relative change of a value with undetermined numbers that does not matter, such as a weight that stays 0."""


class PrintedNumber(NamedTuple):
    """Physical quantity of free parameters with its standard error."""

    block: int
    name: str
    value: float
    error: float
    """Standard error; infinite if undetermined."""
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
    """Return the rows of one block from the covariance of its free numbers.

    Args:
        number: number of the block, from 1.
        block: the block.
        theta: its free numbers.
        slopes: derivatives of the rows, shape (rows, numbers).
        covariance: covariance of the free numbers.
        undetermined: True for rows that depend on undetermined directions.
        moved: change of each row along these directions.
    """
    rows = block.describe_numbers(theta)
    errors = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slopes, covariance, slopes), 0.0))
    numbers: list[PrintedNumber] = []
    for k, (name, value, unit) in enumerate(rows):
        largest = max(abs(other) for _, other, own in rows if own == unit)
        free = bool(undetermined[k]) and moved[k] > NEGLIGIBLE * largest
        numbers.append(PrintedNumber(number, name, value, np.inf if free else float(errors[k]), unit))
    return numbers


def slopes_of_shown(block: AbstractBlock, theta: Numbers) -> Numbers:
    """Return the derivatives of the physical quantities by the free numbers, by central differences."""
    slopes = np.zeros((len(block.describe_numbers(theta)), len(theta)))
    for i, value in enumerate(theta):
        step = STEP * max(abs(float(value)), 1.0)
        ends: list[list[float]] = []
        for sign in (1.0, -1.0):
            moved = np.array(theta, dtype=float)
            moved[i] += sign * step
            ends.append([number for _, number, _ in block.describe_numbers(moved)])
        slopes[:, i] = (np.array(ends[0]) - np.array(ends[1])) / (2.0 * step)
    return slopes


CUT = 1e-9
"""Eigenvalue of the scaled JᵀJ over the largest below which a direction is undetermined."""
NOTHING = 1e-10
"""Norm of a column of J over the largest below which a number has no effect."""
MANY = 24
"""Largest number of free numbers for the search of the smallest sets."""
NAMED = 6
"""Largest number of names for a direction."""
SMALL = 0.1
"""Component over the largest below which a number is not named."""
SLIGHT = 0.01
"""Component over the largest below which a number is not counted."""


@dataclass(frozen=True)
class Flat:
    """An undetermined number, or several that are not determined separately."""

    names: tuple[str, ...]
    changes: tuple[float, ...]
    """Changes that compensate each other; 1 for a single number."""
    more: int
    """Number of other parameters with small changes."""

    @property
    def sentence(self) -> str:
        """Describe the undetermined parameters in a sentence."""
        if len(self.names) == 1 and not self.more:
            return (
                f"{list_names(self.names)} is not determined: it has no effect on these records, "
                "like a knot that no sample visits or a unit that is idle."
            )
        others = f" and {self.more} others a little" if self.more else ""
        return (
            f"{list_names(self.names)}{others} are not determined separately: they can move "
            "together without any effect on these records."
        )

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name and the sentence, for JSON."""
        return asdict(self) | {"sentence": self.sentence}


@dataclass(frozen=True, eq=False)
class Inverse:
    """Pseudo-inverse of JᵀJ without undetermined directions."""

    matrix: Numbers
    null: Numbers
    """Orthonormal undetermined directions, in numbers times `scale`; shape (numbers, cut)."""
    scale: Numbers
    """Norms of the columns of J."""
    condition: float
    flat: tuple[Flat, ...]


def invert_normal(square: Numbers, names: Sequence[str], cut: float = CUT) -> Inverse:
    """Invert JᵀJ for eigenvalues above a fraction `cut` of the largest, with scaled columns."""
    norms = np.sqrt(np.diag(square))
    effective = norms > NOTHING * np.max(norms, initial=0.0)
    square = np.where(np.outer(effective, effective), square, 0.0)
    least = NOTHING * float(np.max(norms, initial=0.0)) or 1.0
    scale = np.where(effective, norms, least)
    scaled = square / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    largest = float(values[-1]) if len(values) else 0.0
    determined = values > cut * largest if largest > 0.0 else np.zeros(len(values), dtype=bool)
    safe = np.where(determined, values, 1.0)
    inverse_vectors = vectors * np.where(determined, 1.0 / safe, 0.0)
    matrix = (inverse_vectors @ vectors.T) / np.outer(scale, scale)
    condition = largest / float(np.min(values[determined])) if determined.any() else np.inf
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    flat = _find_flat(root, vectors[:, ~determined], scale, names, np.sqrt(cut * max(largest, 1e-300)))
    return Inverse(matrix, vectors[:, ~determined], scale, condition, tuple(flat))


def _find_flat(root: Numbers, lost: Numbers, scale: Numbers, names: Sequence[str], limit: float) -> list[Flat]:
    """Return the undetermined directions, in the fewest numbers if these are few."""
    if not lost.shape[1]:
        return []
    directions = list(_part_directions(lost).T) if len(names) > MANY else find_weak_directions(root, limit)
    return [_describe_direction(direction / scale, direction, names) for direction in directions]


def _part_directions(lost: Numbers) -> Numbers:
    """Combine the directions so that each contains few parameters."""
    from scipy.linalg import qr

    count = lost.shape[1]
    order = np.asarray(qr(lost.T, pivoting=True, mode="r")[-1], dtype=int)
    return lost @ np.linalg.inv(lost[order[:count]])


def _describe_direction(moves: Numbers, direction: Numbers, names: Sequence[str]) -> Flat:
    size = np.abs(direction)
    order = [int(i) for i in np.argsort(-size, kind="stable") if size[i] > SMALL * size.max()]
    rest = int(np.sum(size > SLIGHT * size.max())) - len(order)
    main_indices = order[:NAMED]
    first = float(moves[main_indices[0]])
    return Flat(
        tuple(names[i] for i in main_indices),
        tuple(float(moves[i]) / first for i in main_indices),
        rest + len(order) - len(main_indices),
    )
