"""Cases of one sentence in one test: a loop that says at which of them it stopped."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any


def over(name: str, values: Iterable[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Run a test for all values of one argument, one after the other; several nest.

    For cases that say the same and cost little: a test of its own for each costs more than they do.
    """
    chosen = list(values)

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def run(*args: Any, **kwargs: Any) -> None:
            for value in chosen:
                try:
                    test(*args, **kwargs, **{name: value})
                except BaseException as error:
                    error.add_note(f"at {name} = {value!r}")
                    raise

        kept = inspect.signature(test)
        others = [one for key, one in kept.parameters.items() if key != name]
        run.__signature__ = kept.replace(parameters=others)  # type: ignore[attr-defined]
        return run

    return decorate
