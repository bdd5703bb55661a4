"""What figures of several panels have in common: their grid, their headline, and their key."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from martensite.show.figures.style import FAINT, QUIET, SIMULATED, make_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.search.whiteness import Whiteness

Row = TypeVar("Row")


def pick_evenly(rows: Sequence[Row], most: int) -> list[Row]:
    """At most so many, evenly spread."""
    if len(rows) <= most:
        return list(rows)
    return [rows[k] for k in np.linspace(0, len(rows) - 1, most).round().astype(int)]


def make_grid(count: int, title: str) -> tuple[Figure, list[Any]]:
    """A figure of so many panels, with room for a headline and a key above."""
    columns = {1: 1, 2: 2, 4: 2}.get(count, 3)
    rows = math.ceil(count / columns)
    width, height = {1: 6.4, 2: 9.2, 3: 11.5}[columns], 1.0 + (2.95 if columns < 3 else 2.6) * rows
    figure = make_figure(width, height)
    specs = figure.add_gridspec(
        rows,
        columns,
        left=0.62 / width,
        right=1.0 - 0.15 / width,
        top=1.0 - 1.0 / height,
        bottom=0.48 / height,
        wspace=0.62 / (width / columns - 0.4),
        hspace=0.42,
    )
    write_headline(figure, title)
    return figure, [figure.add_subplot(specs[k // columns, k % columns]) for k in range(count)]


def write_headline(figure: Figure, title: str) -> None:
    """The title of a figure, at the upper left."""
    height = figure.get_size_inches()[1]
    place = 0.2 / figure.get_size_inches()[0]
    text = figure.text(
        place, 1.0 - 0.22 / height, title, fontsize=11.5, fontweight="bold", va="center"
    )
    text.set_parse_math(False)


def write_title(axes: Any, text: str, **look: Any) -> None:
    """A title of a panel in which nothing is mathematics."""
    axes.set_title(text, **look).set_parse_math(False)


def shorten_name(name: str, most: int = 34) -> str:
    """A name, or its beginning and end: members of a series differ in either."""
    if len(name) <= most:
        return name
    kept = (most - 1) // 2
    return f"{name[: most - 1 - kept]}…{name[-kept:]}"


def add_key(figure: Figure, handles: Sequence[Any], labels: Sequence[str]) -> None:
    """What the lines are, below the headline."""
    width, height = figure.get_size_inches()
    figure.legend(
        list(handles),
        list(labels),
        loc="upper left",
        ncols=len(labels),
        borderpad=0.0,
        borderaxespad=0.0,
        columnspacing=1.6,
        bbox_to_anchor=(0.2 / width, 1.0 - 0.4 / height),
    )


def make_panels(
    width: float, height: float, rows: int, columns: int, **how: Any
) -> tuple[Figure, Any]:
    """A figure [inch] whose panels, an array (rows, columns), find their places themselves."""
    figure = make_figure(width, height)
    figure.set_layout_engine("constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **how)


def draw_autocorrelation(axes: Any, test: Whiteness) -> None:
    """Bars of an autocorrelation over lags, in the band that white residuals stay within."""
    lags = np.arange(1, len(test.autocorrelation) + 1)
    axes.axhspan(-test.band, test.band, color=FAINT, linewidth=0.0, zorder=0.6)
    axes.axhline(0.0, color=QUIET, linewidth=0.7, zorder=1.2)
    axes.vlines(lags, 0.0, test.autocorrelation, color=SIMULATED, linewidth=1.6, zorder=2.0)
    axes.set_ylim(-1.08, 1.08)
    axes.set_xlim(0.0, len(lags) + 1.0)
