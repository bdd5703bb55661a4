"""Models of blocks compared with measurements, and tests of their residuals.

Outputs over time with band and error, and as loops; the autocorrelation of each output with the band of white
residuals; the correlation with each input and its square, with the 95 % and 99 % bands for one lag and, dashed, the
limit for all lags on one side together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.formats import typeset_unit
from martensite.identify.chains.correlations import LEVELS, CrossCorrelation
from martensite.identify.chains.record_parts import find_rising
from martensite.identify.chains.validation import Validation
from martensite.search.whiteness import Whiteness
from martensite.show.figures.fit import SEEN
from martensite.show.figures.labels import enclose_values
from martensite.show.figures.panels import (
    add_legend_above,
    add_panels,
    draw_autocorrelation,
    make_panels,
    share_limits,
    write_headline,
    write_title,
)
from martensite.show.figures.style import (
    COOLING,
    FAINT,
    HEATING,
    INK,
    MEASURED,
    QUIET,
    SIMULATED,
    make_figure,
    use_style,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.identify.chains.stages import IdentifiedStages
    from martensite.identify.chains.uncertainty import OutputBand
    from martensite.signals.sampling.sampled import Sampled

BAND = "#bcd3e2"
"""Colour of the band of measurements."""
LOOPED = 20_000
"""Largest number of points of a loop."""
SHADES = ("#c9d0d5", FAINT)
"""Colours of the narrow and the wide band."""
MOST_CORNERS = 4000
"""Largest number of points of a line; longer lines are drawn by their extremes."""
MOST_PANELS = 6
"""Largest number of drawn records."""
MOST_POINTS = 4000
"""Largest number of drawn samples of a record."""


def plot_model(validation: Validation, band: OutputBand | None = None, title: str = "") -> Figure:
    """Draw inputs, then measured and computed outputs with their errors, over time.

    Args:
        validation: a chain on a record.
        band: band of the outputs, for the same record.
        title: headline.
    """
    record = validation.record
    inputs, outputs = len(record.input_names), len(record.output_names)
    heights = [0.6] * inputs + [1.7, 0.8] * outputs
    with use_style():
        figure = make_figure(9.2, 1.0 + 0.92 * sum(heights))
        write_headline(figure, title or f"{validation.chain.name} on {record.name}: free run")
        how = {"sharex": True, "height_ratios": heights}
        room = (0.78, 0.14, 0.52, 0.48)
        panels = list(add_panels(figure, len(heights), 1, room, (0.0, 0.28), **how)[:, 0])
        for k in range(inputs):
            _draw_input(panels[k], validation, k)
        for k in range(outputs):
            _draw_output(panels[inputs + 2 * k], validation, k, band)
            _draw_error(panels[inputs + 2 * k + 1], validation, k, band)
        panels[-1].set(xlabel="$t$ [s]", xlim=(record.times[0], record.times[-1]))
        figure.align_ylabels(panels)
        return figure


def plot_model_loop(validation: Validation, number: int = 0, title: str = "") -> Figure:
    """Draw each output over an input, measured and computed, rising and falling in two colours.

    Args:
        validation: a chain on a record.
        number: index of the input.
        title: headline.
    """
    record = validation.record
    outputs = len(record.output_names)
    with use_style():
        figure = make_figure(9.2, 0.75 + 3.4 * outputs)
        headline = title or f"{validation.chain.name} on {record.name}: output over input"
        write_headline(figure, headline)
        panels = add_panels(figure, outputs, 2, (0.78, 0.14, 0.68, 0.55), (0.54, 0.95))
        for k, (left, right) in enumerate(panels):
            _draw_loop(left, validation, record.outputs[:, k], number, k, "measured")
            _draw_loop(right, validation, validation.outputs[:, k], number, k, "computed")
            share_limits((left, right))
            add_legend_above(right)
        return figure


def _draw_input(axes: Any, validation: Validation, k: int) -> None:
    record = validation.record
    places = thin_line(record.inputs[:, k])
    axes.plot(record.times[places], record.inputs[places, k], color=INK, linewidth=0.9)
    axes.set_ylabel(write_signal_label(record.input_names[k], record.units))
    axes.locator_params(axis="y", nbins=3)


def _draw_output(axes: Any, validation: Validation, k: int, band: OutputBand | None) -> None:
    record, computed = validation.record, validation.outputs[:, k]
    times, name = record.times, record.output_names[k]
    measured = record.outputs[:, k]
    if band is not None:
        low, high = (computed + sign * band.measured[:, k] for sign in (-1.0, 1.0))
        axes.fill_between(times, low, high, color=BAND, linewidth=0.0, label="band", zorder=1.1)
    places = thin_line(measured)
    axes.plot(times[places], measured[places], color=SEEN, linewidth=2.0, label="measured")
    places = thin_line(computed)
    axes.plot(times[places], computed[places], color=SIMULATED, linewidth=1.1, label="computed")
    axes.set(ylabel=write_signal_label(name, record.units), ylim=enclose_values(measured, computed))
    add_legend_above(axes)
    fit = validation.score(name).fit_percent
    words = f"{name}: fit {fit:.2f} % (NRMSE, free run)"
    write_title(axes, words, fontweight="bold", color=INK)


def _draw_error(axes: Any, validation: Validation, k: int, band: OutputBand | None) -> None:
    record, errors = validation.record, validation.residuals[:, k]
    axes.axhline(0.0, color=QUIET, linewidth=0.7, zorder=1.2)
    if band is not None:
        width = band.measured[:, k]
        axes.fill_between(record.times, -width, width, color=FAINT, linewidth=0.0, zorder=0.8)
    places = thin_line(errors)
    axes.plot(record.times[places], errors[places], color=SIMULATED, linewidth=0.8)
    reach = 1.12 * float(np.nanmax(np.abs(errors))) or 1.0
    axes.set_ylim(-reach, reach)
    unit = record.units.get(record.output_names[k], "")
    axes.set_ylabel(write_signal_label("error", {"error": "K" if unit == "degC" else unit}))
    axes.locator_params(axis="y", nbins=3)


def _draw_loop(axes: Any, validation: Validation, y: Any, number: int, k: int, words: str) -> None:
    record = validation.record
    step = max(1, len(record) // LOOPED)
    u, y = record.inputs[::step, number], y[::step]
    up = find_rising(record.inputs[:, number])[::step]
    for mask, name, colour in ((up, "rising", HEATING), (~up, "falling", COOLING)):
        path = np.where(mask | np.roll(mask, 1), y, np.nan)
        axes.plot(u, path, color=colour, linewidth=0.9, alpha=0.8, label=name)
    axes.set_xlabel(write_signal_label(record.input_names[number], record.units))
    axes.set_ylabel(write_signal_label(record.output_names[k], record.units))
    write_title(axes, words, fontweight="bold", color=INK)


def plot_model_tests(validation: Validation, title: str = "") -> Figure:
    """Draw the tests of the residuals of a chain on a record."""
    outputs = validation.record.output_names
    rows = [[one for one in validation.correlations if one.output == name] for name in outputs]
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
    axes.set(xlabel="lag [samples]", ylabel="autocorrelation")
    words = "white" if test.white else "not white"
    write_title(axes, f"{output} with itself: {words}", color=INK, fontsize=8.0)


def _draw_cross_correlation(axes: Any, one: CrossCorrelation) -> None:
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
    axes.set(ylim=(-reach, reach), xlabel="lag [s]")
    words = "nothing left" if one.explained else "something left"
    signal = one.signal.replace("`", "")
    write_title(axes, f"{one.output} with {signal}: {words}", color=INK, fontsize=8.0)


def write_signal_label(name: str, units: Mapping[str, str]) -> str:
    """Return name and unit of a signal, such as position [mm]."""
    unit = units.get(name, "")
    plain = name.replace("_", " ").replace("$", r"\$")  # a column name is not mathematics
    return f"{plain} [{typeset_unit(unit, '–')}]"


def thin_line(values: Any, most: int = MOST_CORNERS) -> Any:
    """Return the indices that a line needs: the extremes of equal intervals, or all."""
    count = len(values)
    if count <= most:
        return np.arange(count)
    size = -(-2 * count // most)
    whole = count // size * size
    rows = np.nan_to_num(np.asarray(values[:whole], dtype=float)).reshape(-1, size)
    first = np.arange(len(rows)) * size
    places = np.concatenate(
        [first, first + np.argmin(rows, axis=1), first + np.argmax(rows, axis=1), np.arange(whole, count)]
    )
    return np.unique(places)


def plot_identified(identification: IdentifiedStages, records: Sequence[Sampled], title: str = "") -> Figure:
    """Draw the last output of a model, or of its stages in series, with the measurement."""
    first_records = list(records)[:MOST_PANELS]
    with use_style():
        headline = title or f"{identification.model.text()}, free run"
        figure, grid = make_panels(7.5, 1.0 + 2.0 * len(first_records), len(first_records), 1, headline)
        panels = grid[:, 0]
        for panel, record in zip(panels, first_records, strict=True):
            _draw_free_run(panel, identification, record)
        panels[-1].set_xlabel("time [s]")
        add_legend_above(panels[0])
        return figure


def _draw_free_run(panel: Any, identification: IdentifiedStages, record: Sampled) -> None:
    from martensite.identify.chains.goals import AUTO
    from martensite.identify.chains.scores import fit_percent, free_run
    from martensite.signals.sampling.resampling import select_signals

    names = identification.stages[-1].outputs
    own = select_signals(record, identification.model.input_names, names)
    skip = identification.options.skip
    start = AUTO if identification.options.start == "estimate" else identification.options.start
    computed = free_run(identification.model, own, start, skip)
    fit = float(fit_percent(own.outputs, computed, skip)[-1])
    rows = slice(None, None, max(len(own) // MOST_POINTS, 1))
    times, unit = own.times[rows], own.units.get(names[-1], "1")
    panel.plot(times, own.outputs[rows, -1], color=MEASURED[0], label="measured")
    panel.plot(times, computed[rows, -1], color=SIMULATED, linewidth=1.0, label="free run")
    write_title(panel, f"{record.name}: fit {fit:.1f} %")
    panel.set_ylabel(f"{names[-1]} [{typeset_unit(unit, '–')}]".replace("$", r"\$"))
