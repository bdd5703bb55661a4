"""Where a map comes to rest: Newton's method in a loop, with the derivatives of the root."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from martensite.actuators.mechanics.elimination import solve_linear
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar

TURNS = 30
"""Steps of Newton's method."""
Column = Sequence[Scalar]
Map = Callable[[Namespace, Column, Column], Column]
"""The next state, from the state and what the map depends on besides."""


def fixed_point(xp: Namespace, held: Map, start: Column, given: Column) -> list[Scalar]:
    """The state s = held(xp, s, given) that is reached from a start.

    Derivatives are those of the root with respect to what is given, not of the iteration.
    """
    fixed = [xp.detach(value) for value in given]

    def turn(*state: Scalar) -> Column:
        step = _compute_newton_step(xp, held, state, fixed, fixed)
        return [s - d for s, d in zip(state, step, strict=True)]

    root = xp.repeat(TURNS, turn, *(xp.detach(s) for s in start))
    root = [xp.detach(s) for s in root]
    newton = _compute_newton_step(xp, held, root, fixed, given)
    return [xp.implicit_root(s, s - d) for s, d in zip(root, newton, strict=True)]


def _compute_newton_step(xp: Namespace, held: Map, state: Column, fixed: Column, given: Column) -> list[Scalar]:
    """Newton's step: the matrix at what is fixed, the residual at what is given."""

    def away(xp: Namespace, s: Column) -> Column:
        return [a - b for a, b in zip(s, held(xp, s, fixed), strict=True)]

    _, matrix = compute_jacobian(xp, away, list(state))
    residual = [a - b for a, b in zip(state, held(xp, state, given), strict=True)]
    return solve_linear(matrix, [residual])[0]
