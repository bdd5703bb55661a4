"""Table as an instrument wrote it: headings, units and numbers, without meanings.

The chosen encoding, separator and decimal sign give the most numeric cells. The table consists of the rows of the most
frequent width; above it are a row of units, a row of headings, and lines that may give the sample time. Rows outside
the table are omitted and counted.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, takewhile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.logs.cells import Numbers, NumberStyle, clear_extremes, find_kind, find_style, is_missing, read_cells
from martensite.logs.layout import name_column
from martensite.logs.open_files import Line
from martensite.logs.table_headings import ABOVE, SEPARATORS, Above, Row, collect_said, find_headings, names_columns

LOOKED_AT = 400
"""Rows that determine the layout."""
MOST_COLUMNS = 200


class WrongCell(NamedTuple):
    """Cell that is no number."""

    row: int
    """Row number in the file."""
    text: str

    def __str__(self) -> str:
        return f"row {self.row}: {self.text}"


@dataclass(frozen=True)
class RawColumn:
    """One column."""

    heading: str
    unit: str
    """Unit in a row of units or after the numbers; a unit in the heading stays there."""
    kind: str
    """`number`, `clock`, `date`, `stamp` (both, in seconds), or `text`."""
    numbers: Numbers
    """Numbers of the file, NaN for other cells."""
    sample: str = ""
    """First nonempty cell."""
    wrong: tuple[WrongCell, ...] = ()
    """Cells that are neither numbers nor empty."""
    unsure: bool = False
    """True if the order of day and month is ambiguous."""


@dataclass(frozen=True)
class LeftOut:
    """Omitted rows."""

    reason: str
    count: int
    rows: tuple[int, ...]
    """Numbers of the first rows."""


@dataclass(frozen=True)
class RawTable:
    """Raw table."""

    name: str
    form: str
    """Format of the table, in words."""
    separator: str
    """Key of `SEPARATORS`; empty for a binary file."""
    has_headings: bool
    columns: tuple[RawColumn, ...]
    numbers: NDArray[np.intp]
    """Row numbers in the file."""
    preview: list[list[str]]
    left_out: tuple[LeftOut, ...] = ()
    header_entries: Mapping[str, str] = field(default_factory=dict[str, str])
    """Entries above the table: lower-case label -> text."""
    notes: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    """Cells above the headings, one per column; may be empty."""

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return len(self.numbers)


def count_rows(reason: str, rows: Sequence[int] | NDArray[np.intp]) -> tuple[LeftOut, ...]:
    """Return the count of omitted rows with its reason; empty if all rows are kept."""
    return (LeftOut(reason, len(rows), tuple(map(int, rows[:3]))),) if len(rows) else ()


def find_table(
    path: Path, rows: list[Row], form: tuple[str, ...], separator: str = "", lines: Sequence[Line] = ()
) -> RawTable:
    """Return the table of numbers among rows of cells.

    Args:
        path: path of the file.
        rows: nonempty rows.
        form: kind, separator and encoding, in words.
        separator: key of `SEPARATORS`, if rows are text.
        lines: lines of the rows, because headings may have another separator.

    Raises:
        DataError: there is no table.
    """
    where = f"`{path.name}`"
    numeric = {k for k, (_, row) in enumerate(rows) if any(map(find_kind, row))}
    width = _find_width(rows, numeric, where)
    alike = [k for k in sorted(numeric) if len(rows[k][1]) == width]
    places = _find_places([rows[k][1] for k in alike])
    if not places:
        raise DataError(f"{where} has no numeric column.")
    body = _find_body(rows, alike, places, where)
    _refuse_larger_table(rows, numeric, body, where)
    sign, channels = SEPARATORS.get(separator), _find_channel_units(rows[: body[0]], width)
    texts = dict(lines[max(0, body[0] - ABOVE) : body[0]])
    headings, units, used = find_headings(rows[: body[0]], texts, width, sign)
    body, again = _choose_block(rows, body, headings, where)
    table = [rows[k] for k in body]
    inside = [] if 0 in places else table[:40]
    entries = collect_said(rows[: body[0]]) | collect_said(inside) | _select_texts(units)
    style = find_style(rows[k][1][p] for k in body[:: max(1, len(body) // 500)] for p in places)
    left, spoilt = _list_left(rows, body, (numeric, set(alike)), used, bool(again))
    columns = _read_columns(table, headings, channels | units, style, places)
    doubt = ("Numbers such as `1,234` may hold thousands: they are read with a decimal comma.",) * style.unsure
    return RawTable(
        path.name,
        _describe_form(form, style, rows[body[0]][0] - 1 - spoilt),
        separator,
        any(headings),
        columns,
        np.array([number for number, _ in table]),
        [[cell[:60] for cell in row] for _, row in table[:20]],
        left,
        entries,
        again + doubt,
        _find_labels(rows, used, width),
    )


def _select_texts(units: Above) -> dict[str, str]:
    """Return the labelled texts among the units of columns."""
    return {key: text for key, text in units.items() if isinstance(key, str)}


def _describe_form(form: tuple[str, ...], style: NumberStyle, skipped: int) -> str:
    """Return the kind, separator, number style, skipped lines and encoding of a table, in words."""
    comma = "decimal commas" if style.comma else ""
    return ", ".join(word for word in (*form[:2], comma, _say_lines(max(0, skipped)), *form[2:]) if word)


def _find_labels(rows: Sequence[Row], used: set[int], width: int) -> tuple[str, ...]:
    """Return the cells right above the headings, if these are as wide and begin with a label."""
    first = next((k for k, (number, _) in enumerate(rows) if number in used), 0)
    label = [cell.strip() for cell in rows[first - 1][1]] if first else []
    return tuple(label) if len(label) == width and label[0] else ()


def _refuse_larger_table(rows: Sequence[Row], numeric: set[int], body: Sequence[int], where: str) -> None:
    """Raise `DataError` if most rows of several numbers are outside the table."""
    if 3 * len(body) >= len(numeric):
        return
    full = sum(sum(map(bool, map(find_kind, rows[k][1]))) > 1 for k in numeric)
    if 3 * len(body) < full:
        first, last = rows[body[0]][0], rows[body[-1]][0]
        raise DataError(
            f"{where} has {full} rows with several numbers, but only {len(body)} of them, rows {first} to {last}, have "
            f"the same {len(rows[body[0]][1])} columns; save each table as a file of its own."
        )


def _find_channel_units(above: Sequence[Row], width: int) -> Above:
    """Return column index -> unit of the channels of a LabVIEW file; empty if they do not fit the table."""
    labelled = [row for _, row in above if row[0].strip() == "Y_Unit_Label"]
    places = [k for k, cell in enumerate(labelled[-1]) if k and cell.strip()] if labelled else []
    return {k: labelled[-1][k].strip() for k in places} if max(places, default=0) < width else {}


def _find_width(rows: Sequence[Row], numeric: set[int], where: str) -> int:
    """Return the most frequent width of rows with numbers, with a preference for wide rows."""
    widths = Counter(len(rows[k][1]) for k in numeric)
    if not widths:
        begin = " ".join(rows[0][1]).strip()[:40]
        raise DataError(f"{where} has no numeric row: of {len(rows)} rows the first begins `{begin}`.")
    width = max(widths, key=lambda n: (widths[n] * n**0.5, n))
    if width > MOST_COLUMNS:
        raise DataError(f"{where} has {width} columns; at most {MOST_COLUMNS} are read. Is the separator right?")
    return width


def _find_body(rows: Sequence[Row], alike: Sequence[int], places: Sequence[int], where: str) -> list[int]:
    """Return the indices of the rows of the table."""
    body = [k for k in alike if _is_data(rows[k][1], places)]
    while len(body) > 2 and _stands_above(rows, body, places):
        body = body[1:]
    reach = body[-1] - body[0] + 1
    if len(body) * 3 < reach - 1:
        raise DataError(
            f"{where} is ragged: of {reach} rows from row {rows[body[0]][0]} on, only {len(body)} have the "
            f"{len(rows[body[0]][1])} cells, with numbers among them, that are most frequent."
        )
    return body


def _list_left(
    rows: Sequence[Row], body: Sequence[int], sets: tuple[set[int], set[int]], used: set[int], again: bool
) -> tuple[tuple[LeftOut, ...], int]:
    """Return omitted rows, and their number right above the table; `sets` holds numeric rows and rows of its width."""
    (numeric, same), inside = sets, set(body)
    spoilt = [k for k in range(body[0], body[-1] + 1) if k not in inside]
    behind = [] if again else range(body[-1] + 1, len(rows))
    above = _list_spoilt(rows, body[0], same, used)
    ragged = [k for k in [*spoilt, *behind] if k in numeric and k not in same]
    remarks = [k for k in [*above, *spoilt] if k not in ragged and rows[k][0] not in used]
    ends = [k for k in behind if k not in ragged]
    reasons = {
        "remarks, or cells that are no numbers": remarks,
        "more or fewer cells than the table has columns": ragged,
        "below the table": ends,
    }
    left = [one for reason, listed in reasons.items() for one in count_rows(reason, [rows[k][0] for k in listed])]
    return tuple(left), len(above)


def _stands_above(rows: Sequence[Row], body: Sequence[int], places: Sequence[int]) -> bool:
    """Return whether the first row is above the table: a labelled number, or a row above the headings."""
    apart = body[1] - body[0]
    (_, first), (_, second) = rows[body[0]], rows[body[1]]
    if any(names_columns(row, len(first)) for _, row in rows[body[0] + 1 : body[1]]):
        return True
    words = [cell for place, cell in enumerate(first) if place not in places and cell.strip()]
    alike = [find_kind(first[place]) == find_kind(second[place]) for place in places]
    return apart > ABOVE or (apart > 1 and (bool(words) or not any(alike)))


def _list_spoilt(rows: Sequence[Row], first: int, same: set[int], used: set[int]) -> list[int]:
    """Return the rows directly above the table that were excluded only because of non-numeric cells."""
    above = takewhile(lambda k: k in same and rows[k][0] not in used, range(first - 1, -1, -1))
    return [*above][::-1]


def _say_lines(lines: int) -> str:
    return "" if not lines else "1 heading line" if lines == 1 else f"{lines} heading lines"


def _find_places(rows: Sequence[Sequence[str]]) -> list[int]:
    """Return the columns with mostly numeric cells."""
    looked = rows[:: max(1, len(rows) // LOOKED_AT)]
    places: list[int] = []
    for place in range(len(looked[0])):
        cells = [row[place] for row in looked if not is_missing(row[place])]
        share = 0.5 if len(cells) * 2 > len(looked) else 0.95  # heading words may be next to the first rows
        if cells and sum(map(bool, map(find_kind, cells))) > share * len(cells):
            places.append(place)
    return places


def _is_data(row: Sequence[str], places: Sequence[int]) -> bool:
    """Return whether all numeric columns have values or gaps, and at least one value."""
    kinds = [(find_kind(row[p]), row[p]) for p in places]
    return all(kind or is_missing(cell) for kind, cell in kinds) and any(kind for kind, _ in kinds)


def _choose_block(
    rows: Sequence[Row], body: list[int], headings: Sequence[str], where: str
) -> tuple[list[int], tuple[str, ...]]:
    """Return the rows of the longest of several tables with the same headings, and a note about the others."""
    plain = [cell.strip() for cell in headings]
    if not any(plain):
        return body, ()
    cuts = [k for k in range(body[0], body[-1]) if [cell.strip() for cell in rows[k][1]] == plain]
    if not cuts:
        return body, ()
    edges = [body[0], *cuts, body[-1] + 1]
    blocks = [[k for k in body if a <= k < b] for a, b in pairwise(edges)]
    longest = max(blocks, key=len)
    first, last = rows[longest[0]][0], rows[longest[-1]][0]
    return longest, (f"{where} holds {len(blocks)} tables; the longest, rows {first} to {last}, is read.",)


def _read_columns(
    body: Sequence[Row], headings: Sequence[str], units: Above, style: NumberStyle, places: Sequence[int]
) -> tuple[RawColumn, ...]:
    columns: list[RawColumn] = []
    for place, heading in enumerate(headings):
        cells = [row[place] for _, row in body]
        read = read_cells(cells, style)
        wrong = tuple(WrongCell(body[k][0], cells[k].strip()[:60]) for k in read.wrong)
        sample = next((cell.strip()[:60] for cell in cells if cell.strip()), "")
        kind = read.kind if sample and place in places else "text"
        unit = units.get(place) or read.unit
        columns.append(RawColumn(heading.strip().strip('"')[:60], unit, kind, read.numbers, sample, wrong, read.unsure))
    return _use_unit_columns(columns)


def _use_unit_columns(columns: list[RawColumn]) -> tuple[RawColumn, ...]:
    """Return the columns with the unit from an adjacent column (`Reading`, `Unit`)."""
    for k, one in enumerate(columns[1:], start=1):
        before = columns[k - 1]
        if one.kind == "text" and re.fullmatch(r"units?", one.heading.lower()) and not before.unit and one.sample:
            columns[k - 1] = replace(before, unit=one.sample, unsure=False)
    return tuple(columns)


def describe_arrays(path: Path, arrays: Mapping[str, Numbers], form: str) -> RawTable:
    """Return named arrays as a table, all of the length with most numbers.

    Raises:
        DataError: there is no such array.
    """
    lengths = Counter(len(array) for array in arrays.values() if len(array) > 1)
    if not lengths:
        raise DataError(f"`{path.name}` has no numeric columns.")
    time = next((len(array) for name, array in arrays.items() if name_column(name) == "time" and len(array) > 1), 0)
    length = time or max(lengths, key=lambda n: n * lengths[n])
    table_arrays = {name: np.asarray(array, dtype=float) for name, array in arrays.items() if len(array) == length}
    others = len(arrays) - len(table_arrays)
    notes = (f"{others} arrays of another length than {length} are left out.",) if others else ()
    columns: list[RawColumn] = []
    for name, array in table_arrays.items():
        wrong = tuple(WrongCell(int(k) + 1, f"{array[k]}") for k in np.flatnonzero(np.isinf(array))[:20])
        numbers = clear_extremes(array)
        columns.append(RawColumn(name, "", "number", numbers, f"{array[0]:.9g}", wrong))
    preview = [[f"{column.numbers[k]:.9g}" for column in columns] for k in range(min(length, 20))]
    return RawTable(path.name, form, "", True, tuple(columns), np.arange(1, length + 1), preview, notes=notes)
