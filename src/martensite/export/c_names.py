"""Names and numbers of what a C core takes and gives: metadata, and identifiers made of them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.base.parameters import Leaf

_WORDS = """
alignas alignof asm auto bool break case catch char class const continue default delete do double else enum
explicit export extern false float for friend goto if inline int long mutable namespace new operator private
protected public register restrict return short signed sizeof static struct switch template this throw true
try typedef typename union unsigned using virtual void volatile while
"""
KEYWORDS = frozenset(_WORDS.split())
"""Keywords of C and C++."""


@dataclass(frozen=True)
class CoreVariable:
    """A parameter, an input or an output of a C core."""

    index: int
    """In the array of its kind."""
    name: str
    """Name as in Python: the path of a parameter, or the name of a drive or an output."""
    identifier: str
    """Identifier of the index in C, without the name of the core: `p_element_diameter`."""
    unit: str
    """In SI."""
    words: str
    default: float
    """A parameter: its value in the scenario. An input: 0. An output: NaN, for it has none."""
    low: float = -math.inf
    high: float = math.inf
    """Ends of what is allowed; both belong to it."""
    endless: bool = False
    """True if the value may be infinite, for a disabled limit."""
    used: bool = True
    """True if anything follows from it: numbers that only decide the size of a program do not."""


def choose_identifier(name: str | None, text: str) -> str:
    """Return a name that a user gave, or for None an identifier made of a text.

    Args:
        name: the name that was given, which must be an identifier.
        text: what an identifier is made of: letters, digits and single underscores.

    Raises:
        ParameterError: the name is not an identifier, or is a keyword.
    """
    if name is None:
        return _make_identifier(text)
    if not re.fullmatch(r"[A-Za-z][0-9A-Za-z_]*", name) or name in KEYWORDS:
        raise ParameterError(
            "The name of an exported model must be an identifier (a letter, then letters, digits and underscores), "
            f"not a keyword, but is `{name}`; try `{_make_identifier(name)}`."
        )
    return name


def _make_identifier(text: str) -> str:
    plain = re.sub(r"[^0-9A-Za-z]+", "_", text).strip("_")
    if not plain or plain[0].isdigit() or plain in KEYWORDS:
        plain = f"m_{plain}".rstrip("_")
    return plain


def make_identifiers(letter: str, names: Iterable[str]) -> list[str]:
    """Return different identifiers of some names, after a letter: `p_element_length`."""
    found: dict[str, None] = {}
    for name in names:
        plain = wanted = f"{letter}_{re.sub(r'[^0-9A-Za-z]+', '_', name).strip('_')}"
        count = 1
        while wanted in found:
            count += 1
            wanted = f"{plain}_{count}"
        found[wanted] = None
    return list(found)


def list_parameters(leaves: Iterable[Leaf], used: Iterable[bool]) -> tuple[CoreVariable, ...]:
    """Return the numbers of a system, with what is allowed for them."""
    every = list(leaves)
    names = make_identifiers("p", (leaf.path for leaf in every))
    rows = zip(every, names, used, strict=True)
    return tuple(_describe_parameter(i, *row) for i, row in enumerate(rows))


def _describe_parameter(index: int, leaf: Leaf, name: str, used: bool) -> CoreVariable:
    declared, default = leaf.declared, leaf.declared.default
    low = math.nextafter(declared.low, math.inf) if declared.open_low else declared.low
    unit = "of the reading" if declared.unit in units.OF_READINGS else declared.unit
    endless = isinstance(default, float) and math.isinf(default)
    return CoreVariable(
        index, leaf.path, name, unit, declared.doc, float(leaf.value), low, declared.high, endless, used
    )


def list_variables(letter: str, rows: Iterable[tuple[str, str, str]], default: float) -> tuple[CoreVariable, ...]:
    """Return the inputs or outputs by name, unit and words."""
    every = list(rows)
    names = make_identifiers(letter, (name for name, _, _ in every))
    return tuple(
        CoreVariable(i, name, label, unit, words, default)
        for i, ((name, unit, words), label) in enumerate(zip(every, names, strict=True))
    )
