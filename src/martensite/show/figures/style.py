"""The style of all figures, and their files.

Colours are from the palette of Okabe and Ito, safe for the colour-blind. Heating is vermilion and cooling blue in all
figures. The style holds inside `use_style()` only and does not change the caller's matplotlib settings.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError
from martensite.base.files import write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK = "#22303c"
SIMULATED = "#1f5f8b"
HEATING = "#d55e00"
COOLING = "#0072b2"
MEASURED = ("#6f6f6f", "#b0783c", "#5a8f7b", "#8a6fa8")
QUIET = "#6b7680"
FAINT = "#dfe3e6"

STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.edgecolor": QUIET,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "legend.handlelength": 1.4,
    "figure.facecolor": "white",
    "figure.dpi": 110.0,
    "savefig.dpi": 150.0,
    "savefig.facecolor": "white",
    "svg.hashsalt": "martensite",
}
FORMATS = ("png", "svg", "pdf")
_PATH = re.compile(r'(?<=<path d=")[^"]+')
_DIGITS = re.compile(r"(\.\d\d)\d+")


@contextmanager
def use_style() -> Iterator[None]:
    """Apply the style of this package to figures made and saved inside."""
    import matplotlib

    with matplotlib.rc_context(STYLE):
        yield


def make_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size [inch] that needs no window; call it inside `use_style()`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def check_format(path: Path) -> str:
    """Return the format of a file suffix."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        allowed = ", ".join(f"`.{name}`" for name in FORMATS)
        raise DataError(f"The figure `{path}` has no suffix that can be drawn; use {allowed}.")
    return kind


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure as png, svg or pdf."""
    kind = check_format(path)
    if kind == "svg":
        return write_file(path, format_svg(figure))
    buffer = io.BytesIO()  # a failed PDF raises its own errors
    with use_style():
        figure.savefig(buffer, format=kind)
    return write_file(path, buffer.getbuffer())


def format_svg(figure: Figure) -> str:
    """Return a figure as SVG: equal figures give equal text, and paths are exact to 0.01 point."""
    buffer = io.StringIO()
    with use_style():
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return _PATH.sub(lambda path: " ".join(_DIGITS.sub(r"\1", path[0]).split()), buffer.getvalue())
