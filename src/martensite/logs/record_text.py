"""Records as text for `read_table`.

Spreadsheets interpret a cell that begins with = + - @ as a formula. Names may come from documents of other authors, so
such a heading gets a leading apostrophe.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from martensite.signals.records import Record

BLOCK = 10_000
"""Rows that are written at a time."""
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters of a spreadsheet formula."""


def format_heading(name: str, unit: str) -> str:
    """Return a name with its unit, safe in a spreadsheet."""
    text = f"{name} [{unit}]"
    return f"'{text}" if text.startswith(FORMULA) else text


def format_record(record: Record, names: Sequence[str]) -> str:
    """Return columns of a record as text with headings that `read_table` reads; missing samples are empty."""
    head = ",".join(format_heading(name, record.units[name]) for name in names)
    blocks = (_format_rows(record, names, first) for first in range(0, len(record), BLOCK))
    return "\n".join([head, *blocks, ""])


def _format_rows(record: Record, names: Sequence[str], first: int) -> str:
    """Return a block of rows as text."""
    rows = zip(*(record[name][first : first + BLOCK].tolist() for name in names), strict=True)
    return "\n".join(",".join("" if math.isnan(x) else f"{x:.10g}" for x in row) for row in rows)
