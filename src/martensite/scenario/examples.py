"""Location of the example scenarios of the package."""

from __future__ import annotations

from pathlib import Path

_PACKAGED = Path(__file__).parents[1] / "examples"
EXAMPLES = _PACKAGED if _PACKAGED.is_dir() else Path(__file__).parents[3] / "examples"
"""Folder of the examples, in the installed package or the source tree."""
