"""Directions in which the free numbers of a chain move unseen, and the sentences that say so.

From JᵀJ with its columns scaled to norm 1: eigenvalues below a share of the largest belong to
directions that the records do not determine. Of few numbers, the smallest sets of them that move
unseen are looked for (`search.weak_direction_sets`); of many, directions are combined so that
each holds one number that no other does, and the largest components of each are named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.linalg import qr

from martensite.identify.blocks.base import Numbers
from martensite.search.quantity_text import list_names
from martensite.search.weak_direction import find_weak_directions

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
    """How many others move a little."""

    @property
    def sentence(self) -> str:
        """What is not determined."""
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
        """All fields by name and the sentence, for JSON."""
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
    """Invert JᵀJ where it can be inverted.

    Args:
        square: JᵀJ.
        names: of the free numbers.
        cut: share of the largest eigenvalue, columns scaled, that is not determined.
    """
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
    """Directions that are cut, in the fewest numbers where these are few enough to try."""
    if not lost.shape[1]:
        return []
    found = list(_part_directions(lost).T) if len(names) > MANY else find_weak_directions(root, limit)
    return [_describe_direction(direction / scale, direction, names) for direction in found]


def _part_directions(lost: Numbers) -> Numbers:
    """The same directions, combined: as many numbers as there are directions are in one each."""
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
