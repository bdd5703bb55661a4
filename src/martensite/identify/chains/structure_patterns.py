"""Patterns of structures: `poly{1..3} | oe({2..3},3,1) | {pwl,sigmoid}{5,10}`.

Braces hold alternatives, separated by commas; `a..b` stands for the whole numbers from a to b.
Every choice is combined with every other, in the order in which they are written.
"""

from __future__ import annotations

import re
from itertools import product

from martensite.base.errors import InputError

MOST = 500
"""Structures of one pattern."""
_BRACES = re.compile(r"\{([^{}]*)\}")
_RANGE = re.compile(r"\s*(\d+)\s*\.\.\s*(\d+)\s*")


def expand_pattern(pattern: str) -> list[str]:
    """All structures of a pattern, each once.

    Raises:
        InputError: braces are not closed or empty, a range is empty, or there are too many.
    """
    words = _BRACES.split(pattern)
    if any(sign in word for word in words for sign in "{}"):
        raise InputError(f"The braces of `{pattern}` are nested or not closed.")
    choices = [_list_choices(word, pattern) if k % 2 else [word] for k, word in enumerate(words)]
    count = 1
    for choice in choices:
        count *= len(choice)
    if count > MOST:
        raise InputError(f"`{pattern}` stands for {count} structures; at most {MOST} are searched.")
    return list(dict.fromkeys("".join(words).strip() for words in product(*choices)))


def _list_choices(inner: str, pattern: str) -> list[str]:
    found: list[str] = []
    for word in inner.split(","):
        ends = _RANGE.fullmatch(word)
        if ends is None:
            found.append(word.strip())
            continue
        low, high = int(ends[1]), int(ends[2])
        if low > high:
            raise InputError(f"The range `{word.strip()}` of `{pattern}` is empty.")
        found += [str(number) for number in range(low, high + 1)]
    if not all(found):
        raise InputError(f"Braces of `{pattern}` hold an empty choice.")
    return found
