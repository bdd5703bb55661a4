"""Thread-safe caches of work that is done once for each argument.

Tracing changes graphs that several programs share, and compilation takes seconds. One lock prevents both from running
in several threads.
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
    """Return a decorator that caches the last `maxsize` results; other threads wait during a computation."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        cache = lru_cache(maxsize)(function)

        @wraps(function)
        def answer(*args: P.args, **kwargs: P.kwargs) -> R:
            with _LOCK:
                return cache(*args, **kwargs)

        return answer

    return decorate
