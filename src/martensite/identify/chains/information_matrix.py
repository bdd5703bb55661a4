"""Sums over records that the covariance of the free numbers is made of, in bounded memory.

    H = Σ_t J_tᵀ J_t,    M = Σ_b g_b g_bᵀ,    g_b = Σ_{t in b} J_tᵀ e_t

Residuals e within a block b may depend on each other, those of two blocks are taken to be
independent (Newey and West (1987), Econometrica 55, with a window that is a box of blocks).

Standard errors of what the free numbers of a block mean, by the delta method.

Directions in which the free numbers of a chain move unseen, and the sentences that say so.

From JᵀJ with its columns scaled to norm 1: eigenvalues below a share of the largest belong to
directions that the records do not determine. Of few numbers, the smallest sets of them that move
unseen are looked for (`search.weak_direction_sets`); of many, directions are combined so that
each holds one number that no other does, and the largest components of each are named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.residuals import ResidualSquares
from martensite.search.quantity_text import list_names
from martensite.search.weak_direction import find_weak_directions
from martensite.search.whiteness import count_effective_samples

TIMES = 3.0
"""Length of a block over the time that the residuals remember, τ of `count_effective_samples`."""
LEAST_BLOCKS = 30
"""Blocks of a record at least, if it has as many samples."""


@dataclass(frozen=True, eq=False)
class Sums:
    """Sums of one pass over the records."""

    square: Numbers
    """H."""
    middle: Numbers
    """M."""
    squares: Numbers
    """Sum of the squared weighted residuals of every output of every record."""
    counts: Numbers
    """Number of counted samples of the outputs."""
    blocks: int


def block_lengths(squares: ResidualSquares, theta: Numbers) -> list[int]:
    """Return the samples of a block of every record, from how long its residuals are alike.

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
        most = max(len(errors) // LEAST_BLOCKS, 1)
        found.append(int(min(max(round(TIMES * longest), 1), most)) if longest > 1.5 else 1)
    return found


def sum_blocks(squares: ResidualSquares, theta: Numbers, blocks: Sequence[int]) -> Sums:
    """Return one pass over all records, with blocks of so many samples in each."""
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
    """Yield the number of a block, and the sum of the scores that lie in it."""
    numbers = (first + np.arange(len(scores))) // length
    begins = np.flatnonzero(np.diff(numbers, prepend=-1))
    totals = np.add.reduceat(scores, begins, axis=0)
    yield from zip(numbers[begins].tolist(), totals, strict=True)


STEP = 1e-5
"""Step of central differences, relative to the parameter, or to 1."""
NEGLIGIBLE = 1e-6
"""Change of a value with numbers that are not determined, over the largest value of its kind in
the block, that does not matter: a weight that is 0 whatever the number behind it is."""


class PrintedNumber(NamedTuple):
    """Physical quantity of free parameters, with its standard error."""

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
    """Return the rows of one block, numbered from 1 on, from the covariance of its free numbers.

    `slopes` are derivatives of what is shown, shape (rows, numbers); `undetermined` says which rows depend on
    directions that are not determined, `moved` how much each changes with them.
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
    """Return the derivatives of what is shown with respect to the free numbers, by central differences."""
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


CUT = 1e-9
"""Eigenvalue of the scaled JᵀJ, over the largest, below which a direction is not determined."""
NOTHING = 1e-10
"""Norm of a column of J, over the largest, below which a number has no effect."""
MANY = 24
"""Free numbers up to which the smallest sets are looked for."""
NAMED = 6
"""Numbers named at most for a direction."""
SMALL = 0.1
"""Component, over the largest, below which a number is not named."""
SLIGHT = 0.01
"""Component, over the largest, below which a number is not counted either."""


@dataclass(frozen=True)
class Flat:
    """Numbers that the records do not determine, or do not tell apart."""

    names: tuple[str, ...]
    """The largest mover first."""
    changes: tuple[float, ...]
    """Changes that make up for each other; of a single number 1."""
    more: int
    """Number of other parameters that move a little."""

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
    """The pseudo-inverse of JᵀJ, without the directions that are not determined."""

    matrix: Numbers
    null: Numbers
    """Orthonormal directions that are cut, in numbers times `scale`; shape (numbers, cut)."""
    scale: Numbers
    """Norms of the columns of J."""
    condition: float
    """Largest over smallest eigenvalue that is kept."""
    flat: tuple[Flat, ...]


def invert_normal(square: Numbers, names: Sequence[str], cut: float = CUT) -> Inverse:
    """Invert JᵀJ where it can be inverted: above a share `cut` of the largest eigenvalue, columns scaled."""
    norms = np.sqrt(np.diag(square))
    seen = norms > NOTHING * np.max(norms, initial=0.0)
    square = np.where(np.outer(seen, seen), square, 0.0)
    least = NOTHING * float(np.max(norms, initial=0.0)) or 1.0
    scale = np.where(seen, norms, least)
    scaled = square / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    largest = float(values[-1]) if len(values) else 0.0
    kept = values > cut * largest if largest > 0.0 else np.zeros(len(values), dtype=bool)
    safe = np.where(kept, values, 1.0)
    own = vectors * np.where(kept, 1.0 / safe, 0.0)
    matrix = (own @ vectors.T) / np.outer(scale, scale)
    condition = largest / float(np.min(values[kept])) if kept.any() else np.inf
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    flat = _find_flat(root, vectors[:, ~kept], scale, names, np.sqrt(cut * max(largest, 1e-300)))
    return Inverse(matrix, vectors[:, ~kept], scale, condition, tuple(flat))


def _find_flat(root: Numbers, lost: Numbers, scale: Numbers, names: Sequence[str], limit: float) -> list[Flat]:
    """Return the directions that are cut, in the fewest numbers where these are few enough to try."""
    if not lost.shape[1]:
        return []
    found = list(_part_directions(lost).T) if len(names) > MANY else find_weak_directions(root, limit)
    return [_describe_direction(direction / scale, direction, names) for direction in found]


def _part_directions(lost: Numbers) -> Numbers:
    """Combine the directions so that each contains as few parameters as there are directions."""
    count = lost.shape[1]
    order = np.asarray(qr(lost.T, pivoting=True, mode="r")[-1], dtype=int)
    return lost @ np.linalg.inv(lost[order[:count]])


def _describe_direction(moves: Numbers, direction: Numbers, names: Sequence[str]) -> Flat:
    size = np.abs(direction)
    order = [int(i) for i in np.argsort(-size, kind="stable") if size[i] > SMALL * size.max()]
    rest = int(np.sum(size > SLIGHT * size.max())) - len(order)
    shown = order[:NAMED]
    first = float(moves[shown[0]])
    return Flat(
        tuple(names[i] for i in shown), tuple(float(moves[i]) / first for i in shown), rest + len(order) - len(shown)
    )
