"""Weak directions: small sets of parameters that the data do not determine.

For a Jacobian J, a unit vector v with ‖J v‖ ≤ limit is a direction without a visible effect. Singular vectors of J with
such singular values span all of these, but mix separate redundancies. The search therefore finds the smallest sets of
parameters whose columns alone have a singular value within the limit. It keeps as many independent sets as J has such
singular values. These exist: without any k of its columns, J has at most k fewer (singular values interlace).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.formats import choose_difference_unit
from martensite.search.quantity_text import format_change, format_number, format_quotient, join_phrases, list_names
from martensite.search.scaled_jacobian import is_gauge, reduce_rows

Matrix: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = NDArray[np.float64]
MANY_SETS = 20_000
"""Largest number of sets of one size for a full search; larger sizes use elimination of columns."""
_INDEPENDENT = 1e-3
UNSEEN = 1e-6
"""Change of the error, as a fraction of its noise, below which no value is reported."""


@dataclass(frozen=True)
class WeakDirection:
    """Undetermined parameter, or set of confounded parameters."""

    names: tuple[str, ...]
    """Parameters, the largest relative change first."""
    units: tuple[str, ...]
    """SI unit of each."""
    changes: tuple[float, ...]
    """Changes that compensate to first order, each in its SI unit; for a single parameter its whole range."""
    relative: tuple[float, ...]
    """Changes as fractions of the values; NaN for values of 0."""
    uncertainty: float
    """Standard error along the direction in search ranges; infinite if `exact`."""
    effect: float
    """Root-mean-square change of the error under `changes`, in units of its noise."""
    exact: bool
    """True if there is no effect at all, so that more exact data of this kind would not help."""

    @property
    def gauge(self) -> bool:
        """Return whether two or more parameters all move in proportion to their values."""
        return is_gauge(self.relative)

    @property
    def sentence(self) -> str:
        """Return a sentence on the undetermined parameters, with amounts in everyday units."""
        if len(self.names) == 1:
            return self._single()
        return f"{self._describe_names()}: {self._moves()} {self._outcome()}."

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name and the sentence, for JSON."""
        return asdict(self) | {"gauge": self.gauge, "sentence": self.sentence}

    def _single(self) -> str:
        name = self.names[0]
        if self.exact:
            return f"`{name}` is not determined: it has no effect on the error."
        move = f"its whole range, {format_change(abs(self.changes[0]), self.units[0])},"
        return f"`{name}` is not determined: {move} {self._outcome()}."

    def _describe_names(self) -> str:
        first, second, *others = self.names
        if others:
            return f"{list_names(self.names)} are not determined separately"
        if self.gauge:
            ratio = self.relative[0] * self.relative[1] > 0.0
            kind = f"ratio of {list_names(self.names)}" if ratio else f"product of {list_names(self.names)}"
            return f"Only the {kind} is determined"
        (top, one), (bottom, other) = map(choose_difference_unit, self.units)
        slope = -(self.changes[0] / one) / (self.changes[1] / other)
        factor = f"{format_number(abs(slope))} {format_quotient(top, bottom)}".strip()
        sign = "+" if slope > 0.0 else "-"
        return f"Only the combination `{first}` {sign} {factor} × `{second}` is determined"

    def _moves(self) -> str:
        if self.gauge:
            up, down = self._part_phrases(list(self.names), [r / self.relative[0] for r in self.relative])
            dividing = f" and dividing {list_names(down)}" if down else ""
            return f"multiplying {list_names(up)}{dividing} by the same factor"
        amounts = zip(self.names, self.changes, self.units, strict=True)
        phrases = [f"`{name}` by {format_change(abs(move), unit)}" for name, move, unit in amounts]
        up, down = self._part_phrases(phrases, self.changes)
        if not down:
            return f"raising {up[0]} together with {join_phrases(up[1:])}"
        return f"raising {join_phrases(up)} while lowering {join_phrases(down)}"

    def _outcome(self) -> str:
        share = "less than a millionth" if self.effect < UNSEEN else format_number(self.effect, 2)
        factor = f" for a factor of {format_number(1.0 + abs(self.relative[0]))}" if self.gauge else ""
        if not self.exact:
            return f"changes the error by only {share} of its noise{factor}"
        return f"changes nothing (the error changes by {share} of its noise{factor})"

    @staticmethod
    def _part_phrases(phrases: list[str], signs: Sequence[float]) -> tuple[list[str], list[str]]:
        """Return the phrases of the rising and of the falling parameters."""
        pairs = list(zip(phrases, signs, strict=True))
        return [p for p, s in pairs if s > 0.0], [p for p, s in pairs if not s > 0.0]


