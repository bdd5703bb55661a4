"""Types of declared fields for type checkers: `__set__` types the constructor argument, `__get__` the value.

Fields have these types in annotations only, never at run time.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from martensite.base.units import Numeric

T = TypeVar("T")


class Number:
    """Type of a `param` field: accepts numbers, text and pint quantities; read as a float."""

    def __get__(self, owner: Any, cls: Any = None, /) -> float:
        raise NotImplementedError

    def __set__(self, owner: Any, value: Numeric, /) -> None:
        raise NotImplementedError


class Given(Generic[T]):
    """Type of a component that may be given by name or as a table, such as the law of an element."""

    def __get__(self, owner: Any, cls: Any = None, /) -> T:
        raise NotImplementedError

    def __set__(self, owner: Any, value: T | str | Mapping[str, Any], /) -> None:
        raise NotImplementedError
