"""Types of declared fields, for type checkers: what a constructor takes, and what reading the field gives.

They are data descriptors by their annotations only: a type checker takes the argument of a constructor from `__set__`,
and the value of the field from `__get__`. No field holds one at run time.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from martensite.base.units import Numeric

T = TypeVar("T")


class Number:
    """Type of a field that `param` declares: it takes numbers, text and pint quantities, and is read as a float."""

    def __get__(self, owner: Any, cls: Any = None, /) -> float:
        raise NotImplementedError

    def __set__(self, owner: Any, value: Numeric, /) -> None:
        raise NotImplementedError


class Given(Generic[T]):
    """Type of a part that may be given by name or as a table, such as the law of an element; read as the part."""

    def __get__(self, owner: Any, cls: Any = None, /) -> T:
        raise NotImplementedError

    def __set__(self, owner: Any, value: T | str | Mapping[str, Any], /) -> None:
        raise NotImplementedError