def find_weak_directions(
    jacobian: Matrix,
    limit: float,
    previous_directions: Sequence[Vector] = (),
    prefer: Callable[[Vector], bool] = lambda direction: False,
) -> list[Vector]:
    """Return the independent sparse unit vectors v with ‖J v‖ ≤ limit that are not known already.

    `prefer` selects the first of two directions with equally many components.
    """
    square = reduce_rows(jacobian)
    wanted = int(np.sum(np.linalg.svd(square, compute_uv=False) <= limit))
    chosen = list(previous_directions)
    sets: list[tuple[int, ...]] = []
    for size in range(1, square.shape[1] + 1):
        if len(chosen) >= wanted or math.comb(square.shape[1], size) > MANY_SETS:
            break
        directions = _search_sets(square, limit, size, sets)
        sets += [tuple(np.flatnonzero(v).tolist()) for v in directions]
        for direction in sorted(directions, key=lambda v: not prefer(v)):
            if len(chosen) < wanted and _is_independent(direction, chosen):
                chosen.append(direction)
    return (chosen + _search_by_elimination(square, limit, chosen, wanted))[len(previous_directions) :]


def _search_sets(square: Matrix, limit: float, size: int, smaller: Sequence[tuple[int, ...]]) -> list[Vector]:
    """Return the weak directions of all minimal sets of one size, the weakest first."""
    smaller_sets = [set(one) for one in smaller]
    sets = [
        one
        for one in combinations(range(square.shape[1]), size)
        if not any(small <= set(one) for small in smaller_sets)
    ]
    if not sets:
        return []
    columns = np.moveaxis(square[:, np.asarray(sets)], 0, 1)
    _, sizes, right = np.linalg.svd(columns, full_matrices=False)
    weak = [int(i) for i in np.argsort(sizes[:, -1], kind="stable") if sizes[i, -1] <= limit]
    return [_embed_vector(right[i, -1], sets[i], square.shape[1]) for i in weak]


def _search_by_elimination(square: Matrix, limit: float, chosen: Sequence[Vector], wanted: int) -> list[Vector]:
    """Return the missing directions by elimination of columns.

    The largest component of every known direction is fixed, so that the next direction differs.
    """
    columns = list(range(square.shape[1]))
    directions: list[Vector] = []
    for direction in chosen:
        columns.remove(max(columns, key=lambda i: abs(float(direction[i]))))
    while len(chosen) + len(directions) < wanted and _find_weakest(square, columns)[0] <= limit:
        direction = _eliminate_columns(square, columns, limit)
        directions += [direction] if _is_independent(direction, [*chosen, *directions]) else []
        columns.remove(int(np.argmax(np.abs(direction))))
    return directions


def _eliminate_columns(square: Matrix, columns: Sequence[int], limit: float) -> Vector:
    """Return a weak direction without superfluous components."""
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
    """Return the smallest singular value of some columns, and its vector in all parameters."""
    if not columns:
        return math.inf, _embed_vector(np.zeros(0), columns, square.shape[1])
    _, sizes, right = np.linalg.svd(square[:, np.asarray(columns)], full_matrices=False)
    return float(sizes[-1]), _embed_vector(right[-1], columns, square.shape[1])


def _embed_vector(part: Vector, columns: Sequence[int], count: int) -> Vector:
    whole: Vector = np.zeros(count)
    whole[list(columns)] = part
    return whole


def _is_independent(direction: Vector, others: Sequence[Vector]) -> bool:
    if not others:
        return True
    basis = np.linalg.qr(np.stack(others, axis=1))[0]
    return float(np.linalg.norm(direction - basis @ (basis.T @ direction))) > _INDEPENDENT
