"""Citations: BibTeX for exactly the models and materials that a run used."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.errors import UnknownNameError
from martensite.materials.base import Material
from martensite.parameters import Parametrised

if TYPE_CHECKING:
    from martensite.io.scenario import Scenario

_FILE = Path(__file__).parents[1] / "references.bib"
_START = re.compile(r"^@\w+\{\s*([^,\s]+)\s*,", re.MULTILINE)
_TITLE = re.compile(r"^\s*title\s*=\s*\{(.*?)\},?\s*$", re.MULTILINE | re.DOTALL)


@cache
def bibliography() -> dict[str, str]:
    """All entries of the package's bibliography: key -> BibTeX text."""
    text = _FILE.read_text(encoding="utf-8")
    return {found[1]: _entry(text, found.start()) for found in _START.finditer(text)}


def _entry(text: str, start: int) -> str:
    """The text of the entry that starts there, up to its closing brace."""
    depth = 0
    for place in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0 and text[place] == "}":
            return text[start : place + 1]
    return text[start:]


def entries(keys: Iterable[str]) -> list[str]:
    """BibTeX entries of the given keys, in that order.

    Raises:
        UnknownNameError: a key is not in the bibliography.
    """
    known = bibliography()
    wanted = list(dict.fromkeys(keys))
    unknown = next((key for key in wanted if key not in known), None)
    if unknown is not None:
        raise UnknownNameError("work in the bibliography", unknown, known)
    return [known[key] for key in wanted]


def title(key: str) -> str:
    """Title of a work, without BibTeX braces."""
    found = _TITLE.search(entries([key])[0])
    return re.sub(r"\s+", " ", re.sub(r"[{}]", "", found[1])) if found else key


def citations(system: Parametrised | Scenario, material: Material | None = None) -> list[str]:
    """Keys of the works behind the parts of a system or scenario, and of its material."""
    every = system.tree() if isinstance(system, Parametrised) else system.parts()
    parts = [key for part in every for key in part.cites]
    return list(dict.fromkeys([*parts, *(material.cites() if material else [])]))
