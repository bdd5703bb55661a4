"""What the residuals of a model still hold: correlation with themselves and with the inputs.

Left, the autocorrelation of every output with the band of white residuals; right, the
correlation with every input and its square, with the bands of 95 % and 99 % for one lag and,
dashed, the limit for all lags on one side together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.identify.chains.correlations import LEVELS, Crossed
from martensite.identify.chains.validation import Validation
from martensite.search.whiteness import Whiteness
from martensite.show.figures.panels import add_panels, draw_autocorrelation, write_headline, write_title
from martensite.show.figures.style import FAINT, HEATING, INK, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHADES = ("#c9d0d5", FAINT)
"""Of the bands, narrow and wide."""


def plot_model_tests(validation: Validation, title: str = "") -> Figure:
    """Draw the tests of the residuals of a chain on a record.

    Args:
        validation: a chain on a record.
        title: headline.
    """
    outputs = validation.record.output_names
    rows = [[one for one in validation.crossed if one.output == name] for name in outputs]
    columns = 1 + max((len(row) for row in rows), default=0)
    with use_style():
        figure = make_figure(3.1 * max(columns, 2), 0.95 + 2.3 * len(outputs))
        on = f"{validation.chain.name} on {validation.record.name}"
        write_headline(figure, title or f"Residuals of {on}")
        room = (0.7, 0.12, 0.65, 0.5)
        panels = add_panels(figure, len(outputs), columns, room, (0.62, 0.75))
        white = {one.record: one for one in validation.whiteness}
        for name, (first, *others), row in zip(outputs, panels, rows, strict=True):
            test = white.get(f"{validation.record.name}, {name}")
            if test is None:
                first.set_axis_off()
            else:
                _draw_memory(first, name, test)
            for axes, one in zip(others, row, strict=False):
                _draw_cross_correlation(axes, one)
            for axes in others[len(row) :]:
                axes.set_axis_off()
        return figure


def _draw_memory(axes: Any, output: str, test: Whiteness) -> None:
    draw_autocorrelation(axes, test)
    axes.set_xlabel("lag [samples]")
    axes.set_ylabel("autocorrelation")
    words = "white" if test.white else "not white"
    write_title(axes, f"{output} with itself: {words}", color=INK, fontsize=8.0)


def _draw_cross_correlation(axes: Any, one: Crossed) -> None:
    lags = np.array(one.lags) * one.interval
    for level, shade in zip(reversed(LEVELS), reversed(SHADES), strict=True):
        band = one.band(level)
        axes.axhspan(-band, band, color=shade, linewidth=0.0, zorder=0.6)
    for sign in (-1.0, 1.0):
        axes.axhline(sign * one.limit, color=QUIET, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1.1)
    axes.axhline(0.0, color=QUIET, linewidth=0.7, zorder=1.2)
    colour = SIMULATED if one.explained else HEATING
    axes.vlines(lags, 0.0, one.values, color=colour, linewidth=1.6, zorder=2.0)
    reach = 1.15 * max(one.limit, *(abs(value) for value in one.values))
    axes.set_ylim(-reach, reach)
    axes.set_xlabel("lag [s]")
    words = "nothing left" if one.explained else "something left"
    signal = one.signal.replace("`", "")
    write_title(axes, f"{one.output} with {signal}: {words}", color=INK, fontsize=8.0)
