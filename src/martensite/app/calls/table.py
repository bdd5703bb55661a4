"""What is in an uploaded table, and what its columns may mean.

{"key": …, "separator": "auto"}
-> {"name", "rows", "separator", "preview": [[text, …], …], "columns": [{heading, name, unit, min,
max, missing, wrong, curve, …}], "names": {name: [unit, …]}, "notes": […]}

Cells are text, whatever is in them. Numbers of columns are as they stand in the file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from martensite.app.drawer import Drawer
from martensite.app.identify.raw import Raw, RawColumn, read_raw
from martensite.app.identify.thin import envelope
from martensite.app.messages import wanted
from martensite.app.worker import Desk
from martensite.scenario.guess import Guess, guess_headings, usual_units
from martensite.scenario.layout import CANONICAL

SMALL = 120
"""Points of the small curve of a column."""
LONG = 100_000
"""Rows from which on it is advised to thin out."""


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Read the file and describe it."""
    path = Drawer(desk.folder).path(wanted(request, "key", str))
    raw = read_raw(path, wanted(request, "separator", str, "auto"))
    meant = guess_headings([c.heading for c in raw.columns], [c.sample for c in raw.columns])
    columns = [_column(c, g) for c, g in zip(raw.columns, meant, strict=True)]
    return {
        "name": raw.name,
        "rows": raw.rows,
        "separator": raw.separator,
        "headed": raw.headed,
        "preview": raw.preview,
        "columns": columns,
        "names": {name: usual_units(name) for name in CANONICAL},
        "notes": list(_notes(raw, meant)),
    }


def _column(column: RawColumn, guess: Guess) -> dict[str, Any]:
    known = [number for number in column.numbers if not math.isnan(number)]
    rows = envelope(column.numbers, SMALL)
    return {
        "heading": column.heading,
        "name": guess.name if known else "",
        "unit": guess.unit,
        "min": min(known, default=None),
        "max": max(known, default=None),
        "missing": len(column.numbers) - len(known) - column.wrong,
        "wrong": column.wrong,
        "first_wrong": column.first_wrong,
        "curve": [rows, [column.numbers[row] for row in rows]],
    }


def _notes(raw: Raw, meant: list[Guess]) -> Iterator[str]:
    """What to look at before going on."""
    if not raw.headed:
        yield "The file has no headings; say for every column what it is."
    if len(raw.columns) == 1:
        yield "There is one column only; if the file has more, choose its separator."
    if raw.ragged and raw.separator:
        yield (
            f"{raw.ragged} rows have more or fewer cells than there are columns "
            f"({len(raw.columns)}): {raw.first_ragged}. Leave them out, or mend the file."
        )
    elif raw.ragged:
        yield f"{raw.first_ragged}."
    if any(column.wrong for column in raw.columns):
        yield (
            "Some cells are no numbers. Do not use their columns, leave out such rows, or mend "
            "the file."
        )
    if raw.rows > LONG:
        yield f"The file has {raw.rows:,} rows; thin it out in the next step."
    if not any(guess.name == "time" for guess in meant):
        yield "No column seems to be the time; choose one, or give the time between rows."
