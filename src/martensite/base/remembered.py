"""Answers that are kept for an object as long as it lives, so that repeated runs of one system compute them once.

An object is known by its identity: parts are frozen, and the hash of a large one takes as long as the work.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar
from weakref import ref

T = TypeVar("T")
R = TypeVar("R")


def remember(function: Callable[[T], R]) -> Callable[[T], R]:
    """Return the function, with its answer kept for every frozen object; an answer must not hold the object."""
    kept: dict[int, tuple[ref[Any], R]] = {}

    @wraps(function)
    def answer(one: T) -> R:
        place = id(one)
        known = kept.get(place)
        if known is None or known[0]() is not one:
            known = kept[place] = (ref(one, lambda _: kept.pop(place, None)), function(one))
        return known[1]

    return answer
