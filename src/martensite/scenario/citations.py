"""BibTeX entries of the models and materials that a run uses."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import UnknownNameError
from martensite.base.parameters import Parametrised
from martensite.physics.materials.base import Material

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

_FILE = Path(__file__).parents[1] / "references.bib"
_START = re.compile(r"^@\w+\{\s*([^,\s]+)\s*,", re.MULTILINE)
_TITLE = re.compile(r"^\s*title\s*=\s*\{(.*?)\},?\s*$", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r"(\w+)\s*=\s*\{((?:[^{}]|\{[^{}]*\})*)\}")
_ACCENTS = {
    r"\"a": "ä",
    r"\"o": "ö",
    r"\"u": "ü",
    r"\'a": "á",
    r"\'e": "é",
    r"\'i": "í",
    r"\'o": "ó",
    r"\'u": "ú",
    r"\~a": "ã",
    r"\~n": "ñ",
    r"\`e": "è",
    r"\AA": "Å",
    r"\_": "_",
    r"\&": "&",
    "--": "–",
}


@cache
def read_bibliography() -> dict[str, str]:
    """Return all BibTeX entries of the package by key."""
    text = _FILE.read_text(encoding="utf-8")
    return {begin[1]: _read_entry(text, begin.start()) for begin in _START.finditer(text)}


def _read_entry(text: str, start: int) -> str:
    depth = 0
    for place in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0 and text[place] == "}":
            return text[start : place + 1]
    return text[start:]


def list_entries(keys: Iterable[str]) -> list[str]:
    """Return the BibTeX entries of keys, in their order.

    Raises:
        UnknownNameError: a key is not in the bibliography.
    """
    entries = read_bibliography()
    wanted = list(dict.fromkeys(keys))
    unknown = next((key for key in wanted if key not in entries), None)
    if unknown is not None:
        raise UnknownNameError("work in the bibliography", unknown, entries)
    return [entries[key] for key in wanted]


def read_title(key: str) -> str:
    """Return the title of a work, without braces."""
    title = _TITLE.search(list_entries([key])[0])
    return re.sub(r"\s+", " ", re.sub(r"[{}]", "", title[1])) if title else key


def read_fields(text: str) -> dict[str, str]:
    """Return the fields of a BibTeX entry as plain text, by name."""
    return {name.lower(): _remove_markup(value) for name, value in _FIELD.findall(text)}


def _remove_markup(value: str) -> str:
    value = re.sub(r"\s+", " ", value)
    for latex, letter in _ACCENTS.items():
        value = value.replace(latex, letter)
    return re.sub(r"[{}]", "", value)


def list_citations(system: Parametrised | Scenario, material: Material | None = None) -> list[str]:
    """Return the keys of the works behind the parts of a system or scenario, and of its material."""
    every = system.tree() if isinstance(system, Parametrised) else system.parts()
    parts = [key for part in every for key in part.cites]
    return list(dict.fromkeys([*parts, *(material.cites() if material else [])]))
