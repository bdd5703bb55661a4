"""Forces of several elements that yield to one another within a step.

The path of element i ends at reach_i - Σ_j give_ij F_j, with a symmetric positive matrix
`give`. Each element solves its own step on the line that is left while the others pull with
guessed forces. Near its answer F̂_i, at the reach ê_i that was left, it is a spring,

    F_i = max{F̂_i + D_i (reach_i - Σ_{j≠i} give_ij F_j - ê_i), 0},

with the slope D_i of its tangent at first, and of the secant of its last two answers then, so
that a transformation counts; a slack one pulls once it is longer than it is free. All these
springs are balanced exactly (`nonnegative`), with any of them slack or taut. Their forces are
the next guess: Newton's method in the laws, while slack and taut need no guess.

The true forces are the minimum of a convex energy, for no element pulls less the further it is
stretched. So plain sweeps, one element after the other (Gauss–Seidel), converge whatever the
elements are, if slowly; every fifth turn is one, in case secants mislead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

TURNS = 60
"""Turns after which forces are taken as they are."""
PLAIN = 5
"""Every so many turns one is a plain sweep."""
CLOSED = 1e-9
"""Error of a force, as a share of it, at which turns end."""
STILL = 1e-13
"""Change of a path [m] from which no secant can be read."""


class LineStepEnd(NamedTuple):
    """An element at the end of a step on a line."""

    state: tuple[float, ...]
    force: float
    """[N]"""
    free: float
    """Elongation [m] from which on its tangent pulls."""
    compliance: float
    """Of its tangent [m/N]."""
    residual: float
    """Of the coupled step of its law and heat."""
    crossing: float
    """Share of a transformation strip crossed by the elastic trial."""


Trial = Callable[[float, float], LineStepEnd]
"""An element's step on the line (reach [m], give [m/N]); commits nothing."""


class ForceBalance(NamedTuple):
    """Elements in balance with each other."""

    answers: list[LineStepEnd]
    error: float
    """Largest error of a force, as a share of it."""
    asked: int
    """How often all elements were asked."""


class ElementTurn(NamedTuple):
    """One element in a turn."""

    reach: float
    """What the others left of its line [m]."""
    answer: LineStepEnd


def compute_share(missed: float, answer: LineStepEnd, give: float, least: float) -> float:
    """What a path that ends elsewhere by `missed` [m] does to a force, as a share of it."""
    return abs(missed) / (answer.compliance + give) / (answer.force + least)


def settle_lines(
    trials: Sequence[Trial],
    reach: Sequence[float],
    give: Sequence[Sequence[float]],
    forces: Sequence[float],
    least: Sequence[float],
) -> ForceBalance:
    """All elements on their lines at once.

    Args:
        trials: the elements.
        reach: elongation of each path without any force [m].
        give: how much path i yields to force j [m/N], row by row.
        forces: a guess [N].
        least: force [N] of each element that counts as one.
    """
    if len(trials) == 1:
        return ForceBalance([trials[0](reach[0], give[0][0])], 0.0, 1)
    now, before = list(forces), list[ElementTurn]()
    for turn in range(1, TURNS + 1):
        plain = turn % PLAIN == 0
        seen, error = _ask_elements(trials, reach, give, now, least, in_turn=plain)
        if not error > CLOSED or turn == TURNS:
            break
        found = [one.answer.force for one in seen]
        now = found if plain else _solve_springs(reach, give, now, seen, before)
        before = seen
    return ForceBalance([one.answer for one in seen], error, turn)


def _ask_elements(
    trials: Sequence[Trial],
    reach: Sequence[float],
    give: Sequence[Sequence[float]],
    forces: Sequence[float],
    least: Sequence[float],
    *,
    in_turn: bool,
) -> tuple[list[ElementTurn], float]:
    """What all elements answer, and the largest error of what they met.

    With `in_turn` each one meets what those before it have just answered.
    """
    met, seen = list(forces), list[ElementTurn]()
    for i, trial in enumerate(trials):
        left = reach[i] - _sum_others(give[i], met, i)
        seen.append(ElementTurn(left, trial(left, give[i][i])))
        if in_turn:
            met[i] = seen[i].answer.force
    found = [one.answer.force for one in seen]
    errors = [
        compute_share(reach[i] - _sum_others(give[i], found, i) - left, answer, give[i][i], least[i])
        for i, (left, answer) in enumerate(seen)
    ]
    return seen, float(np.max(errors))


def _sum_others(row: Sequence[float], forces: Sequence[float], own: int) -> float:
    return sum(s * f for j, (s, f) in enumerate(zip(row, forces, strict=True)) if j != own)


def _solve_springs(
    reach: Sequence[float],
    give: Sequence[Sequence[float]],
    forces: Sequence[float],
    seen: Sequence[ElementTurn],
    before: Sequence[ElementTurn],
) -> list[float]:
    matrix, free = np.array(give), np.zeros(len(seen))
    for i, one in enumerate(seen):
        yields = _compute_yield(one, before[i] if before else None, give[i][i])
        taut = one.answer.force > 0.0
        free[i] = one.reach - one.answer.force * yields if taut else one.answer.free
        matrix[i, i] = yields
    return solve_nonnegative(matrix, np.array(reach) - free, np.array(forces)).tolist()


def _compute_yield(one: ElementTurn, before: ElementTurn | None, give: float) -> float:
    """Reach per force [m/N] of an element on its line: of the secant, or else of the tangent."""
    least = one.answer.compliance + give
    if before is None or min(one.answer.force, before.answer.force) <= 0.0:
        return least
    drawn, pulled = one.reach - before.reach, one.answer.force - before.answer.force
    if abs(drawn) < STILL or not abs(pulled) > abs(drawn) * 1e-6 / least:
        return least
    return max(drawn / pulled, least)


def solve_nonnegative(matrix: np.ndarray, right: np.ndarray, start: np.ndarray) -> np.ndarray:
    """F ≥ 0 with A F ≥ b, and equal where F > 0, for symmetric positive A.

    The minimum of F·AF/2 - b·F by active sets, after Lawson & Hanson, Solving Least Squares
    Problems (1974), chapter 23; it ends after finitely many exchanges.

    Args:
        matrix: A.
        right: b.
        start: a guess.
    """
    now = np.maximum(start, 0.0)
    taut = now > 0.0
    if taut.all():  # as a rule it stays so
        aim = np.linalg.solve(matrix, right)
        if (aim > 0.0).all():
            return aim
    for _ in range(10 * len(now)):
        while True:
            aim = np.zeros_like(now)
            aim[taut] = np.linalg.solve(matrix[np.ix_(taut, taut)], right[taut])
            falls = taut & (aim <= 0.0)
            if not falls.any():
                break
            part = np.min(now[falls] / (now[falls] - aim[falls]))
            now = now + part * (aim - now)
            taut &= ~(falls & (now <= 1e-12 * np.max(now, initial=0.0)))
            now[~taut] = 0.0
        now = aim
        pulls = np.where(taut, 0.0, right - matrix @ now)
        if not pulls.max() > 1e-12 * np.abs(right).max():
            break
        taut[pulls.argmax()] = True
    return now
