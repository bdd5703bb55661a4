"""Location of the example scenarios that come with the package."""

from __future__ import annotations

from pathlib import Path

_PACKAGED = Path(__file__).parents[1] / "examples"
EXAMPLES = _PACKAGED if _PACKAGED.is_dir() else Path(__file__).parents[3] / "examples"
"""Inside of the installed package, or of the source tree."""
