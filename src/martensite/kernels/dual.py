"""Dual numbers over any runtime: exact derivatives for the solvers, without derivatives in a law.

`value_and_slope(xp, f, x)` runs `f` once on (value, tangent) pairs. Traced into a graph, it costs only the arithmetic
of the derivative. Zero tangents are `None`, so constants stay constants.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from itertools import compress
from typing import Any

from martensite.kernels import floats
from martensite.kernels.floats import HALF_PI, ROOT_PI, expand_power
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.traced_numbers import TracedNumber, make_operation_error

Tangent = Any
Pair = tuple[Any, Tangent]


def compare_values(comparison: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """Return a comparison of dual numbers by their values."""

    def compare(a: Dual, b: Any) -> Any:
        _, (v, _), (w, _) = raise_levels(a, b)
        return comparison(v, w)

    return compare


class Dual(TracedNumber):
    """Value with its derivative with respect to the variable of one level.

    Derivatives may be nested: to a dual number, numbers of a lower level are constants.
    """

    __slots__ = ("level", "tangent", "value")
    takes_arrays = True  # and leaves mixed arithmetic with arrays to this class

    def __init__(self, value: Any, tangent: Tangent, level: int) -> None:
        self.value = value
        self.tangent = tangent
        self.level = level

    def __add__(self, other: Any) -> Dual:
        level, (v, t), (w, s) = raise_levels(self, other)
        return Dual(v + w, add_tangents(t, s), level)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, None if self.tangent is None else -self.tangent, self.level)

    def __sub__(self, other: Any) -> Dual:
        level, (v, t), (w, s) = raise_levels(self, other)
        return Dual(v - w, subtract_tangents(t, s), level)

    def __rsub__(self, other: Any) -> Dual:
        level, (v, t), (w, s) = raise_levels(self, other)
        return Dual(w - v, subtract_tangents(s, t), level)

    def __mul__(self, other: Any) -> Dual:
        level, (v, t), (w, s) = raise_levels(self, other)
        return Dual(v * w, add_tangents(scale_tangent(t, w), scale_tangent(s, v)), level)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        level, top, bottom = raise_levels(self, other)
        return divide_duals(top, bottom, level)

    def __rtruediv__(self, other: Any) -> Dual:
        level, bottom, top = raise_levels(self, other)
        return divide_duals(top, bottom, level)

    __lt__, __le__, __gt__, __ge__ = map(compare_values, (operator.lt, operator.le, operator.gt, operator.ge))


def split_dual(x: Any, level: int) -> Pair:
    """Return the value and tangent of a number at a level."""
    if isinstance(x, Dual) and x.level == level:
        return x.value, x.tangent
    return x, None


def raise_levels(a: Dual, b: Any) -> tuple[int, Pair, Pair]:
    """Return the higher level of two numbers, and both at this level."""
    level = max(a.level, b.level) if isinstance(b, Dual) else a.level
    return level, split_dual(a, level), split_dual(b, level)


def add_tangents(a: Tangent, b: Tangent) -> Tangent:
    """Return the sum of two tangents."""
    if a is None or b is None:
        return b if a is None else a
    return a + b


def subtract_tangents(a: Tangent, b: Tangent) -> Tangent:
    """Return the difference of two tangents."""
    if b is None:
        return a
    return -b if a is None else a - b


def scale_tangent(a: Tangent, factor: Any) -> Tangent:
    """Return a tangent times a value."""
    return None if a is None else a * factor


def divide_duals(top: Pair, bottom: Pair, level: int) -> Dual:
    """Return the quotient of two (value, tangent) pairs."""
    ratio = top[0] / bottom[0]
    change = subtract_tangents(top[1], scale_tangent(bottom[1], ratio))
    return Dual(ratio, None if change is None else change / bottom[0], level)


def chain_rule(operation: str, slope: Callable[[Any, Any, Any], Any]) -> Callable[..., Any]:
    """Return a function of one number, from its derivative as a function of base, argument and value."""

    def apply(xp: DualNamespace, x: Any) -> Any:
        v, t = xp.parts(x)
        value = getattr(xp.base, operation)(v)
        return xp.pair(value, None if t is None else t * slope(xp.base, v, value))

    return apply


class DualNamespace:
    """Kernel operations on dual numbers, built on any other namespace."""

    zero: Any = 0.0
    """Explicit tangent of a constant."""

    def __init__(self, base: Namespace) -> None:
        self.base: Any = base
        self.level: int = getattr(base, "level", 0) + 1
        self.both, self.either, self.negate, self.eps = base.both, base.either, base.negate, base.eps

    def __getattr__(self, operation: str) -> Any:
        raise make_operation_error(operation)

    def parts(self, x: Any) -> Pair:
        """Return the value and tangent at this namespace's level."""
        return split_dual(x, self.level)

    def pair(self, value: Any, tangent: Tangent) -> Any:
        """Return a dual number, or the bare value if it is constant."""
        return value if tangent is None else Dual(value, tangent, self.level)

    def where(self, flag: Any, yes: Any, no: Any) -> Any:
        """Return the choice of value and tangent."""
        (yv, yt), (nv, nt) = self.parts(yes), self.parts(no)
        value = self.base.where(flag, yv, nv)
        if yt is None and nt is None:
            return value
        yt, nt = self.zero if yt is None else yt, self.zero if nt is None else nt
        return self.pair(value, self.base.where(flag, yt, nt))

    def minimum(self, a: Any, b: Any) -> Any:
        """Return the smaller of two."""
        return self.where(self.parts(a)[0] < self.parts(b)[0], a, b)

    def maximum(self, a: Any, b: Any) -> Any:
        """Return the larger of two."""
        return self.where(self.parts(a)[0] > self.parts(b)[0], a, b)

    def clip(self, x: Any, low: Any, high: Any) -> Any:
        """Return `x` limited to [low, high], with derivative 0 outside."""
        return self.minimum(self.maximum(x, low), high)

    def abs(self, x: Any) -> Any:
        """Return the absolute value."""
        v, t = self.parts(x)
        return self.pair(self.base.abs(v), None if t is None else self.base.where(v < 0.0, -t, t))

    def sqrt(self, x: Any) -> Any:
        """Return the square root; derivative 0 for arguments that are not positive."""
        v, t = self.parts(x)
        root = self.base.sqrt(v)
        if t is None:
            return root
        safe = self.base.where(v > 0.0, root, 1.0)
        return self.pair(root, self.base.where(v > 0.0, t * (0.5 / safe), self.zero))

    exp = chain_rule("exp", lambda base, v, value: value)
    log = chain_rule("log", lambda base, v, value: 1.0 / base.maximum(v, 1e-300))
    sin = chain_rule("sin", lambda base, v, value: base.cos(v))
    tanh = chain_rule("tanh", lambda base, v, value: 1.0 - value * value)
    quarter_sine = chain_rule("quarter_sine", lambda base, v, value: HALF_PI * base.quarter_sine(1.0 - v))
    erfcx = chain_rule("erfcx", lambda base, v, value: 2.0 * v * value - 2.0 / ROOT_PI)

    def power(self, base: Any, exponent: Any) -> Any:
        """Return `base` to the `exponent`; derivatives 0 for a base that is not positive."""
        if isinstance(exponent, int):
            return expand_power(base, exponent)
        (v, t), (e, s) = self.parts(base), self.parts(exponent)
        value = self.base.power(v, e)
        safe = self.base.where(v > 0.0, v, 1.0)
        by_base = None if t is None else t * (e * value / safe)
        by_exponent = None if s is None else s * (value * self.base.log(safe))
        return self.pair(value, add_tangents(by_base, by_exponent))

    def cos(self, x: Any) -> Any:
        """Return the cosine."""
        v, t = self.parts(x)
        value = self.base.cos(v)
        return self.pair(value, None if t is None else -(t * self.base.sin(v)))

    def nearest(self, x: Any) -> Any:
        """Return the nearest whole number, with the tangent of `x`."""
        v, t = self.parts(x)
        return self.pair(self.base.nearest(v), t)

    def each(self, body: Callable[..., Sequence[Any]], *columns: Sequence[Any]) -> tuple[Sequence[Any], ...]:
        """Return the columns of values and tangents through the base's loop."""
        return self.scan(body, (), *columns)

    def scan(
        self, body: Callable[..., Sequence[Any]], begin: Sequence[Any], *columns: Sequence[Any]
    ) -> tuple[Sequence[Any], ...]:
        """Return the columns of values and tangents through the base's loop."""
        table = [[self.parts(item) for item in column] for column in columns]
        moving = [any(tangent is not None for _, tangent in column) for column in table]
        rows = [self.split(row, moving) for row in zip(*table, strict=True)]
        first = [self.parts(one) for one in begin]
        size = len(first)

        def trace(carried: list[bool]) -> tuple[list[list[Any]], list[bool]]:
            start, flags = self.split(first, carried), list[bool]()

            def inner(*numbers: Any) -> list[Any]:
                row = self.join(numbers[len(start) :], moving)
                results = [self.parts(one) for one in body(*self.join(numbers[: len(start)], carried), *row)]
                flags[:] = self.list_moving(results, carried)
                return [*self.split(results[:size], flags[:size]), *self.split(results[size:], flags[size:])]

            result_rows = zip(*self.base.scan(inner, start, *zip(*rows, strict=True)), strict=True)
            place = size + sum(flags[:size])
            pairs = (
                (self.join(row[:place], flags[:size]), self.join(row[place:], flags[size:])) for row in result_rows
            )
            return [[*states, *others] for states, others in pairs], flags

        return tuple(zip(*self.spread(first, trace)[0], strict=True))

    def fill(self, tangent: Tangent) -> Any:
        """Return a tangent, or `zero` for a missing one."""
        return self.zero if tangent is None else tangent

    def split(self, pairs: Sequence[Pair], moving: Sequence[bool]) -> list[Any]:
        """Return the values, then the tangents of those that move."""
        tangents = compress((tangent for _, tangent in pairs), moving)
        return [*(value for value, _ in pairs), *map(self.fill, tangents)]

    def join(self, numbers: Sequence[Any], moving: Sequence[bool]) -> list[Any]:
        """Return the numbers whose values and tangents `split` returned."""
        tangents = iter(numbers[len(moving) :])
        return [self.pair(value, next(tangents) if m else None) for value, m in zip(numbers, moving, strict=False)]

    def list_moving(self, pairs: Sequence[Pair], moving: Sequence[bool]) -> list[bool]:
        """Return which results have tangents, or belong to a state variable that moves."""
        flags = [*moving, *(False for _ in pairs[len(moving) :])]
        return [m or tangent is not None for (_, tangent), m in zip(pairs, flags, strict=True)]

    def spread(
        self, begin: Sequence[Pair], trace: Callable[[list[bool]], tuple[Any, list[bool]]]
    ) -> tuple[Any, list[bool]]:
        """Trace a loop over a state until all state variables that move are known.

        Args:
            begin: values and tangents of the first state.
            trace: function of the moving state variables that returns the results, and which of them move.
        """
        moving = [tangent is not None for _, tangent in begin]
        while True:
            results, flags = trace(moving)
            if flags[: len(moving)] == moving:
                return results, flags
            moving = flags[: len(moving)]

    def repeat(self, count: int, body: Callable[..., Sequence[Any]], *state: Any) -> Sequence[Any]:
        """Return the state after `count` iterations of `body`, unrolled."""
        return floats.repeat(count, body, *state)

    def iterate(self, most: int, body: Callable[..., Sequence[Any]], *state: Any) -> Sequence[Any]:
        """Return the values and tangents through the base's loop; all but the first number may move."""
        pairs = [self.parts(s) for s in state]
        first, *values = [value for value, _ in pairs]
        tangents = [self.zero if t is None else t for _, t in pairs[1:]]
        count = len(values)

        def turn(going: Any, *numbers: Any) -> list[Any]:
            rows = zip(numbers[:count], numbers[count:], strict=True)
            results = [self.parts(r) for r in body(going, *(self.pair(v, t) for v, t in rows))]
            slopes = [self.zero if t is None else t for _, t in results[1:]]
            return [*(v for v, _ in results), *slopes]

        going, *numbers = self.base.iterate(most, turn, first, *values, *tangents)
        rows = zip(numbers[:count], numbers[count:], strict=True)
        return [going, *(self.pair(v, t) for v, t in rows)]

    def implicit_root(self, root: Any, newton: Any) -> Any:
        """Return the value of a root with the tangent of a Newton step from it."""
        (v, _), (w, t) = self.parts(root), self.parts(newton)
        return self.pair(self.base.implicit_root(v, w), t)

    def detach(self, x: Any) -> Any:
        """Return the value alone."""
        return self.base.detach(self.parts(x)[0])


