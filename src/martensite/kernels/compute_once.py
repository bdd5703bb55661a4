"""Work that is done once for each argument, whichever thread asks first.

Tracing adds to graphs that programs share, and compiling takes seconds: one lock for all of it
keeps threads that run different experiments from doing either at the same time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from threading import RLock
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
_LOCK = RLock()


def cache_answers(maxsize: int) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator: keep the last `maxsize` answers; others wait while one is being made."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        kept = lru_cache(maxsize)(function)

        @wraps(function)
        def answer(*args: P.args, **kwargs: P.kwargs) -> R:
            with _LOCK:
                return kept(*args, **kwargs)

        return answer

    return decorate
