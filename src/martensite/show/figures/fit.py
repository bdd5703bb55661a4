"""A fit beside what was measured: every record over time, and as a loop.

What was kept back from the fit is tinted, and the model is drawn there in another colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanisms.base import Output
from martensite.base import units
from martensite.base.errors import InputError
from martensite.fit.fit import HELD_OUT, TRAINING, ComparedOutput, list_compared
from martensite.fit.fit_verdicts import format_error
from martensite.show.figures.labels import QuantityAxis, enclose_values
from martensite.show.figures.panels import add_colour_key, make_grid, pick_evenly, shorten_name
from martensite.show.figures.style import QUIET, SIMULATED, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.fit.fit import Fit

HELD = "#a03c6e"
"""The model where it was not fitted."""
TINT = "#f7eef3"
"""Behind what was kept back."""
SEEN = "#9aa2a9"
"""What was measured."""
DOTS = 150
"""Rows up to which measurements are dots."""
MOST = 12
"""Panels at most; of more, those spread evenly over the records."""
WARM = 1.0
"""Least range of a measured temperature [K] over which a loop is drawn."""
TIME = QuantityAxis("time", "time", "t", "s", "s")


def plot_fit(fit: Fit, title: str = "") -> Figure:
    """Draw measured and modelled outputs of all records over time.

    Args:
        fit: a finished fit.
        title: headline.
    """
    rows = pick_evenly(list_compared(fit), MOST)
    with use_style():
        figure, panels = make_grid(len(rows), title or "Measured and fitted")
        for axes, one in zip(panels, rows, strict=True):
            shown = make_output_axis(one.output, one.description)
            _draw_panel(axes, one, TIME, one.times, shown)
        _share_scales(panels, rows)
        _write_key(figure, rows)
        return figure


def plot_fit_loops(fit: Fit, title: str = "") -> Figure:
    """Draw outputs over the measured temperature, or stress over strain, where both exist.

    Args:
        fit: a finished fit.
        title: headline.

    Raises:
        InputError: no record holds both.
    """
    found = [(one, find_loop_column(one)) for one in list_compared(fit)]
    rows = pick_evenly([one for one, column in found if column is not None], MOST)
    if not rows:
        raise InputError(
            "No record holds a temperature that varies, or both stress and strain: there is no loop to draw."
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
    """Whether `plot_fit_loops` has something to draw."""
    return any(find_loop_column(one) is not None for one in list_compared(fit))


def make_output_axis(name: str, described: Output) -> QuantityAxis:
    """How an output is shown."""
    shown = units.of_column(name, described.unit)
    return QuantityAxis(name, described.long_name, described.symbol, described.unit, shown)


def find_loop_column(one: ComparedOutput) -> str | None:
    """Column of a record over which an output makes a loop; None if there is none."""
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


def _draw_panel(axes: Any, one: ComparedOutput, horizontal: QuantityAxis, x: Any, shown: QuantityAxis) -> None:
    """Measured and modelled values over a quantity."""
    across, measured = horizontal.values(x), shown.values(one.measured)
    dots = {"marker": "o", "markersize": 2.6, "markeredgewidth": 0.0, "linestyle": "none"}
    line = {"linewidth": 2.6, "alpha": 0.75}
    axes.plot(across, measured, color=SEEN, zorder=1.8, **(dots if len(x) <= DOTS else line))
    held = one.experiment.kept_back
    model = shown.values(one.model)
    for part, colour, above in ((~held, SIMULATED, 2.2), (_widen_rows(held), HELD, 2.1)):
        if part.any():
            axes.plot(across, np.where(part, model, np.nan), color=colour, zorder=above)
    if held.all():
        axes.set_facecolor(TINT)
    elif horizontal is TIME:
        for first, last in one.experiment.held:
            low, high = max(first, float(one.times[0])), min(last, float(one.times[-1]))
            if low < high:
                axes.axvspan(low, high, color=TINT, linewidth=0.0, zorder=0.4)
    axes.set_xlabel(horizontal.label)
    axes.set_ylabel(shown.label)
    _write_name(axes, one)


def _widen_rows(rows: Any) -> Any:
    """Rows, and those beside them, so that lines of two colours meet."""
    wide = rows.copy()
    wide[1:] |= rows[:-1]
    wide[:-1] |= rows[1:]
    return wide


def _write_name(axes: Any, one: ComparedOutput) -> None:
    """The record above a panel, and below its name the errors."""
    axes.set_title(shorten_name(one.record), fontweight="bold", pad=14.0).set_parse_math(False)
    errors = [
        f"{format_error(one.output, one.rms(part), one.description.unit)}{word}"
        for part, word in ((TRAINING, ""), (HELD_OUT, " held out"))
        if _has_rows(one, part)
    ]
    words = f"rms {', '.join(errors)}".replace("ohm", "Ω")
    tint = HELD if one.held.any() and not one.used.any() else QUIET
    place = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate(words, (0.0, 1.0), (0.0, 3.5), fontsize=8.0, color=tint, **place)


def _has_rows(one: ComparedOutput, part: str) -> bool:
    return bool((one.used if part == TRAINING else one.held).any())


def _share_scales(panels: Sequence[Any], rows: Sequence[ComparedOutput]) -> None:
    """The same vertical scale for the same output, so that panels compare at a glance."""
    for name in dict.fromkeys(one.output for one in rows):
        own = [(axes, one) for axes, one in zip(panels, rows, strict=True) if one.output == name]
        shown = make_output_axis(name, own[0][1].description)
        values = [shown.values(column) for _, one in own for column in (one.measured, one.model)]
        for axes, _ in own:
            axes.set_ylim(*enclose_values(*values))


def _write_key(figure: Figure, rows: Sequence[ComparedOutput]) -> None:
    """What the lines are, below the headline."""
    colours = {"measured": SEEN}
    if any(one.used.any() for one in rows):
        colours["model, fitted to it"] = SIMULATED
    if any(one.held.any() for one in rows):
        colours["model, not fitted to it: held out"] = HELD
    add_colour_key(figure, colours)
