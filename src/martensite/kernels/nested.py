"""Nested NamedTuples as flat sequences and back: states between kernels and runtimes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar, cast

from martensite.kernels.namespace import Flag, Namespace, Scalar

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
            return tuple(items) if type(example) is tuple else type(example)(*items)  # type: ignore[call-arg]
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


def sum_column(column: Sequence[Scalar]) -> Scalar:
    """Return the sum of the numbers of a column."""
    result = column[0]
    for number in column[1:]:
        result = result + number
    return result


def find_largest(xp: Namespace, column: Sequence[Scalar]) -> Scalar:
    """Return the largest number of a column."""
    result = column[0]
    for number in column[1:]:
        result = xp.maximum(result, number)
    return result
