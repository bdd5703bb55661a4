"""Common parts of the figures of studies: a page with a heading, and labelled axes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from martensite.show.figures.style import QUIET, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT, TITLE, LINE = 0.02, 0.24, 0.2
"""Left edge of a heading as a fraction of the width; first line below the top, and line distance [inch]."""


@contextmanager
def draw_page(width: float, height: float, title: str, *remarks: str) -> Iterator[Figure]:
    """Provide a figure [inch] for panels, with a title and remarks above them."""
    with use_style():
        figure = make_figure(width, height)
        top = 1.0 - TITLE / height
        figure.text(LEFT, top, title, fontsize=12.5, fontweight="bold", va="center")
        for k, remark in enumerate(remarks, start=1):
            figure.text(LEFT, top - k * LINE / height, remark, color=QUIET, va="center")
        yield figure


def label_axes(axes: Any, title: str, x: str, y: str, legend: str = "") -> None:
    """Write title and labels of a panel, with a legend at a location such as `upper left`."""
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if legend:
        axes.legend(loc=legend)


def add_right_axis(axes: Any, label: str, low: float, high: float, colour: str) -> Any:
    """Return a second y axis on the right of a panel, without a grid."""
    other = axes.twinx()
    other.set_ylabel(label, color=colour)
    other.set_ylim(low, high)
    other.grid(False)
    other.spines["right"].set_visible(True)
    return other
