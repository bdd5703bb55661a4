"""Nested NamedTuples as flat sequences and back: states between kernels and runtimes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar, cast

from martensite.kernels.namespace import Flag, Namespace, Scalar

LEAST_ROWS = 5
"""Number of rows from which a loop is better than a copy per row."""
Chosen = TypeVar("Chosen", bound=tuple[Any, ...])


class NestedShape:
    """Converter of a flat sequence to nested NamedTuples."""

    def __init__(self, example: Any) -> None:
        self.example = example

    def rebuild(self, flat: Sequence[Any]) -> Any:
        """Return the nested tuple with the numbers of `flat` in order."""
        return self._fill(self.example, iter(flat))

    def _fill(self, example: Any, numbers: Iterator[Any]) -> Any:
        if isinstance(example, tuple):
            items = (self._fill(item, numbers) for item in example)  # type: ignore[misc]
            return tuple(items) if type(example) is tuple else type(example)(*items)
        return next(numbers)


def flatten_numbers(nested: Any) -> list[Any]:
    """Return all numbers of nested tuples, in order."""
    if isinstance(nested, tuple):
        return [number for item in nested for number in flatten_numbers(item)]  # type: ignore[misc]
    return [nested]


def name_numbers(nested: Any, path: str = "") -> list[str]:
    """Return the dotted names of all numbers of nested tuples, in order, such as `elements.0.memory.stress`."""
    if not isinstance(nested, tuple):
        return [path]
    names: tuple[str, ...] = getattr(cast("Any", nested), "_fields", ())
    rows = enumerate(cast("tuple[Any, ...]", nested))
    before = f"{path}." if path else ""
    return [one for k, item in rows for one in name_numbers(item, f"{before}{names[k] if names else k}")]


def choose_tuple(xp: Namespace, flag: Flag, one: Chosen, other: Chosen) -> Chosen:
    """Return the first of two nested tuples of equal shape if the flag holds, otherwise the second."""
    pairs = zip(flatten_numbers(one), flatten_numbers(other), strict=True)
    return NestedShape(one).rebuild([xp.where(flag, a, b) for a, b in pairs])


def compute_if(
    xp: Namespace, wanted: Flag, function: Callable[..., Scalar], other: Scalar, *arguments: Scalar
) -> Scalar:
    """Return a function of the arguments where `wanted`, otherwise `other`.

    If no batch element wants it, only the parts that do not depend on the arguments are evaluated.
    """

    def compute(_: Scalar, __: Scalar, *numbers: Scalar) -> tuple[Scalar, ...]:
        return (0.0, function(*numbers), *numbers)

    return xp.iterate(1, compute, xp.where(wanted, 1.0, 0.0), other, *arguments)[1]


def sum_column(column: Sequence[Scalar]) -> Scalar:
    """Return the sum of the numbers of a column."""
    result = column[0]
    for number in column[1:]:
        result = result + number
    return result


def sum_columns(xp: Namespace, *columns: Sequence[Scalar]) -> list[Scalar]:
    """Return the sums of equally long columns, as one loop."""
    size = len(columns)

    def add(*numbers: Scalar) -> list[Scalar]:
        return [total + number for total, number in zip(numbers[:size], numbers[size:], strict=True)]

    totals = xp.scan(add, [column[0] for column in columns], *(column[1:] for column in columns))
    return [total[-1] for total in totals]


def map_rows(xp: Namespace, function: Callable[..., Scalar], *columns: Sequence[Scalar]) -> Sequence[Scalar]:
    """Return the column of values of a function of the rows of columns, as one loop."""

    def compute(*row: Scalar) -> Sequence[Scalar]:
        return (function(*row),)

    return xp.each(compute, *columns)[0]


def map_tuples(function: Callable[..., Any], xp: Namespace, *columns: Sequence[Any]) -> list[Any]:
    """Return the nested tuples of a function of the rows of nested tuples, as one loop if there are many."""
    if len(columns[0]) < LEAST_ROWS:
        return [function(*row) for row in zip(*columns, strict=True)]
    taken, example = NestedShape(tuple(column[0] for column in columns)), list[Any]()

    def one(*flat: Scalar) -> list[Scalar]:
        example[:] = [function(*taken.rebuild(flat))]
        return flatten_numbers(example[0])

    rows = [flatten_numbers(row) for row in zip(*columns, strict=True)]
    flat_rows = zip(*xp.each(one, *zip(*rows, strict=True)), strict=True)
    return [NestedShape(example[0]).rebuild(numbers) for numbers in flat_rows]


def find_largest(xp: Namespace, column: Sequence[Scalar]) -> Scalar:
    """Return the largest number of a column."""
    if len(column) >= LEAST_ROWS:

        def compare(most: Scalar, number: Scalar) -> tuple[Scalar]:
            return (xp.maximum(most, number),)

        return xp.scan(compare, column[:1], column[1:])[0][-1]
    result = column[0]
    for number in column[1:]:
        result = xp.maximum(result, number)
    return result
