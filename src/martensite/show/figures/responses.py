"""Figures of a plant's speeds and of its response over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.design.analysis.frequency_response import FrequencyResponse
from martensite.design.analysis.speeds import Speeds
from martensite.show.figures.labels import label_difference, label_ratio
from martensite.show.figures.machine import choose_colours
from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, HEATING, QUIET, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 10.0, 3.4
DASHES: tuple[Any, ...] = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
"""Line styles of loads, repeated."""
RESPONSE_WIDTH, RESPONSE_HEIGHT = 10.0, 3.5
LEAST_GAIN = 1e-4
"""Smallest drawn gain, relative to the largest."""


def plot_speeds(speeds: Speeds, title: str = "") -> Figure:
    """Draw the up and down steps of `compute_speeds`, and their speeds."""
    with use_style():
        figure = make_figure(WIDTH, HEIGHT)
        ((course, times, rates),) = add_panels(figure, 1, 3, (0.6, 0.15, 0.71, 0.51))
        write_headline(figure, title or f"Steps of {speeds.drive}: heating against cooling")
        _draw_courses(course, speeds)
        unit, size = label_difference(speeds.units[1])
        _draw_both(times, speeds, speeds.rise, speeds.fall)
        times.set_title("time to 90 % of the way [s]")
        _draw_both(rates, speeds, speeds.fastest_up / size, speeds.fastest_down / size)
        rates.set_title(f"largest rate [{unit}/s]")
        for axes in (times, rates):
            axes.set_xlabel(_label_axis(speeds.drive, speeds.units[0]))
            axes.set_ylim(0.0, 1.06 * axes.get_ylim()[1])
        figure.legend(
            *times.get_legend_handles_labels(),
            loc="upper right",
            bbox_to_anchor=(0.99, 1.0),
            ncols=min(len(speeds.loads), 6),
            columnspacing=1.4,
        )
        return figure


def _draw_courses(axes: Any, speeds: Speeds) -> None:
    """Draw the output over time; colours are signals, dashes loads."""
    unit, size = label_difference(speeds.units[1])
    drive = units.choose_readable_unit(speeds.units[0])
    for rows, dash, load in _list_loads(speeds, speeds.courses):
        for row, signal, tint in zip(rows, speeds.signals, choose_colours(len(speeds.signals)), strict=True):
            word = f"{units.from_si(float(signal), drive, speeds.units[0]):.3g}"
            first = load == 0
            label = word if first else "_nolegend_"
            axes.plot(speeds.times, (row - row[0]) / size, color=tint, linestyle=dash, label=label)
    axes.axvline(speeds.hold, color=QUIET, linewidth=0.7, zorder=1.0)
    axes.set(title=f"{speeds.output.replace('_', ' ')} [{unit}]", xlabel="$t$ [s]", xlim=(0.0, speeds.times[-1]))
    axes.legend(title=_label_axis(speeds.drive, speeds.units[0]), title_fontsize=8.0, loc="upper right")


def _draw_both(axes: Any, speeds: Speeds, up: Any, down: Any) -> None:
    display_unit = units.choose_readable_unit(speeds.units[0])
    signals = [units.from_si(float(one), display_unit, speeds.units[0]) for one in speeds.signals]
    pairs = zip(_list_loads(speeds, up), _list_loads(speeds, down), strict=True)
    for (heat, dash, load), (cool, _, _) in pairs:
        for row, tint, word in ((heat, HEATING, "heating"), (cool, COOLING, "cooling")):
            finite = np.where(np.isfinite(row), row, np.nan)
            label = f"{word}{_name_load(speeds, load)}"
            axes.plot(signals, finite, ".", color=tint, linestyle=dash, label=label)


def _list_loads(speeds: Speeds, table: Any) -> list[tuple[Any, Any, int]]:
    return [(table[k], DASHES[k % len(DASHES)], k) for k in range(len(speeds.loads))]


def _name_load(speeds: Speeds, k: int) -> str:
    if not speeds.load:
        return ""
    return f", {speeds.load.rpartition('.')[2]} {speeds.loads[k]:.3g}"


def _label_axis(name: str, unit: str) -> str:
    display_unit = units.choose_readable_unit(unit)
    return name if display_unit == "1" else f"{name} [{ {'degC': '°C'}.get(display_unit, display_unit) }]"


def plot_frequency_response(response: FrequencyResponse, title: str = "") -> Figure:
    """Draw gain, phase and distortion over frequency.

    A hollow mark is an unsettled cycle; a cross on the gain is the bandwidth. Negligible gains have neither phase nor
    distortion.
    """
    with use_style():
        figure = make_figure(RESPONSE_WIDTH, RESPONSE_HEIGHT)
        (axes,) = add_panels(figure, 1, 3, (0.75, 0.15, 0.8, 0.51))
        write_headline(figure, title or f"From {response.drive} to {response.output.replace('_', ' ')}")
        unit, size = label_ratio(response.units[1], response.units[0])
        significant = np.where(response.gain > LEAST_GAIN * np.max(response.gain), 1.0, np.nan)
        rows = (
            response.gain / size,
            significant * np.degrees(response.phase),
            significant * 100.0 * response.distortion,
        )
        for one, values in zip(axes, rows, strict=True):
            _draw_lines(one, response, values)
        _mark_bandwidths(axes[0], response, size)
        _set_logarithmic(axes[0], rows[0])
        for one, words in zip(axes, (f"gain [{unit}]", "phase [°]", "not in the first harmonic [%]"), strict=True):
            one.set_title(words)
        axes[2].set_ylim(bottom=0.0)
        figure.legend(
            *axes[0].get_legend_handles_labels(),
            loc="upper right",
            ncols=6,
            bbox_to_anchor=(0.99, 0.985),
            title=_describe_units(response),
            title_fontsize=8.0,
        )
        return figure


def _draw_lines(axes: Any, response: FrequencyResponse, values: Any) -> None:
    display_unit = units.choose_readable_unit(response.units[0])
    for k, (bias, tint) in enumerate(zip(response.biases, choose_colours(len(response.biases)), strict=True)):
        label = f"{units.from_si(float(bias), display_unit, response.units[0]):.3g}"
        axes.plot(response.frequencies, values[k], ".-", color=tint, label=label)
        loose = ~response.settled[k]
        look = {"color": tint, "markerfacecolor": "white", "linestyle": "none"}
        axes.plot(response.frequencies[loose], values[k][loose], "o", **look)
    axes.set(xscale="log", xlim=(response.frequencies.min() / 1.1, response.frequencies.max() * 1.1), xlabel="$f$ [Hz]")


def _set_logarithmic(axes: Any, gains: Any) -> None:
    """Use a logarithmic axis over significant gains."""
    most = float(np.max(gains))
    if most > 0.0:
        axes.set(yscale="log", ylim=(max(0.7 * float(np.min(gains)), LEAST_GAIN * most), 1.5 * most))


def _mark_bandwidths(axes: Any, response: FrequencyResponse, size: float) -> None:
    """Mark the half-power points on the gain curves."""
    for width, row in zip(response.bandwidth, response.gain, strict=True):
        if np.isfinite(width):
            axes.plot(width, row[0] / size / np.sqrt(2.0), "x", color=QUIET, zorder=3.0)


def _describe_units(response: FrequencyResponse) -> str:
    display_unit = units.choose_readable_unit(response.units[0])
    unit = {"1": "", "degC": " °C"}.get(display_unit, f" {display_unit}")
    size = units.find_conversion(display_unit, response.units[0])[0]
    return f"bias{f' [{unit.strip()}]' if unit else ''}, ± {response.amplitude / size:.3g}"
