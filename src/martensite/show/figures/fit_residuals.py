"""What a fit leaves over: residuals over time, and how long they remember.

Left, modelled less measured; right, the autocorrelation of what was fitted, with the band that
holds 95 % of the lags if the residuals are white.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.formats import choose_difference_unit
from martensite.fit.fit import ComparedOutput, list_compared
from martensite.show.figures.fit import HELD, TIME, TINT, make_output_axis
from martensite.show.figures.labels import QuantityAxis
from martensite.show.figures.panels import (
    add_panels,
    draw_autocorrelation,
    pick_evenly,
    shorten_name,
    write_headline,
    write_title,
)
from martensite.show.figures.style import INK, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.fit.fit import Fit
    from martensite.search.whiteness import Whiteness

MOST = 8
"""Records and outputs drawn at most; of more, those spread evenly."""
ROOM = 1.12
"""Half the height of a panel over the largest residual."""


def plot_fit_residuals(fit: Fit, title: str = "") -> Figure:
    """Draw the residuals of every record and output, and their autocorrelation.

    Args:
        fit: a finished fit.
        title: headline.
    """
    rows = pick_evenly(list_compared(fit), MOST)
    tests = {one.record: one for one in fit.whiteness}
    with use_style():
        figure = make_figure(9.2, 0.55 + 1.75 * len(rows))
        write_headline(figure, title or "Residuals: modelled less measured")
        room, gaps = (0.74, 0.14, 0.75, 0.48), (0.65, 0.67)
        panels = add_panels(figure, len(rows), 2, room, gaps, width_ratios=(1.7, 1.0))
        reach = _find_reach(rows)
        for one, (left, right) in zip(rows, panels, strict=True):
            last = one is rows[-1]
            _draw_over_time(left, one, reach[one.output], last)
            _draw_memory(right, tests.get(f"{one.record}, {one.output}"), last)
        return figure


def _find_reach(rows: list[ComparedOutput]) -> dict[str, float]:
    """Largest residual of every output, in SI."""
    found: dict[str, float] = {}
    for one in rows:
        largest = float(np.nanmax(np.abs(one.residuals)))
        found[one.output] = max(found.get(one.output, 0.0), largest)
    return found


def _draw_over_time(axes: Any, one: ComparedOutput, reach: float, last: bool) -> None:
    shown = make_output_axis(one.output, one.description)
    factor = _find_factor(shown)
    axes.axhline(0.0, color=QUIET, linewidth=0.7, zorder=1.2)
    for part, colour in ((one.used, SIMULATED), (one.held, HELD)):
        if part.any():
            values = np.where(part, one.residuals, np.nan) / factor
            axes.plot(one.times, values, color=colour, linewidth=0.9, zorder=2.0)
    if one.held.any() and not one.used.any():
        axes.set_facecolor(TINT)
    axes.set_ylim(-ROOM * reach / factor or -1.0, ROOM * reach / factor or 1.0)
    axes.set_ylabel(f"{one.output} [{shown.difference_unit or '–'}]")
    axes.set_xlabel(TIME.label if last else "")
    held = " (held out)" if one.held.any() and not one.used.any() else ""
    write_title(axes, shorten_name(one.record) + held, fontweight="bold", color=HELD if held else INK)


def _find_factor(shown: QuantityAxis) -> float:
    """SI per unit of a difference."""
    return 0.01 if shown.shown == "%" else choose_difference_unit(shown.unit)[1]


def _draw_memory(axes: Any, test: Whiteness | None, last: bool) -> None:
    """Autocorrelation by lag, within or beyond its band."""
    if test is None:
        axes.set_axis_off()
        return
    draw_autocorrelation(axes, test)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_xlabel("lag [samples]" if last else "")
    axes.set_ylabel("autocorrelation")
    verdict = "white" if test.white else "not white"
    probability = "p < 0.0001" if test.p_value < 1e-4 else f"p = {test.p_value:.2g}"
    write_title(axes, f"{verdict} ({probability})", color=QUIET, fontsize=8.0)