def value_and_slope(xp: Namespace, function: Callable[[Namespace, Scalar], Scalar], x: Scalar) -> tuple[Scalar, Scalar]:
    """Return f(x) and df/dx for a kernel `function(xp, x)`."""
    (value,), (slope,) = values_and_slopes(xp, lambda xp, x: (function(xp, x),), x)
    return value, slope


def values_and_slopes(
    xp: Namespace, function: Callable[[Namespace, Scalar], Sequence[Scalar]], x: Scalar
) -> tuple[list[Scalar], list[Scalar]]:
    """Return values and derivatives of a function with several results."""
    dual: Any = DualNamespace(xp)
    pairs = [dual.parts(result) for result in function(dual, dual.pair(x, 1.0))]
    return [v for v, _ in pairs], [0.0 if t is None else t for _, t in pairs]


def compute_jacobian(
    xp: Namespace, function: Callable[[Namespace, Sequence[Scalar]], Sequence[Scalar]], at: Sequence[Scalar]
) -> tuple[list[Scalar], list[list[Scalar]]]:
    """Return the values f_i and derivatives df_i/dx_k of a kernel of one or several variables."""
    values: list[Scalar] = []
    columns: list[list[Scalar]] = []
    for k in range(len(at)):

        def along(xp: Namespace, x: Scalar, k: int = k) -> Sequence[Scalar]:
            return function(xp, [*at[:k], x, *at[k + 1 :]])

        values, slopes = values_and_slopes(xp, along, at[k])
        columns.append(slopes)
    return values, [list(row) for row in zip(*columns, strict=True)]
