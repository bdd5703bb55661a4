"""Results of a function, kept as long as their argument exists, so that repeated runs of one system compute them once.

The key is the identity of the argument: parts are immutable, and hashing a large part takes as long as the computation.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar
from weakref import ref

T = TypeVar("T")
R = TypeVar("R")


def remember(function: Callable[[T], R]) -> Callable[[T], R]:
    """Return the function with its result kept for each immutable argument; a result must not refer to the argument."""
    cache: dict[int, tuple[ref[Any], R]] = {}

    @wraps(function)
    def look_up(argument: T) -> R:
        key = id(argument)
        entry = cache.get(key)
        if entry is None or entry[0]() is not argument:
            entry = cache[key] = (ref(argument, lambda _: cache.pop(key, None)), function(argument))
        return entry[1]

    return look_up
