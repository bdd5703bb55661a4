"""Figures of a fit: data and model by record, over time and as loops, and residuals.

Held-out data have a tinted background and another model colour. The autocorrelation of the residuals is drawn with the
95 % band of white residuals.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanisms.base import Output
from martensite.base import units
from martensite.base.errors import InputError
from martensite.base.formats import choose_difference_unit
from martensite.fit.fit import HELD_OUT, TRAINING, ComparedOutput, list_compared
from martensite.fit.fit_verdicts import format_error
from martensite.show.figures.labels import QuantityAxis, enclose_values
from martensite.show.figures.panels import (
    add_colour_key,
    add_panels,
    draw_autocorrelation,
    make_grid,
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

HELD = "#a03c6e"
"""Colour of the model on held-out data."""
TINT = "#f7eef3"
"""Background colour of held-out data."""
SEEN = "#9aa2a9"
"""Colour of measured data."""
DOTS = 150
"""Largest number of rows drawn as dots."""
MOST = 12
"""Largest number of panels; of more, evenly spread ones are drawn."""
WARM = 1.0
"""Smallest range of a measured temperature for a loop [K]."""
TIME = QuantityAxis("time", "time", "t", "s", "s")
CONDITION = QuantityAxis("condition", "condition", "row of the table", "1", "1")
MOST_RESIDUALS = 8
"""Largest number of residual rows; of more, evenly spread ones are drawn."""
ROOM = 1.12
"""Half height of a panel, relative to the largest residual."""


def plot_fit(fit: Fit, title: str = "") -> Figure:
    """Draw measured and modelled outputs of all records over time."""
    rows = pick_evenly(list_compared(fit), MOST)
    with use_style():
        figure, panels = make_grid(len(rows), title or "Measured and fitted")
        for axes, one in zip(panels, rows, strict=True):
            axis = make_output_axis(one.output, one.description)
            _draw_panel(axes, one, _choose_axis(one), one.times, axis)
        _share_scales(panels, rows)
        _write_key(figure, rows)
        return figure


def plot_fit_loops(fit: Fit, title: str = "") -> Figure:
    """Draw outputs over the measured temperature, or stress over strain.

    Raises:
        InputError: no record has both.
    """
    entries = [(one, find_loop_column(one)) for one in list_compared(fit)]
    rows = pick_evenly([one for one, column in entries if column is not None], MOST)
    if not rows:
        raise InputError(
            "There is no loop to draw: it needs a record with a varying temperature, or with stress and strain."
        )
    with use_style():
        figure, panels = make_grid(len(rows), title or "Measured and fitted, as loops")
        for axes, one in zip(panels, rows, strict=True):
            column = find_loop_column(one) or ""
            record = one.experiment.record
            values = np.asarray(record[column])[one.experiment.rows]
            horizontal = _make_column_axis(column, record.units[column])
            _draw_panel(axes, one, horizontal, values, make_output_axis(one.output, one.description))
        _share_scales(panels, rows)
        _write_key(figure, rows)
        return figure


def has_loops(fit: Fit) -> bool:
    """Return whether `plot_fit_loops` has a loop to draw."""
    return any(find_loop_column(one) is not None for one in list_compared(fit))


def make_output_axis(name: str, described: Output) -> QuantityAxis:
    """Return the axis of an output."""
    display_unit = units.of_column(name, described.unit)
    return QuantityAxis(name, described.long_name, described.symbol, described.unit, display_unit)


def find_loop_column(one: ComparedOutput) -> str | None:
    """Return the column over which an output makes a loop, or None."""
    record, last = one.experiment.record, one.output.rpartition(".")[2]
    partner = {"stress": "strain", "force": "position"}.get(last)
    for column in ("temperature", partner):
        if column in record.columns and column not in (None, one.column):
            values = np.asarray(record[column])
            span = float(np.nanmax(values) - np.nanmin(values))
            if span > (WARM if column == "temperature" else 0.0):
                return column
    return None


def _make_column_axis(column: str, unit: str) -> QuantityAxis:
    symbol = {"temperature": "T", "strain": "ε", "position": "x"}[column]
    return QuantityAxis(column, column, symbol, unit, units.of_column(column, unit))


def _draw_panel(axes: Any, one: ComparedOutput, horizontal: QuantityAxis, x: Any, vertical: QuantityAxis) -> None:
    across, measured = horizontal.values(x), vertical.values(one.measured)
    dots = {"marker": "o", "markersize": 2.6, "markeredgewidth": 0.0, "linestyle": "none"}
    line = {"linewidth": 2.6, "alpha": 0.75}
    axes.plot(across, measured, color=SEEN, zorder=1.8, **(dots if len(x) <= DOTS else line))
    held_out_rows = one.experiment.held_out_rows
    model = vertical.values(one.model)
    for part, colour, above in ((~held_out_rows, SIMULATED, 2.2), (_widen_rows(held_out_rows), HELD, 2.1)):
        if part.any():
            axes.plot(across, np.where(part, model, np.nan), color=colour, zorder=above)
    if held_out_rows.all():
        axes.set_facecolor(TINT)
    elif horizontal in (TIME, CONDITION):
        wide = 0.0 if horizontal is TIME else 0.5
        for first, last in one.experiment.held_out_intervals:
            low, high = max(first, float(one.times[0])) - wide, min(last, float(one.times[-1])) + wide
            if low < high:
                axes.axvspan(low, high, color=TINT, linewidth=0.0, zorder=0.4)
    axes.set(xlabel=horizontal.label, ylabel=vertical.label)
    _write_name(axes, one)


def _choose_axis(one: ComparedOutput) -> QuantityAxis:
    return TIME if one.experiment.over_time else CONDITION


def _widen_rows(rows: Any) -> Any:
    """Return the rows and their neighbours, so that lines of two colours meet."""
    wide = rows.copy()
    wide[1:] |= rows[:-1]
    wide[:-1] |= rows[1:]
    return wide


def _write_name(axes: Any, one: ComparedOutput) -> None:
    axes.set_title(shorten_name(one.record), fontweight="bold", pad=14.0).set_parse_math(False)
    errors = [
        f"{format_error(one.output, one.rms(part), one.description.unit)}{word}"
        for part, word in ((TRAINING, ""), (HELD_OUT, " held out"))
        if (one.training_rows if part == TRAINING else one.held_out_rows).any()
    ]
    words = f"rms {', '.join(errors)}".replace("ohm", "Ω")
    tint = HELD if one.held_out_rows.any() and not one.training_rows.any() else QUIET
    place = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate(words, (0.0, 1.0), (0.0, 3.5), fontsize=8.0, color=tint, **place)


def _share_scales(panels: Sequence[Any], rows: Sequence[ComparedOutput]) -> None:
    """Give panels of the same output the same vertical scale."""
    for name in dict.fromkeys(one.output for one in rows):
        own = [(axes, one) for axes, one in zip(panels, rows, strict=True) if one.output == name]
        axis = make_output_axis(name, own[0][1].description)
        values = [axis.values(column) for _, one in own for column in (one.measured, one.model)]
        for axes, _ in own:
            axes.set_ylim(*enclose_values(*values))


def _write_key(figure: Figure, rows: Sequence[ComparedOutput]) -> None:
    colours = {"measured": SEEN}
    if any(one.training_rows.any() for one in rows):
        colours["model, fitted to it"] = SIMULATED
    if any(one.held_out_rows.any() for one in rows):
        colours["model, not fitted to it: held out"] = HELD
    add_colour_key(figure, colours)


def plot_fit_residuals(fit: Fit, title: str = "") -> Figure:
    """Draw the residuals of each record and output, and their autocorrelation."""
    rows = pick_evenly(list_compared(fit), MOST_RESIDUALS)
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
    table: dict[str, float] = {}
    for one in rows:
        largest = float(np.nanmax(np.abs(one.residuals)))
        table[one.output] = max(table.get(one.output, 0.0), largest)
    return table


def _draw_over_time(axes: Any, one: ComparedOutput, reach: float, last: bool) -> None:
    axis = make_output_axis(one.output, one.description)
    factor = 0.01 if axis.display_unit == "%" else choose_difference_unit(axis.unit)[1]
    axes.axhline(0.0, color=QUIET, linewidth=0.7, zorder=1.2)
    for part, colour in ((one.training_rows, SIMULATED), (one.held_out_rows, HELD)):
        if part.any():
            values = np.where(part, one.residuals, np.nan) / factor
            axes.plot(one.times, values, color=colour, linewidth=0.9, zorder=2.0)
    if one.held_out_rows.any() and not one.training_rows.any():
        axes.set_facecolor(TINT)
    axes.set(ylim=(-ROOM * reach / factor or -1.0, ROOM * reach / factor or 1.0))
    axes.set(ylabel=f"{one.output} [{axis.difference_unit or '–'}]", xlabel=_choose_axis(one).label if last else "")
    suffix = " (held out)" if one.held_out_rows.any() and not one.training_rows.any() else ""
    write_title(axes, shorten_name(one.record) + suffix, fontweight="bold", color=HELD if suffix else INK)


def _draw_memory(axes: Any, test: Whiteness | None, last: bool) -> None:
    if test is None:
        axes.set_axis_off()
        return
    draw_autocorrelation(axes, test)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set(xlabel="lag [samples]" if last else "", ylabel="autocorrelation")
    verdict = "white" if test.white else "not white"
    probability = "p < 0.0001" if test.p_value < 1e-4 else f"p = {test.p_value:.2g}"
    write_title(axes, f"{verdict} ({probability})", color=QUIET, fontsize=8.0)
