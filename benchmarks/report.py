"""Tables of the benchmark sections: printed with rich, or kept as JSON."""

from __future__ import annotations

import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

PACKAGES = ("martensite", "numpy", "diffrax", "numba", "numbalsoda", "scipy", "scikit-sundae")


class Table(NamedTuple):
    """One printed table; each row maps a column (with its unit) to a text or a number."""

    title: str
    rows: list[dict[str, Any]]
    note: str = ""


def text_of(column: str, value: Any) -> str:
    """A number as printed: errors as powers of ten, the rest with three digits."""
    if value is None:
        return "-"
    if value != value:
        return "failed"
    if not isinstance(value, float):
        return str(value)
    if column.startswith("err"):
        return f"{value:.1e}"
    if column.startswith("spread"):
        return f"{100 * value:.0f} %"
    return f"{value:.0f}" if value >= 1000 else f"{value:.3g}"


def show(console: Any, table: Table) -> None:
    """Print one table."""
    from rich.markup import escape
    from rich.table import Table as Grid

    grid = Grid(title=table.title, caption=table.note or None, title_justify="left", caption_justify="left")
    columns = list(dict.fromkeys(column for row in table.rows for column in row))
    for column in columns:
        first = next(row[column] for row in table.rows if column in row)
        grid.add_column(escape(column), justify="left" if isinstance(first, str) else "right", no_wrap=True)
    for row in table.rows:
        grid.add_row(*(text_of(column, row.get(column)) for column in columns))
    console.print(grid)


def machine() -> dict[str, Any]:
    """Processor, load, and versions of what was compared."""
    found = {"python": sys.version.split()[0], "system": platform.platform()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    found["processor"] = names[0] if names else platform.processor()
    return {**found, "cores": os.cpu_count(), "load": round(os.getloadavg()[0], 2)}
