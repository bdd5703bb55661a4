"""What commands print: text and tables for people, JSON for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

WIDTH_OF_A_PIPE = 150


def console() -> Console:
    """A console on standard output; wide where there is no terminal to fit."""
    from rich.console import Console

    found = Console(highlight=False, markup=False, emoji=False)
    if not found.is_terminal:
        found.width = WIDTH_OF_A_PIPE
    return found


def text(line: str = "", style: str = "") -> None:
    """Print a line that a terminal may wrap but nothing else does."""
    from rich.text import Text

    console().print(Text(line, style=style), soft_wrap=True)


def table(
    columns: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    right: str = "",
    colours: Mapping[str, Mapping[str, str]] | None = None,
) -> None:
    """Print a table.

    Args:
        columns: headings.
        rows: cells of each row.
        right: comma-separated names of columns to be aligned to the right.
        colours: colour of a cell by its column and its text.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    made = Table(box=box.SIMPLE, pad_edge=False)
    for name in columns:
        justify = "right" if name in right.split(",") else "left"
        made.add_column(name, justify=justify, overflow="fold")
    styles = [(colours or {}).get(name, {}) for name in columns]
    for row in rows:
        made.add_row(*(Text(c, style=s.get(c, "")) for c, s in zip(row, styles, strict=True)))
    console().print(made)


def as_json(value: Any) -> None:
    """Print JSON; numbers that JSON does not have become null."""
    from martensite.scenario.plain import convert_to_plain

    typer.echo(json.dumps(convert_to_plain(value), indent=2, ensure_ascii=False))


def quantity(value: float, unit: str) -> str:
    """A number declared in the SI `unit`, in a readable unit; `none` for a limit that is none."""
    from martensite.base import units

    if math.isinf(value):
        return "none"

    shown = units.choose_readable_unit(unit)
    number = f"{units.from_si(value, shown, unit):.6g}"
    return number if shown == "1" else f"{number} {shown}"


def difference(value: float, unit: str) -> str:
    """A difference of two quantities declared in the SI `unit`, in a readable unit."""
    from martensite.base import units

    shown = units.choose_readable_unit(unit)
    factor, _ = units.find_conversion(shown, unit)
    label = {"1": "", "degC": " K"}.get(shown, f" {shown}")
    return f"{value / factor:.4g}{label}"
