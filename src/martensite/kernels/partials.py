"""All partial derivatives of a kernel from one tracing, those that are zero left out.

Dual numbers whose tangent is not one number but a sparse row: a derivative for each variable
that the value depends on. A kernel of hundreds of parameters is traced once, and what does not
depend on a parameter has no entry for it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from martensite.kernels.dual import Dual, DualNamespace
from martensite.kernels.graph import Expr, GraphNamespace

Row = dict[int, Expr]
"""Number of the variable -> derivative."""


class _Sparse:
    """A tangent: derivatives by variable, with the arithmetic that dual numbers ask for."""

    __slots__ = ("row",)

    def __init__(self, row: dict[int, Any]) -> None:
        self.row = row

    def __add__(self, other: _Sparse) -> _Sparse:
        joined = dict(self.row)
        for i, slope in other.row.items():
            joined[i] = joined[i] + slope if i in joined else slope
        return _Sparse(joined)

    def __sub__(self, other: _Sparse) -> _Sparse:
        return self + (-other)

    def __neg__(self) -> _Sparse:
        return _Sparse({i: -slope for i, slope in self.row.items()})

    def __mul__(self, factor: Any) -> _Sparse:
        return _Sparse({i: slope * factor for i, slope in self.row.items()})

    def __truediv__(self, divisor: Any) -> _Sparse:
        return self * (1.0 / divisor)


class _Choosing(GraphNamespace):
    """The graph's operations; a choice between tangents is one between their entries."""

    def where(self, flag: Any, yes: Any, no: Any) -> Any:
        if not (isinstance(yes, _Sparse) or isinstance(no, _Sparse)):
            return self.graph.apply("where", flag, yes, no)
        a, b = (x.row if isinstance(x, _Sparse) else {} for x in (yes, no))
        keys = [*a, *(i for i in b if i not in a)]
        return _Sparse(
            {i: self.graph.apply("where", flag, a.get(i, 0.0), b.get(i, 0.0)) for i in keys}
        )

    def store(self, x: Any) -> Any:
        return x if isinstance(x, _Sparse) else self.graph.apply("store", x)


class _Partials(DualNamespace):
    """Dual numbers with sparse tangents; loops over what has none stay loops."""

    def repeat(self, count: int, body: Callable[..., Sequence[Any]], *state: Any) -> Sequence[Any]:
        if any(isinstance(s, Dual) for s in state):
            return super().repeat(count, body, *state)
        moved = False

        def turn(*now: Any) -> Sequence[Any]:
            nonlocal moved
            results = body(*now)
            moved = moved or any(isinstance(r, Dual) for r in results)
            return [self.parts(r)[0] for r in results]

        found = self.base.repeat(count, turn, *state)
        return super().repeat(count, body, *state) if moved else found

    def iterate(self, most: int, body: Callable[..., Sequence[Any]], *state: Any) -> Sequence[Any]:
        """A root: its derivatives come from the step of Newton's method behind it."""

        def turn(*now: Any) -> list[Any]:
            return [self.parts(result)[0] for result in body(*now)]

        return self.base.iterate(most, turn, *(self.parts(s)[0] for s in state))

    def each(
        self, body: Callable[..., Sequence[Any]], *columns: Sequence[Any]
    ) -> tuple[Sequence[Any], ...]:
        results = [body(*row) for row in zip(*columns, strict=True)]
        return tuple(zip(*results, strict=True))


def compute_partials(
    xp: GraphNamespace,
    kernel: Callable[[Any, Sequence[Any]], Sequence[Any]],
    variables: Sequence[Expr],
) -> tuple[list[Expr], list[Row]]:
    """Values of `kernel(xp, variables)`, and for each the derivatives that are not zero."""
    base: Any = _Choosing(xp.graph)
    duals = _Partials(base)
    one = xp.graph.constant(1.0)
    moving = [duals.pair(v, _Sparse({i: one})) for i, v in enumerate(variables)]
    pairs = [duals.parts(result) for result in kernel(duals, moving)]
    values = [v if isinstance(v, Expr) else xp.graph.constant(v) for v, _ in pairs]
    return values, [{} if t is None else _list_entries(xp, t) for _, t in pairs]


def _list_entries(xp: GraphNamespace, tangent: _Sparse) -> Row:
    made = {i: s if isinstance(s, Expr) else xp.graph.constant(s) for i, s in tangent.row.items()}
    return {i: s for i, s in made.items() if xp.graph.value_of(s) != 0.0}
