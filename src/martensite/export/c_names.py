"""Metadata of the parameters, inputs and outputs of a C core, and identifiers made of their names."""

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


@dataclass(frozen=True)
class CoreVariable:
    """A parameter, an input or an output of a C core."""

    index: int
    """Index in the array of its kind."""
    name: str
    """Path of a parameter, or name of a drive or output."""
    identifier: str
    """C identifier without the name of the core: `p_element_diameter`."""
    unit: str
    """SI unit."""
    words: str
    default: float
    """Scenario value of a parameter, 0 for an input, NaN for an output."""
    low: float = -math.inf
    high: float = math.inf
    """Ends of the allowed closed range."""
    endless: bool = False
    """True if the value may be infinite, for a disabled limit."""
    has_effect: bool = True
    """True if the parameter has an effect; parameters that only decide the size of a program have none."""


def choose_identifier(name: str | None, text: str) -> str:
    """Return the given name, or an identifier made of a text.

    Args:
        name: an identifier, or None.
        text: source of the identifier: letters, digits and single underscores are kept.
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
    """Return different identifiers of names, after a letter: `p_element_length`."""
    identifiers: dict[str, None] = {}
    for name in names:
        plain = identifier = f"{letter}_{re.sub(r'[^0-9A-Za-z]+', '_', name).strip('_')}"
        count = 1
        while identifier in identifiers:
            count += 1
            identifier = f"{plain}_{count}"
        identifiers[identifier] = None
    return list(identifiers)


def list_parameters(leaves: Iterable[Leaf], used: Iterable[bool]) -> tuple[CoreVariable, ...]:
    """Return the parameters of a system, with their allowed ranges."""
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
    """Return inputs or outputs by name, unit and description."""
    every = list(rows)
    names = make_identifiers(letter, (name for name, _, _ in every))
    return tuple(
        CoreVariable(i, name, label, unit, words, default)
        for i, ((name, unit, words), label) in enumerate(zip(every, names, strict=True))
    )
