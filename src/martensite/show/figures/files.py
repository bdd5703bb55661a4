"""Writing figures: the format follows from the suffix, and the file appears whole."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import DataError
from martensite.base.files import write_file
from martensite.show.figures.style import use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")


def check_format(path: Path) -> str:
    """The format that the suffix names, or `DataError`."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        allowed = ", ".join(f"`.{name}`" for name in FORMATS)
        raise DataError(f"The figure `{path}` has no suffix that can be drawn; use {allowed}.")
    return kind


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure as png, svg or pdf; the file is replaced whole or not at all.

    Raises:
        DataError: the suffix is another one, or the file cannot be written.
    """
    kind = check_format(path)
    drawn = io.BytesIO()  # a PDF that is not finished breaks down in its own way
    with use_style():
        figure.savefig(drawn, format=kind)
    write_file(path, drawn.getbuffer())
