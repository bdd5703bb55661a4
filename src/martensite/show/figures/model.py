"""A model of blocks beside what was measured: over time with its band and error, and as a loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.identify.chains.record_parts import find_rising
from martensite.identify.chains.validation import Validation
from martensite.show.figures.fit import SEEN
from martensite.show.figures.labels import enclose_values
from martensite.show.figures.panels import add_legend_above, add_panels, share_limits, write_headline, write_title
from martensite.show.figures.signal_labels import thin_line, write_signal_label
from martensite.show.figures.style import COOLING, FAINT, HEATING, INK, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.identify.chains.uncertainty import OutputBand

BAND = "#bcd3e2"
"""The band in which measurements should lie."""
LOOPED = 20_000
"""Points of a loop at most."""


def plot_model(validation: Validation, band: OutputBand | None = None, title: str = "") -> Figure:
    """Draw inputs, then measured and computed outputs with their errors, over time.

    Args:
        validation: a chain on a record.
        band: around the outputs, of the same record.
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
        panels[-1].set_xlabel("$t$ [s]")
        panels[-1].set_xlim(record.times[0], record.times[-1])
        figure.align_ylabels(panels)
        return figure


def plot_model_loop(validation: Validation, number: int = 0, title: str = "") -> Figure:
    """Draw every output over an input, measured and computed, rising and falling in two colours.

    Args:
        validation: a chain on a record.
        number: which input.
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
            _draw_loop(right, validation, validation.computed[:, k], number, k, "computed")
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
    record, computed = validation.record, validation.computed[:, k]
    times, name = record.times, record.output_names[k]
    measured = record.outputs[:, k]
    if band is not None:
        low, high = (computed + sign * band.measured[:, k] for sign in (-1.0, 1.0))
        axes.fill_between(times, low, high, color=BAND, linewidth=0.0, label="band", zorder=1.1)
    places = thin_line(measured)
    axes.plot(times[places], measured[places], color=SEEN, linewidth=2.0, label="measured")
    places = thin_line(computed)
    axes.plot(times[places], computed[places], color=SIMULATED, linewidth=1.1, label="computed")
    axes.set_ylabel(write_signal_label(name, record.units))
    axes.set_ylim(*enclose_values(measured, computed))
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
    """One path in two colours, thin enough to see through."""
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
