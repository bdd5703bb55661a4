"""Time series: one small panel per quantity, all sharing the time axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from martensite.show.figures.labels import choose_limits, describe_axis, read_column
from martensite.show.figures.panels import add_legend_above
from martensite.show.figures.record_overlays import MeasuredRecord, draw_overlays, find_overlays, list_recorded
from martensite.show.figures.style import SIMULATED
from martensite.simulate.result import Result

PANELS = ("drive", "temperature", "martensite_fraction", "strain", "stress", "mechanism", "resistance")
"""Quantities shown of every result, from top to bottom; all that the mechanism has for itself."""


def list_panels(result: Result, records: Sequence[MeasuredRecord] = ()) -> list[str]:
    """The quantities to show: the usual ones, and others that were measured.

    A drive that prescribes the temperature is the temperature, and is not shown twice.
    """
    (actuator,) = result.system.actuators().values()
    twice = actuator.source.sets_temperature
    own = list(result.system.of_mechanism())
    usual = [
        shown
        for name in PANELS
        if not (twice and name == "drive")
        for shown in (own if name == "mechanism" else [name])
    ]
    return usual + [name for name in list_recorded(result, records) if name not in usual]


def draw_timeseries(
    panels: Sequence[Any], result: Result, names: Sequence[str], records: Sequence[MeasuredRecord] = ()
) -> None:
    """Draw one quantity per axes, measured records over it; only the last names the time."""
    for axes, name in zip(panels, names, strict=True):
        draw_panel(axes, result, name, records)
    panels[-1].set_xlabel(describe_axis(result, "time").label)


def draw_panel(axes: Any, result: Result, name: str, records: Sequence[MeasuredRecord] = ()) -> None:
    """Draw one quantity over time [s]."""
    shown, values = describe_axis(result, name), read_column(result, name)
    found = find_overlays(result, records, name)
    axes.plot(result.times, values, color=SIMULATED, label="_simulated", zorder=2.2)
    draw_overlays(axes, shown, found)
    axes.set_title(shown.long_name)
    axes.set_ylabel(shown.label)
    axes.set_xlim(result.times[0], result.times[-1])
    axes.set_ylim(*choose_limits(name, values, *(overlay.values for overlay in found)))
    axes.locator_params(axis="y", nbins=4)
    add_legend_above(axes)
