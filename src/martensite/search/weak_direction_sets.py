"""Which parameters the data cannot tell apart: the smallest sets of them.

For a Jacobian J a unit vector v with ‖J v‖ ≤ limit is a direction in which the parameters may
move unseen. Singular vectors of J with such singular values span all of these, but mix them:
with two redundancies at once every singular vector holds the parameters of both. So the
smallest sets of parameters are looked for whose columns alone have a singular value within the
limit, and as many independent ones are kept as J has such singular values. That many exist:
without any k of its columns J has at most k fewer (singular values interlace).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.search.scaled_jacobian import reduce_rows

Matrix: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = NDArray[np.float64]
MANY_SETS = 20_000
"""Sets of one size that are all tried; larger sizes are approached by leaving columns out."""
_INDEPENDENT = 1e-3


def find_weak_directions(
    jacobian: Matrix,
    limit: float,
    known: Sequence[Vector] = (),
    prefer: Callable[[Vector], bool] = lambda direction: False,
) -> list[Vector]:
    """Independent unit vectors v of few components each with ‖J v‖ ≤ limit.

    Args:
        jacobian: (rows, parameters).
        limit: of ‖J v‖; as in `jacobian`.
        known: directions found before; counted, but not returned.
        prefer: which of two directions with equally many components to name first.
    """
    square = reduce_rows(jacobian)
    wanted = int(np.sum(np.linalg.svd(square, compute_uv=False) <= limit))
    chosen = list(known)
    sets: list[tuple[int, ...]] = []
    for size in range(1, square.shape[1] + 1):
        if len(chosen) >= wanted or math.comb(square.shape[1], size) > MANY_SETS:
            break
        found = _search_sets(square, limit, size, sets)
        sets += [tuple(np.flatnonzero(v).tolist()) for v in found]
        for direction in sorted(found, key=lambda v: not prefer(v)):
            if len(chosen) < wanted and _is_independent(direction, chosen):
                chosen.append(direction)
    return (chosen + _search_by_elimination(square, limit, chosen, wanted))[len(known) :]


def _search_sets(square: Matrix, limit: float, size: int, smaller: Sequence[tuple[int, ...]]) -> list[Vector]:
    """Weak directions of all sets of one size that hold no smaller one; the weakest first."""
    held = [set(one) for one in smaller]
    sets = [one for one in combinations(range(square.shape[1]), size) if not any(small <= set(one) for small in held)]
    if not sets:
        return []
    columns = np.moveaxis(square[:, np.asarray(sets)], 0, 1)
    _, sizes, right = np.linalg.svd(columns, full_matrices=False)
    weak = [int(i) for i in np.argsort(sizes[:, -1], kind="stable") if sizes[i, -1] <= limit]
    return [_embed_vector(right[i, -1], sets[i], square.shape[1]) for i in weak]


def _search_by_elimination(square: Matrix, limit: float, chosen: Sequence[Vector], wanted: int) -> list[Vector]:
    """The directions still missing, of as few components as leaving columns out one by one finds.

    Of every direction known the largest mover is held fixed, so that the next one is another.
    """
    kept = list(range(square.shape[1]))
    found: list[Vector] = []
    for direction in chosen:
        kept.remove(max(kept, key=lambda i: abs(float(direction[i]))))
    while len(chosen) + len(found) < wanted and _find_weakest(square, kept)[0] <= limit:
        direction = _eliminate_columns(square, kept, limit)
        found += [direction] if _is_independent(direction, [*chosen, *found]) else []
        kept.remove(int(np.argmax(np.abs(direction))))
    return found


def _eliminate_columns(square: Matrix, columns: Sequence[int], limit: float) -> Vector:
    """A weak direction of which no component can be left out."""
    left = list(columns)
    while True:
        _, direction = _find_weakest(square, left)
        for place in sorted(left, key=lambda i: abs(float(direction[i]))):
            fewer = [i for i in left if i != place]
            if fewer and _find_weakest(square, fewer)[0] <= limit:
                left = fewer
                break
        else:
            return direction


def _find_weakest(square: Matrix, columns: Sequence[int]) -> tuple[float, Vector]:
    """Smallest singular value of some columns, and its vector among all parameters."""
    if not columns:
        return math.inf, _embed_vector(np.zeros(0), columns, square.shape[1])
    _, sizes, right = np.linalg.svd(square[:, np.asarray(columns)], full_matrices=False)
    return float(sizes[-1]), _embed_vector(right[-1], columns, square.shape[1])


def _embed_vector(part: Vector, columns: Sequence[int], count: int) -> Vector:
    """A vector over some columns as one over all."""
    whole: Vector = np.zeros(count)
    whole[list(columns)] = part
    return whole


def _is_independent(direction: Vector, others: Sequence[Vector]) -> bool:
    if not others:
        return True
    basis = np.linalg.qr(np.stack(others, axis=1))[0]
    return float(np.linalg.norm(direction - basis @ (basis.T @ direction))) > _INDEPENDENT
