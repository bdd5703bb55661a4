"""Units and columns of logs for the page that reads them without a server: what this package knows of them, as data.

python web/write_vocabulary.py > web/src/fit/vocabulary.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from martensite.base import units
from martensite.base.errors import UnitError
from martensite.scenario.heading_guess import BY_UNIT, SPELLINGS
from martensite.scenario.layout import DRIVEN_BY, QUANTITIES

SHARES = ("1", "%", "ppm")
"""Units without a dimension that are no angles."""


def list_words() -> dict[str, Any]:
    """Units with SI unit, size and zero (SI = number · size + zero) and spellings; columns with unit and words."""
    return {
        "units": {name: _describe_unit(name) for name in (*SPELLINGS, "m/s")},
        "spellings": {name: [one for one in others if one != name] for name, others in SPELLINGS.items()},
        "quantities": {name: [one.unit, list(one.words)] for name, one in QUANTITIES.items()},
        "by_unit": BY_UNIT,
        "readable": {si: shown for si in BY_UNIT if (shown := units.choose_readable_unit(si)) in SPELLINGS},
        "driven_by": list(DRIVEN_BY),
    }


def _describe_unit(name: str) -> tuple[str, float, float]:
    for si in ("1",) if name in SHARES else (*BY_UNIT, "m/s"):
        try:
            return (si, *units.find_conversion(name, si))
        except UnitError:
            continue
    raise UnitError(f"`{name}` is the unit of no column.")


def format_words() -> str:
    """The same as JSON, a line for each table."""
    lines = [f"{json.dumps(name)}: {json.dumps(table, ensure_ascii=False)}" for name, table in list_words().items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


if __name__ == "__main__":
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "src" / "fit" / "vocabulary.json"
    place.write_text(format_words(), encoding="utf-8")
