"""Results as CSV: one row per sample, SI units in the headings, readable by `read_table`.

Spreadsheets take a cell that begins with = + - @ for a formula. Names come from documents that
others may have written, so a heading that begins so gets an apostrophe in front; numbers are
written as they are, with all their digits.
"""

from __future__ import annotations

import csv
import os
from pathlib import Path

from martensite.base.files import replace_file
from martensite.simulate.result import Result

FORMULA = ("=", "+", "-", "@", "\t", "\r")


def write_csv(result: Result, path: str | os.PathLike[str]) -> None:
    """Write all columns of a result; the file is replaced as a whole or not at all.

    Raises:
        DataError: the file cannot be written.
    """
    headings = [format_heading("time", "s"), *(format_heading(n, result.unit(n)) for n in result.columns)]
    with replace_file(Path(path)) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(headings)
        writer.writerows(zip(result.times, *result.columns.values(), strict=True))


def format_heading(name: str, unit: str) -> str:
    """A name with its unit, safe in a spreadsheet."""
    text = f"{name} [{unit}]"
    return f"'{text}" if text.startswith(FORMULA) else text
