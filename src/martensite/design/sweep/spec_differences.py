"""In what two sweeps differ, in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import zip_longest
from typing import Any

FREE = ("folder", "modules", "title")
"""What may differ: where the scenario lies, and what it is called."""
LONGEST = 60
"""Characters of a value that is shown."""
WORDS = {
    "over": "axes",
    "traces": "traces",
    "chunk": "runs in a chunk",
    "version": "version of martensite",
    "numbers": "numbers in files that the scenario names",
}


def list_differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """Words for everything that is not the same in two specifications of a sweep.

    The scenario stands for its numbers: where its text differs, they are not named as well.
    """
    known = json.loads(json.dumps(dict(here)))
    names = [n for n in dict.fromkeys((*known, *there)) if n not in FREE]
    apart = [name for name in names if known.get(name) != there.get(name)]
    if "scenario" in apart and "numbers" in apart:
        apart.remove("numbers")
    return [_describe_difference(name, there.get(name), known.get(name)) for name in apart]


def _describe_difference(name: str, there: Any, here: Any) -> str:
    """One difference, with both values if they are short."""
    if name == "scenario":
        there, here = _find_changed_lines(str(there), str(here))
    label = WORDS.get(name, name)
    both = [one if isinstance(one, str) else json.dumps(one) for one in (there, here)]
    if name == "numbers" or max(map(len, both)) > LONGEST:
        return f"{label} differ" if name in WORDS else f"{label} differs"
    return f"{label} `{both[0]}` there, `{both[1]}` here"


def _find_changed_lines(there: str, here: str) -> tuple[str, str]:
    """The first lines of two texts that are not the same."""
    pairs = zip_longest(there.splitlines(), here.splitlines(), fillvalue="")
    return next(((a.strip(), b.strip()) for a, b in pairs if a.strip() != b.strip()), ("", ""))
