"""Loops in place of repeated C statements.

Texts that differ in array indices alone, each index at equal distances, are one text with an index such as
`(3 + 5 * row)`. The statements and their order do not change.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

INDEX = re.compile(r"(?<=\[)\d+|(?<=\(\w, )\d+(?=[,)])")
"""Index of an element: `x[3]`, `x[3 * n + l]`, `AT(x, 3)` or `PUT(y, 3, …)`."""
LEAST_TURNS = 4
"""Number of repetitions from which statements become a loop."""
LONGEST = 64
"""Largest number of statements in the body of such a loop."""
Parts = tuple[tuple[str, ...], tuple[int, ...]]
"""Text without its indices, and the indices."""


def merge_texts(texts: Sequence[str], row: str) -> str | None:
    """Return the common text with indices that depend on `row`; None if the texts differ otherwise."""
    parts = [_split_text(text) for text in texts]
    return _merge_parts(parts, row) if _count_turns(parts) == len(texts) else None


def roll_lines(lines: Sequence[str], row: str = "row") -> list[str]:
    """Return complete statements, with loops over `row` for repeated ones."""
    rolled, at, parts = list[str](), 0, [_split_text(line) for line in lines]
    while at < len(lines):
        size, turns = _find_period(parts, at)
        if turns < LEAST_TURNS:
            rolled.append(lines[at])
            at += 1
            continue
        head = f"for (int {row} = 0; {row} < {turns}; {row}++)"
        body = [_merge_parts(parts[at + k : at + size * turns : size], row) for k in range(size)]
        rolled += [f"{head} {body[0]}"] if size == 1 else [f"{head} {{", *(f"    {one}" for one in body), "}"]
        at += size * turns
    return rolled


def _split_text(text: str) -> Parts:
    return tuple(INDEX.split(text)), tuple(map(int, INDEX.findall(text)))


def _merge_parts(parts: Sequence[Parts], row: str) -> str:
    """Return texts that differ in indices at equal distances as one."""
    (form, first), (_, second) = parts[0], parts[min(1, len(parts) - 1)]
    indices = [_print_index(a, b - a, row) for a, b in zip(first, second, strict=True)]
    return "".join(part + index for part, index in zip(form, [*indices, ""], strict=True))


def _print_index(first: int, step: int, row: str) -> str:
    if step == 0:
        return str(first)
    shift = row if abs(step) == 1 else f"{abs(step)} * {row}"
    if first == 0 and step > 0:
        return row if step == 1 else f"({shift})"
    return f"({first} {'-' if step < 0 else '+'} {shift})"


def _find_period(parts: Sequence[Parts], at: int) -> tuple[int, int]:
    """Return the number of statements that repeat from a place on, and how often."""
    for size in range(1, min(LONGEST, (len(parts) - at) // LEAST_TURNS) + 1):
        end = at + size * LEAST_TURNS
        if parts[at][0] == parts[at + size][0] and all(
            _count_turns(parts[at + k : end : size]) == LEAST_TURNS for k in range(size)
        ):
            return size, min(_count_turns(parts[at + k :: size]) for k in range(size))
    return 1, 1


def _count_turns(parts: Sequence[Parts]) -> int:
    """Return how many of the first texts differ in indices at equal distances alone."""
    (form, first), (_, second) = parts[0], parts[min(1, len(parts) - 1)]
    for turn, part in enumerate(parts):
        if part != (form, tuple(a + turn * (b - a) for a, b in zip(first, second, strict=False))):
            return turn
    return len(parts)
