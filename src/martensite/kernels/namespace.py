"""The operations a kernel may use, and the two types it sees.

`Scalar` and `Flag` are written as float and bool: to a kernel every runtime's number *is* a
float. At run time it may be a float, an array, a node of an expression graph or a dual
number. Rules for kernels: straight line (no `if`, `and`, `or`, `not`, `while` on values;
loops of fixed count only), choices by `where`, whose unused side must be safe to evaluate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

Scalar: TypeAlias = float
Flag: TypeAlias = bool


# pyright: reportReturnType=false
class Namespace(Protocol):
    """Functions that a runtime must offer; arithmetic and comparisons are operators."""

    def where(self, flag: Flag, yes: Scalar, no: Scalar, /) -> Scalar:
        """`yes` where the flag holds, else `no`; both are evaluated."""

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
        """`x` limited to [low, high]."""

    def abs(self, x: Scalar, /) -> Scalar:
        """Return the absolute value."""

    def sqrt(self, x: Scalar, /) -> Scalar:
        """Return the square root; 0 for negative arguments."""

    def exp(self, x: Scalar, /) -> Scalar:
        """Exponential; the argument is limited to 700."""

    def log(self, x: Scalar, /) -> Scalar:
        """Return the natural logarithm; the argument is at least 1e-300."""

    def power(self, base: Scalar, exponent: Scalar, /) -> Scalar:
        """`base` to the `exponent`, for a base above 0; at most 1e304.

        At a base of 0 or below it is 0, and so are its slopes, whatever the exponent; just above
        0 the slope of a power below 1 has no limit. A whole exponent that is written as such (`3`,
        not `3.0`) is multiplied out, as in `base ** 3`, for a base of any sign.
        """

    def sin(self, x: Scalar, /) -> Scalar:
        """Sine."""

    def cos(self, x: Scalar, /) -> Scalar:
        """Cosine."""

    def tanh(self, x: Scalar, /) -> Scalar:
        """Return the hyperbolic tangent."""

    def nearest(self, x: Scalar, /) -> Scalar:
        """Return the nearest whole number, the even one of two.

        To differentiation it is `x` itself: a staircase has no derivative that is of use.
        """

    def quarter_sine(self, x: Scalar, /) -> Scalar:
        """sin(πx/2) for 0 ≤ x ≤ 1 only, accurate to the last digits near 0."""

    def erfcx(self, x: Scalar, /) -> Scalar:
        """exp(x²) erfc(x) for x ≥ 0 only: the scaled complementary error function."""

    def each(self, body: Callable[..., Sequence[Scalar]], *columns: Sequence[Scalar]) -> tuple[Sequence[Scalar], ...]:
        """Return the columns of results of `body` over the rows of equally long columns.

        Traced, the body is one loop instead of as many copies as there are rows.
        """

    def repeat(self, count: int, body: Callable[..., Sequence[Scalar]], *state: Scalar) -> Sequence[Scalar]:
        """Return the state after `count` turns of `body`, as one loop."""

    def iterate(self, most: int, body: Callable[..., Sequence[Scalar]], *state: Scalar) -> Sequence[Scalar]:
        """Return the state after turns of `body` for as long as its first number is above 0.

        At most `most` turns, none if that number is 0 from the beginning. Every lane of a batch
        stops by itself.
        """

    def detach(self, x: Scalar, /) -> Scalar:
        """`x` itself, but a constant to differentiation."""

    def implicit_root(self, root: Scalar, newton: Scalar, /) -> Scalar:
        """`root`, with the derivatives of `newton`: a step of Newton's method from that root.

        The step must start at `detach(root)`. Only derivatives evaluate it, and they need not
        follow the iterations that led to the root. First derivatives are those of the root;
        further ones are those of the step.
        """

    def eps(self) -> Scalar:
        """Return the distance from 1 to the next number of the working precision."""


OPERATIONS = frozenset(name for name in vars(Namespace) if not name.startswith("_"))
"""Names of all operations."""
