"""Common parts of figures with several panels: grid, headline, and key."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from martensite.show.figures.style import FAINT, HEATING, INK, QUIET, SIMULATED, make_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.search.whiteness import Whiteness

Row = TypeVar("Row")
Room = tuple[float, float, float, float]
LETTERS = 14.0
"""Letters per inch of a warning."""
WARNING_LINE = 0.18
"""Height of a line of a warning [inch]."""


def pick_evenly(rows: Sequence[Row], most: int) -> list[Row]:
    """Return at most `most` rows, evenly spread."""
    if len(rows) <= most:
        return list(rows)
    return [rows[k] for k in np.linspace(0, len(rows) - 1, most).round().astype(int)]


def add_panels(
    figure: Figure, rows: int, columns: int, room: Room, gaps: tuple[float, float] = (0.7, 0.6), **how: Any
) -> Any:
    """Return panels at fixed distances from the figure edges, an array (rows, columns).

    Args:
        figure: the figure.
        rows: number of rows.
        columns: number of columns.
        room: margins left, right, above and below [inch].
        gaps: distances between columns and between rows [inch].
        how: `width_ratios`, `height_ratios`, and arguments of `subplots`.
    """
    (width, height), (left, right, above, below) = figure.get_size_inches(), room
    across = (width - left - right - gaps[0] * (columns - 1)) / columns
    down = (height - above - below - gaps[1] * (rows - 1)) / rows
    ratios = {name: how.pop(name) for name in ("width_ratios", "height_ratios") if name in how}
    grid = figure.add_gridspec(
        rows,
        columns,
        left=left / width,
        right=1.0 - right / width,
        top=1.0 - above / height,
        bottom=below / height,
        wspace=gaps[0] / across,
        hspace=gaps[1] / down,
        **ratios,
    )
    panels: Any = grid.subplots(squeeze=False, **how)
    for axes in panels.flat:
        axes.set_title("", y=1.0)  # a title that is placed by matplotlib lays out all tick labels twice
        axes.yaxis.get_offset_text().set_horizontalalignment("right")
    return panels


def make_grid(count: int, title: str) -> tuple[Figure, list[Any]]:
    """Return a figure of `count` panels, with space for a headline and a key above."""
    columns = {1: 1, 2: 2, 4: 2}.get(count, 3)
    rows = math.ceil(count / columns)
    width, height = {1: 6.4, 2: 9.2, 3: 11.5}[columns], 1.0 + (2.95 if columns < 3 else 2.6) * rows
    figure = make_figure(width, height)
    write_headline(figure, title)
    panels = list(add_panels(figure, rows, columns, (0.62, 0.15, 1.0, 0.48), (0.62, 0.7)).flat)
    for axes in panels[count:]:
        axes.remove()
    return figure, panels[:count]


def wrap_warnings(warnings: Iterable[str], width: float) -> list[str]:
    """Return the lines of warnings at the foot of a figure of a width [inch]."""
    return [line for text in warnings for line in textwrap.wrap(text, int(LETTERS * width))]


def write_headline(figure: Figure, title: str, lead: str = "", warnings: Sequence[str] = ()) -> None:
    """Write the title of a figure at its upper left, a line below it, and warnings at its foot."""
    width, height = figure.get_size_inches()
    plain = {"va": "center", "parse_math": False}
    left, top = 0.2 / width, 1.0 - 0.24 / height
    figure.text(left, top, title, fontsize=12.0, fontweight="bold", **plain)
    if lead:
        figure.text(left, top - 0.23 / height, lead, color=QUIET, **plain)
    for i, line in enumerate(reversed(warnings)):
        place = (0.16 + WARNING_LINE * i) / height
        figure.text(left, place, line, color=HEATING, fontsize=8.0, **plain)


def write_title(axes: Any, text: str, **look: Any) -> None:
    """Write a title of a panel without mathematics."""
    axes.set_title(text, **look).set_parse_math(False)


def shorten_name(name: str, most: int = 34) -> str:
    """Return a name, shortened in its middle."""
    if len(name) <= most:
        return name
    tail = (most - 1) // 2
    return f"{name[: most - 1 - tail]}…{name[-tail:]}"


def add_key(figure: Figure, handles: Sequence[Any], labels: Sequence[str], below: float = 0.4) -> None:
    """Add a key of lines, `below` the top of a figure [inch], if there are labels."""
    if not labels:
        return
    width, height = figure.get_size_inches()
    key = figure.legend(
        list(handles),
        list(labels),
        loc="upper left",
        ncols=min(len(labels), 7),
        borderpad=0.0,
        borderaxespad=0.0,
        columnspacing=1.6,
        bbox_to_anchor=(0.2 / width, 1.0 - below / height),
    )
    for text in key.get_texts():
        text.set_parse_math(False)


def add_colour_key(figure: Figure, colours: Mapping[str, Any]) -> None:
    """Add a key of the colours below the headline."""
    add_key(figure, make_colour_samples(colours), list(colours))


def make_colour_samples(colours: Mapping[str, Any]) -> list[Any]:
    """Return lines in these colours, for a key."""
    from matplotlib.lines import Line2D

    return [Line2D([], [], color=tint) for tint in colours.values()]


def add_legend_above(axes: Any, columns: int = 6) -> None:
    """Add a legend above a panel on the right, if it has named lines."""
    if axes.get_legend_handles_labels()[1]:
        axes.legend(
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=columns,
            borderpad=0.0,
            borderaxespad=0.2,
            columnspacing=1.2,
        )


def share_limits(row: Sequence[Any]) -> None:
    """Give all axes of a row common limits, and only the first a label."""
    for which in ("xlim", "ylim"):
        ends = [getattr(axes, f"get_{which}")() for axes in row]
        both = min(low for low, _ in ends), max(high for _, high in ends)
        for axes in row:
            axes.set(**{which: both})
    for axes in row[1:]:
        axes.set_ylabel("")


def add_colour_bar(figure: Any, mappable: Any, axes: Any, label: str, **how: Any) -> None:
    """Add the colour bar of a map."""
    bar = figure.colorbar(mappable, ax=axes, pad=0.02, **how)
    bar.set_label(label, color=INK)
    bar.outline.set_visible(False)


def draw_start(axes: Any, x: Any, y: Any, label: str = "_start") -> None:
    """Draw a ring at the start of a path."""
    ring = {"marker": "o", "markersize": 5.0, "markerfacecolor": "white", "color": INK}
    axes.plot(x[:1], y[:1], linestyle="none", zorder=3.2, label=label, **ring)


def measure_way(axes: Any, x: Any, y: Any) -> Any:
    """Return the distance along a curve to each of its points, as fractions of the axes."""
    across, up = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
    return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x) / across, np.diff(y) / up))])


def draw_arrow(axes: Any, x: Any, y: Any, colour: str, at: float = 0.66) -> None:
    """Draw an arrowhead at a fraction of a curve, beyond its middle to distinguish the way back.

    The axes must have their limits already.
    """
    way = measure_way(axes, x, y)
    if way[-1] <= 0.0:
        return
    size = min(float(way[-1]), 1.0)
    ends = (at * way[-1] - 0.04 * size, at * way[-1] + 0.02 * size)
    tail, head = (tuple(float(np.interp(w, way, c)) for c in (x, y)) for w in ends)
    style = {"arrowstyle": "-|>,head_width=0.24,head_length=0.7", "mutation_scale": 18.0, "lw": 0.0}
    flush = {"shrinkA": 0.0, "shrinkB": 0.0, "color": colour}
    axes.annotate("", head, tail, arrowprops={**style, **flush}, zorder=3.0)


def make_panels(
    width: float, height: float, rows: int, columns: int, title: str = "", **how: Any
) -> tuple[Figure, Any]:
    """Return a figure [inch] with automatically placed panels, an array (rows, columns)."""
    figure = make_figure(width, height)
    figure.set_layout_engine("constrained")
    write_suptitle(figure, title)
    return figure, figure.subplots(rows, columns, squeeze=False, **how)


def write_suptitle(figure: Any, title: str) -> None:
    """Write the title of a figure with automatically placed panels."""
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontsize=12.0, fontweight="bold").set_parse_math(False)


def draw_autocorrelation(axes: Any, test: Whiteness) -> None:
    """Draw an autocorrelation over lags, with the band of white residuals."""
    lags = np.arange(1, len(test.autocorrelation) + 1)
    axes.axhspan(-test.band, test.band, color=FAINT, linewidth=0.0, zorder=0.6)
    axes.axhline(0.0, color=QUIET, linewidth=0.7, zorder=1.2)
    axes.vlines(lags, 0.0, test.autocorrelation, color=SIMULATED, linewidth=1.6, zorder=2.0)
    axes.set(ylim=(-1.08, 1.08), xlim=(0.0, len(lags) + 1.0))
