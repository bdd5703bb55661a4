"""Operations and types of kernels.

`Scalar` and `Flag` are written as float and bool. At run time a number may be a float, an array, a node of an
expression graph or a dual number. Kernels are straight lines: no `if`, `and`, `or`, `not` or `while` on values, and
loops of fixed count only. Choices use `where`, and both sides must be safe to evaluate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

Scalar: TypeAlias = float
Flag: TypeAlias = bool


class Namespace(Protocol):
    """Functions that a runtime must offer; arithmetic and comparisons are operators."""

    def where(self, flag: Flag, yes: Scalar, no: Scalar, /) -> Scalar:
        """Return `yes` if the flag holds, otherwise `no`; both are evaluated."""

    def both(self, a: Flag, b: Flag, /) -> Flag:
        """Return the logical and."""

    def either(self, a: Flag, b: Flag, /) -> Flag:
        """Return the logical or."""

    def negate(self, a: Flag, /) -> Flag:
        """Return the logical not."""

    def minimum(self, a: Scalar, b: Scalar, /) -> Scalar:
        """Return the smaller of two."""

    def maximum(self, a: Scalar, b: Scalar, /) -> Scalar:
        """Return the larger of two."""

    def clip(self, x: Scalar, low: Scalar, high: Scalar, /) -> Scalar:
        """Return `x` limited to [low, high]."""

    def abs(self, x: Scalar, /) -> Scalar:
        """Return the absolute value."""

    def sqrt(self, x: Scalar, /) -> Scalar:
        """Return the square root; 0 for negative arguments."""

    def exp(self, x: Scalar, /) -> Scalar:
        """Return the exponential; the argument is limited to 700."""

    def log(self, x: Scalar, /) -> Scalar:
        """Return the natural logarithm; the argument is at least 1e-300."""

    def power(self, base: Scalar, exponent: Scalar, /) -> Scalar:
        """Return `base` to the `exponent`, for a base above 0; at most 1e304.

        For a base of 0 or below, the result and its derivatives are 0. Near 0 the derivative of a power below 1 is
        unbounded. A
        literal whole exponent (`3`, not `3.0`) is multiplied out, as in `base ** 3`, for a base of any sign.
        """

    def sin(self, x: Scalar, /) -> Scalar:
        """Return the sine."""

    def cos(self, x: Scalar, /) -> Scalar:
        """Return the cosine."""

    def tanh(self, x: Scalar, /) -> Scalar:
        """Return the hyperbolic tangent."""

    def nearest(self, x: Scalar, /) -> Scalar:
        """Return the nearest whole number, the even number of two.

        Differentiation takes it as `x`, because a staircase has no useful derivative.
        """

    def quarter_sine(self, x: Scalar, /) -> Scalar:
        """Return sin(πx/2) for 0 ≤ x ≤ 1 only, accurate to the last digits near 0."""

    def erfcx(self, x: Scalar, /) -> Scalar:
        """Return exp(x²) erfc(x), the scaled complementary error function, for x ≥ 0 only."""

    def each(self, body: Callable[..., Sequence[Scalar]], *columns: Sequence[Scalar]) -> tuple[Sequence[Scalar], ...]:
        """Return the columns of results of `body` over the rows of equally long columns.

        When traced, the body is one loop and not a copy per row.
        """

    def scan(
        self, body: Callable[..., Sequence[Scalar]], begin: Sequence[Scalar], *columns: Sequence[Scalar]
    ) -> tuple[Sequence[Scalar], ...]:
        """Return the columns of results of `body(*state, *row)` over the rows of equally long columns.

        The first results are the state of the next row. The state of the first row is `begin`, so the last state is the
        last row of the first columns. When traced, the body is one loop.
        """

    def repeat(self, count: int, body: Callable[..., Sequence[Scalar]], *state: Scalar) -> Sequence[Scalar]:
        """Return the state after `count` iterations of `body`, as one loop."""

    def iterate(self, most: int, body: Callable[..., Sequence[Scalar]], *state: Scalar) -> Sequence[Scalar]:
        """Return the state after iterations of `body` while its first variable is above 0.

        There are at most `most` iterations. Every batch element stops separately.
        """

    def detach(self, x: Scalar, /) -> Scalar:
        """Return `x`, as a constant for differentiation."""

    def implicit_root(self, root: Scalar, newton: Scalar, /) -> Scalar:
        """Return `root`, with the derivatives of `newton`, a Newton step from this root.

        The step must start at `detach(root)`. Only derivatives evaluate it, and they need not follow the iterations.
        First
        derivatives belong to the root, higher derivatives to the step.
        """

    def eps(self) -> Scalar:
        """Return the distance from 1 to the next number of the working precision."""


OPERATIONS = frozenset(name for name in vars(Namespace) if not name.startswith("_"))
"""Names of all operations."""
