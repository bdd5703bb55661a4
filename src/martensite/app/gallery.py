"""The scenarios that come with the package."""

from __future__ import annotations

import tomllib
from pathlib import Path

PACKAGED = Path(__file__).parents[1] / "examples"
FOLDER = PACKAGED if PACKAGED.is_dir() else Path(__file__).parents[3] / "examples"
"""Inside of the installed package, or of the source tree."""


def scenarios() -> dict[str, str]:
    """Name and text of every scenario that stands by itself."""
    found = {path.stem: path.read_text("utf-8") for path in sorted(FOLDER.glob("*.toml"))}
    return {name: text for name, text in found.items() if _alone(text)}


def _alone(text: str) -> bool:
    """Whether a document is a scenario that needs no log and no data of others."""
    document = tomllib.loads(text)
    return "scenario" not in document and "flexinol-isobaric/" not in text and '"log"' not in text
