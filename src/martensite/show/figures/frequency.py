"""The figure of a frequency response: gain, phase and distortion, a line per bias."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.design.analysis.frequency import FrequencyResponse
from martensite.show.figures.labels import label_ratio
from martensite.show.figures.machine import choose_colours
from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import QUIET, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 10.0, 3.5
LEAST = 1e-4
"""Least gain that is shown, as a share of the largest."""


def plot_frequency_response(found: FrequencyResponse, title: str = "") -> Figure:
    """Draw gain, phase and distortion over frequency.

    A hollow mark is a cycle that had not settled; a cross on the gain is the bandwidth. Where
    next to nothing moves there is neither phase nor distortion.

    Args:
        found: of `measure_frequency_response`.
        title: headline; by default what was asked.
    """
    with use_style():
        figure = make_figure(WIDTH, HEIGHT)
        (axes,) = add_panels(figure, 1, 3, (0.75, 0.15, 0.8, 0.51))
        write_headline(figure, title or f"From {found.drive} to {found.output.replace('_', ' ')}")
        unit, size = label_ratio(found.units[1], found.units[0])
        seen = np.where(found.gain > LEAST * np.max(found.gain), 1.0, np.nan)
        rows = (found.gain / size, seen * np.degrees(found.phase), seen * 100.0 * found.distortion)
        for one, values in zip(axes, rows, strict=True):
            _draw_lines(one, found, values)
        _mark_bandwidths(axes[0], found, size)
        _set_logarithmic(axes[0], rows[0])
        for one, words in zip(axes, (f"gain [{unit}]", "phase [°]", "not in the first harmonic [%]"), strict=True):
            one.set_title(words)
        axes[2].set_ylim(bottom=0.0)
        figure.legend(
            *axes[0].get_legend_handles_labels(),
            loc="upper right",
            ncols=6,
            bbox_to_anchor=(0.99, 0.985),
            title=_describe_units(found),
            title_fontsize=8.0,
        )
        return figure


def _draw_lines(axes: Any, found: FrequencyResponse, values: Any) -> None:
    """A line per bias."""
    shown = units.choose_readable_unit(found.units[0])
    for k, (bias, tint) in enumerate(zip(found.biases, choose_colours(len(found.biases)), strict=True)):
        label = f"{units.from_si(float(bias), shown, found.units[0]):.3g}"
        axes.plot(found.frequencies, values[k], ".-", color=tint, label=label)
        loose = ~found.settled[k]
        look = {"color": tint, "markerfacecolor": "white", "linestyle": "none"}
        axes.plot(found.frequencies[loose], values[k][loose], "o", **look)
    axes.set_xscale("log")
    axes.set_xlim(found.frequencies.min() / 1.1, found.frequencies.max() * 1.1)
    axes.set_xlabel("$f$ [Hz]")


def _set_logarithmic(axes: Any, gains: Any) -> None:
    """A logarithmic axis over what is not next to nothing."""
    most = float(np.max(gains))
    if most > 0.0:
        axes.set_yscale("log")
        axes.set_ylim(max(0.7 * float(np.min(gains)), LEAST * most), 1.5 * most)


def _mark_bandwidths(axes: Any, found: FrequencyResponse, size: float) -> None:
    """Where the gain is that of half the power."""
    for width, row in zip(found.bandwidth, found.gain, strict=True):
        if np.isfinite(width):
            axes.plot(width, row[0] / size / np.sqrt(2.0), "x", color=QUIET, zorder=3.0)


def _describe_units(found: FrequencyResponse) -> str:
    """What the lines are."""
    shown = units.choose_readable_unit(found.units[0])
    unit = {"1": "", "degC": " °C"}.get(shown, f" {shown}")
    size = units.find_conversion(shown, found.units[0])[0]
    return f"bias{f' [{unit.strip()}]' if unit else ''}, ± {found.amplitude / size:.3g}"
