"""What the figures of studies share: a heading above the panels, and labelled axes."""

from __future__ import annotations

from typing import Any

from martensite.show.figures.style import QUIET

LEFT, TITLE, LINE = 0.02, 0.24, 0.2
"""Left edge of a heading as a share of the width; its first line below the top, and further ones
below that [inch]."""


def write_heading(figure: Any, title: str, *remarks: str) -> None:
    """Write a title above the panels of a figure, and remarks below it."""
    height = figure.get_size_inches()[1]
    top = 1.0 - TITLE / height
    figure.text(LEFT, top, title, fontsize=12.5, fontweight="bold", va="center")
    for k, remark in enumerate(remarks, start=1):
        figure.text(LEFT, top - k * LINE / height, remark, color=QUIET, va="center")


def label_axes(axes: Any, title: str, x: str, y: str, legend: str = "") -> None:
    """Write title and labels of a panel, and a legend at a place such as `upper left`."""
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if legend:
        axes.legend(loc=legend)
