"""A table as it was uploaded: its headings and first rows as text, its numbers without a meaning.

Cells are text: one that looks like a formula is shown as it stands, and is no number.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from martensite.base.errors import DataError, InputError, ParameterError, suggest_name
from martensite.scenario.binary_files import read_arrays
from martensite.scenario.layout import CLOCK, FileColumn, Layout
from martensite.scenario.sheets import SEPARATORS, Sheet, can_parse, is_gap, is_number, read_sheet
from martensite.scenario.tables import BINARY

PREVIEW_ROWS = 20
"""Rows of the preview."""
MOST_COLUMNS = 200
"""Columns that are looked at."""
LONGEST_CELL = 60
_WIDE = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
"""First bytes of text that is not read -> its encoding."""


@dataclass(frozen=True)
class RawColumn:
    """One column: its heading, and what is in it."""

    heading: str
    sample: str
    """Its first cell that is no gap."""
    numbers: list[float]
    """NaN where there is none."""
    wrong: int = 0
    """Cells that are neither numbers nor gaps."""
    first_wrong: str = ""
    """Row and text of the first of them."""


@dataclass(frozen=True)
class RawTable:
    """A table."""

    name: str
    separator: str
    """`tab`, `semicolon`, `comma`, `whitespace`; empty for a file that is no text."""
    headed: bool
    """Whether the file has headings of its own."""
    preview: list[list[str]]
    columns: list[RawColumn]
    ragged: int = 0
    """Rows with more or fewer cells than the first."""
    first_ragged: str = ""

    @property
    def rows(self) -> int:
        """Rows of numbers."""
        return len(self.columns[0].numbers)


def read_raw(path: Path, separator: str = "auto") -> RawTable:
    """Read a file without knowing what is in it.

    Raises:
        DataError: it is empty, no table, or not of a kind that is read.
    """
    if separator not in ("auto", *SEPARATORS):
        raise ParameterError(f"There is no separator `{separator}`. {suggest_name('', SEPARATORS)}")
    found = _read_arrays(path) if path.suffix.lower() in BINARY else _read_text(path, separator)
    if len(found.columns) > MOST_COLUMNS:
        raise DataError(
            f"`{path.name}` has {len(found.columns)} columns; at most {MOST_COLUMNS} are read. Is "
            "the separator right, and does every row stand in a line of its own?"
        )
    return found


def _read_text(path: Path, separator: str) -> RawTable:
    with path.open("rb") as file:
        encoding = _WIDE.get(file.read(2))
    if encoding:
        raise DataError(
            f"`{path.name}` is text in {encoding}; save the table as CSV in UTF-8 (a spreadsheet "
            "calls this `CSV UTF-8`)."
        )
    sheet = read_sheet(path, Layout((), separator))
    first = sheet.rows[0]
    headed = not any(map(is_number, first))
    body = sheet.part(range(1, len(sheet.rows))) if headed else sheet
    if not body.rows:
        raise DataError(f"`{path.name}` holds headings but no rows of numbers.")
    width = len(first)
    preview = [[cell[:LONGEST_CELL] for cell in row] for row in body.rows[:PREVIEW_ROWS]]
    odd = [i for i, row in enumerate(body.rows) if len(row) != width]
    even = body.part([i for i, row in enumerate(body.rows) if len(row) == width]) if odd else body
    if not even.rows:
        raise DataError(
            f"`{path.name}`: no row has as many cells as the first, {width}; is the separator "
            "right, and are the headings the first line?"
        )
    columns = [_describe_column(even, place, first[place].strip() if headed else "") for place in range(width)]
    return RawTable(
        path.name,
        _name_separator(path, separator, first),
        headed,
        preview,
        columns,
        len(odd),
        f"row {body.numbers[odd[0]]} has {len(body.rows[odd[0]])} cells" if odd else "",
    )


def _name_separator(path: Path, asked: str, first: Sequence[str]) -> str:
    if asked != "auto":
        return asked
    with path.open("rb") as file:
        lines = (line.decode("utf-8-sig", "replace") for line in file)
        line = next((x for x in lines if x.strip() and not x.lstrip().startswith("#")), "")
    return next((name for name, sign in SEPARATORS.items() if sign in line), "whitespace")


def _describe_column(sheet: Sheet, place: int, heading: str) -> RawColumn:
    cells = [row[place] for row in sheet.rows]
    sample = next((cell.strip() for cell in cells if not is_gap(cell)), "")
    parse = sheet.parser(FileColumn("", "1", "1"))
    clock = sheet.parser(FileColumn("time", CLOCK, "s"))
    if sample and not can_parse(parse, sample) and can_parse(clock, sample):
        parse = clock
    wrong, first_wrong, numbers = 0, "", list[float]()
    for index, cell in enumerate(cells):
        number = _parse_number(parse, cell)
        if number is None:
            if not wrong:
                first_wrong = f"row {sheet.numbers[index]}: {cell.strip()[:LONGEST_CELL]}"
            wrong += 1
        numbers.append(math.nan if number is None else number)
    return RawColumn(heading[:LONGEST_CELL], sample[:LONGEST_CELL], numbers, wrong, first_wrong)


def _parse_number(parse: Callable[[str], float], cell: str) -> float | None:
    try:
        number = parse(cell)
    except ValueError:
        return math.nan if is_gap(cell) else None
    return None if math.isinf(number) else number


def _read_arrays(path: Path) -> RawTable:
    """A file that holds arrays; those of the length that holds most of its numbers."""
    try:
        found = read_arrays(path)
    except InputError:
        raise
    except Exception as error:  # readers of files from outside fail in ways of their own
        words = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DataError(f"`{path.name}` cannot be read as {path.suffix}: {words}.") from None
    arrays = {str(name): [float(x) for x in array] for name, array in found.items()}
    lengths = [len(array) for array in arrays.values()]
    if not lengths:
        raise DataError(f"`{path.name}` holds no columns of numbers.")
    length = max(set(lengths), key=lambda n: n * lengths.count(n))
    columns = [
        _replace_infinite(RawColumn(name, f"{array[0]:.9g}", array))
        for name, array in arrays.items()
        if len(array) == length
    ]
    rows = min(length, PREVIEW_ROWS)
    preview = [[f"{column.numbers[k]:.9g}" for column in columns] for k in range(rows)]
    others = len(arrays) - len(columns)
    words = f"{others} arrays of another length than {length} are left out" if others else ""
    return RawTable(path.name, "", True, preview, columns, others, words)


def _replace_infinite(column: RawColumn) -> RawColumn:
    rows = [k for k, number in enumerate(column.numbers) if math.isinf(number)]
    if not rows:
        return column
    numbers = [math.nan if math.isinf(number) else number for number in column.numbers]
    first = f"row {rows[0] + 1}: {column.numbers[rows[0]]}"
    return replace(column, numbers=numbers, wrong=len(rows), first_wrong=first)
