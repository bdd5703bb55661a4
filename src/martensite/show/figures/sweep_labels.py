"""What stands on the axes of figures of sweeps: names and units."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from martensite.base.formats import typeset_unit
from martensite.design.sweep.table import SweepColumn, SweepTable, shorten_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NARROW = 30.0
"""Ratio of the ends of a logarithmic axis below which it has numbers between powers of ten."""


def label_column(one: SweepColumn, short: str = "") -> str:
    """Name and unit of a column, for an axis."""
    return f"{short or one.name} [{typeset_unit(one.shown, '–')}]"


def label_varied(found: SweepTable) -> list[str]:
    """Labels of all varied numbers."""
    names = shorten_names(found.varied)
    return [label_column(one, names[path]) for path, one in found.varied.items()]


def set_scales(axes: Axes, x: SweepColumn, y: SweepColumn | None = None) -> None:
    """Give the axes of a panel the scales of their columns, with plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for one, axis, name in ((x, axes.xaxis, "xscale"), (y, axes.yaxis, "yscale")):
        if one is not None and one.log:
            axes.set(**{name: "log"})
            values = one.values[np.isfinite(one.values)]
            narrow = not values.size or values.max() < NARROW * values.min()
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if narrow else (1.0,)))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def write_sweep_title(found: SweepTable) -> str:
    """Title of a sweep, and how many runs it has."""
    failed = f", {found.failed:,} failed" if found.failed else ""
    missing = f", {found.missing:,} not made yet" if found.missing else ""
    return f"{found.title}: {len(found.status):,} runs{failed}{missing}"


def arrange_panels(count: int) -> tuple[int, int]:
    """Rows and columns of panels."""
    columns = 2 if count == 4 else min(count, 3)
    return -(-count // columns), columns
