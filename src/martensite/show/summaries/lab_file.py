"""Instrument files with their interpreted columns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from martensite.base import units
from martensite.base.formats import typeset_unit
from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Sentence, Summary
from martensite.logs.lab_files import LabFile, ReadColumn

WIDEST = 14
"""Largest number of letters of a heading."""


def summarise_lab_files(files: Sequence[LabFile]) -> Summary:
    """Return formats, columns with their ranges, omitted rows, and doubts."""
    blocks = [block for one in files for block in _describe_file(one, len(files) > 1)]
    title = f"{files[0].record.name}: {_count(files[0])}" if len(files) == 1 else f"{len(files)} files"
    return Summary(title, blocks, {"tables": [_list_data(one) for one in files]})


def _count(one: LabFile) -> str:
    times = one.record.times
    return f"{len(one.record)} rows" + (f", {times[-1] - times[0]:.6g} s" if one.has_time else ", without times")


def _describe_file(one: LabFile, several: bool) -> Iterator[Block]:
    if several:
        yield Heading(f"{one.record.name}: {_count(one)}")
    yield Sentence(f"{one.format[:1].upper()}{one.format[1:]}.")
    yield DataTable(
        ("column", "heading", "in", "is", "from", "to", "unit", "known by"),
        [_describe_column(column) for column in one.columns],
        right=(0, 4, 5),
    )
    left = [
        f"{lost.count} row{'s' * (lost.count > 1)} left out: {lost.reason} (row {_list_rows(lost.rows, lost.count)})."
        for lost in one.dropped
    ]
    if left:
        yield BulletList(left)
    if one.notes:
        yield Notice("Look at", one.notes, True)


def _describe_column(column: ReadColumn) -> tuple[str, ...]:
    heading = column.heading if len(column.heading) <= WIDEST else f"{column.heading[: WIDEST - 1]}…"
    if not column.si or math.isnan(column.low):
        return str(column.number), heading, "", "not used", "", "", "", ""
    unit = units.of_column(column.name, column.si)
    low, high = (f"{units.from_si(x, unit, column.si):.5g}" for x in (column.low, column.high))
    read = typeset_unit(column.unit, "1")
    return str(column.number), heading, read, column.name, low, high, typeset_unit(unit, "1"), column.source


def _list_rows(rows: Sequence[int], count: int) -> str:
    return ", ".join(map(str, rows)) + (", …" if count > len(rows) else "")


def _list_data(one: LabFile) -> dict[str, Any]:
    return {
        "path": str(one.path),
        "format": one.format,
        "rows": len(one.record),
        "has_time": one.has_time,
        "columns": [_drop_gaps(asdict(column)) for column in one.columns],
        "dropped": [asdict(left) for left in one.dropped],
        "notes": list(one.notes),
    }


def _drop_gaps(column: dict[str, Any]) -> dict[str, Any]:
    """Return a column with None for NaN, which JSON lacks."""
    return {key: None if isinstance(x, float) and math.isnan(x) else x for key, x in column.items()}
