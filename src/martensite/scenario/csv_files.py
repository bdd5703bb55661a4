"""CSV files of results, with one row per sample and SI units in the headings, which `read_table` reads.

Headings are safe in a spreadsheet (`logs.record_text`), and numbers have all digits. Paths of material points have
familiar units; a table of several paths has a column `case`, which comments at the top explain.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from martensite.base import units
from martensite.base.files import replace_file, write_file
from martensite.logs.record_text import format_heading
from martensite.simulate.point import PointResult
from martensite.simulate.result import Result

COLUMNS = {
    "time": ("s", "s"),
    "temperature": ("K", "degC"),
    "stress": ("Pa", "MPa"),
    "strain": ("1", "%"),
    "martensite_fraction": ("1", "1"),
    "oriented_fraction": ("1", "1"),
}
"""SI unit and written unit of a column, by heading."""
_NAMES = {"martensite_fraction": "martensite", "oriented_fraction": "oriented"}


def write_csv(result: Result, path: str | os.PathLike[str]) -> None:
    """Write all columns of a result; the file is replaced as a whole or not at all.

    Raises:
        DataError: the file cannot be written.
    """
    columns = list_columns(result)
    with replace_file(Path(path)) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([format_heading(name, unit) for name, unit, _ in columns])
        writer.writerows(zip(*(values for _, _, values in columns), strict=True))


def list_columns(result: Result) -> list[tuple[str, str, Any]]:
    """Return name, SI unit and values of all columns of a result; a batch run by run, with its parameters."""
    variants = result.variants
    if variants is None:
        names = ["time", *result.columns]
        return [(name, result.unit(name), result[name].tolist()) for name in names]
    samples, units = len(result.times), {leaf.path: leaf.declared.unit for leaf in result.system.leaves()}
    table = {"variant": ("1", range(len(variants)))} | {p: (units[p], v.tolist()) for p, v in variants.over.items()}
    first = [(name, unit, [one for one in values for _ in range(samples)]) for name, (unit, values) in table.items()]
    times = ("time", "s", result.times.tolist() * len(variants))
    return [*first, times, *((name, result.unit(name), result[name].ravel().tolist()) for name in result.columns)]


def write_points(results: Sequence[PointResult], path: Path) -> None:
    """Write paths of material points as CSV; the file is replaced as a whole or not at all.

    Raises:
        DataError: the file cannot be written.
    """
    several = len(results) > 1
    lines = [f"# case {i}: {r.law.registered_name}, {r.label}" for i, r in enumerate(results)]
    headings = [f"{name} [{display_unit}]" for name, (_, display_unit) in COLUMNS.items()]
    lines.append(",".join(["case [1]", *headings] if several else headings))
    for i, result in enumerate(results):
        columns = [
            [units.from_si(value, display_unit, unit) for value in result[_NAMES.get(name, name)]]
            for name, (unit, display_unit) in COLUMNS.items()
        ]
        for row in zip(*columns, strict=True):
            cells = [f"{value:.9g}" for value in row]
            lines.append(",".join([str(i), *cells] if several else cells))
    write_file(path, "\n".join(lines) + "\n")
