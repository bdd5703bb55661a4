"""The figure of a bench: reference and response, error, signals, temperatures, over time.

One panel holds true, measured and estimated values; another holds the signal of a controller and the signal at the
source, which a supervisor or a fault can change. Times of an alarm are shaded in all panels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.control.observers.base import ESTIMATED
from martensite.show.figures.bench_loops import (
    Loop,
    compute_shown_error,
    find_alarmed_spans,
    find_bench,
    find_loops,
    list_estimates,
    list_temperatures,
    map_applied_signals,
)
from martensite.show.figures.labels import choose_limits, describe_axis, enclose_values, read_column
from martensite.show.figures.machine import choose_colours
from martensite.show.figures.panels import WARNING_LINE, add_legend_above, add_panels, wrap_warnings, write_headline
from martensite.show.figures.record_overlays import (
    MeasuredRecord,
    Outside,
    Records,
    check_records,
    draw_overlays,
    find_overlays,
)
from martensite.show.figures.style import HEATING, INK, MEASURED, QUIET, make_figure, use_style
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, PANEL_HEIGHT = 9.0, 1.35
HEAD, FOOT = 0.62, 0.55
"""Space for the title and the time axis [inch]."""
FOLLOWED: dict[str, Any] = {"color": INK, "linewidth": 1.0, "linestyle": (0, (4, 2))}
READ: dict[str, Any] = {"color": MEASURED[1], "linewidth": 0.8, "alpha": 0.85}
HELD: dict[str, Any] = {"drawstyle": "steps-post"}
WANTED: dict[str, Any] = {"linewidth": 3.0, "alpha": 0.3}
APPLIED: dict[str, Any] = {"linewidth": 1.1}
SURE = 2.0
"""Standard deviations of the band about an estimate."""


@dataclass(frozen=True)
class BenchPanel:
    """Title and drawing function of one panel."""

    title: str
    draw: Callable[[Any], None]


def plot_bench(result: Result, records: Records = None, title: str | None = None, outside: Outside = None) -> Figure:
    """Return the figure of a run on a bench.

    Args:
        result: run to draw.
        records: measured records, drawn over the truth of the same quantity.
        title: first line of the figure; by default the description of the system.
        outside: controllers outside of the bench, by drive.

    Raises:
        InputError: the result is not from a bench.
        DataError: a record has no quantity in common with the result.
    """
    find_bench(result)
    measured = check_records(result, records)
    with use_style():
        loops = find_loops(result, outside)
        panels = [_show_response(result, loop, measured) for loop in loops] or _show_outputs(result, measured)
        panels += [_show_errors(result, group) for group in _group_by_unit(result, loops)]
        panels += _show_signals(result, loops)
        panels += _show_temperatures(result, loops, measured)
        panels += [_show_estimate(result, name) for name in list_estimates(result, loops)]
        return _make_figure(result, panels, title)


def _make_figure(result: Result, panels: Sequence[BenchPanel], title: str | None) -> Figure:
    warnings = wrap_warnings(result.warnings, WIDTH)
    foot = FOOT + WARNING_LINE * len(warnings)
    figure = make_figure(WIDTH, HEAD + foot + PANEL_HEIGHT * len(panels))
    room = (0.81, 0.18, HEAD, foot)
    stack = list(add_panels(figure, len(panels), 1, room, (0.0, 0.4), sharex=True)[:, 0])
    for axes, panel in zip(stack, panels, strict=True):
        panel.draw(axes)
        _finish_panel(axes, result, panel.title)
    stack[-1].set_xlabel(describe_axis(result, "time").label)
    figure.align_ylabels(stack)
    described = result.system.description()
    top = described[:1].upper() + described[1:] if title is None else title
    write_headline(figure, top, warnings=warnings)
    return figure


def _finish_panel(axes: Any, result: Result, title: str) -> None:
    axes.set(title=title, xlim=(result.times[0], result.times[-1]))
    axes.locator_params(axis="y", nbins=4)
    for k, (begin, end) in enumerate(find_alarmed_spans(result)):
        label = "alarm" if k == 0 else "_nolegend_"
        axes.axvspan(begin, end, color=HEATING, alpha=0.12, linewidth=0.0, label=label)
    add_legend_above(axes)


def _show_response(result: Result, loop: Loop, records: Sequence[MeasuredRecord]) -> BenchPanel:
    how = describe_axis(result, loop.truth)

    def draw_panel(axes: Any) -> None:
        reference, reading = how.values(loop.reference), read_column(result, loop.reading)
        truth, overlays = read_column(result, loop.truth), find_overlays(result, records, loop.truth)
        if loop.reading != loop.truth:
            word = "estimated" if loop.reading.startswith(ESTIMATED) else "measured"
            axes.plot(result.times, reading, label=word, **READ)
        axes.plot(result.times, truth, color=choose_colours(1)[0], label="response", zorder=2.2)
        axes.plot(result.times, reference, label="reference", zorder=2.3, **FOLLOWED)
        draw_overlays(axes, how, overlays)
        axes.set(ylabel=how.label, ylim=enclose_values(reference, truth, reading, *(one.values for one in overlays)))

    return BenchPanel(how.long_name, draw_panel)


def _show_outputs(result: Result, records: Sequence[MeasuredRecord]) -> list[BenchPanel]:
    bench = find_bench(result)
    return [
        _show_response(result, Loop("", np.full(len(result.times), np.nan), reading, truth, ""), records)
        for name, mounted in bench.sensors.members().items()
        for reading, truth in [(f"measured.{name}", mounted.sees()[0])]
        if truth in result.outputs and result.unit(truth) == result.unit(reading)
    ]


def _group_by_unit(result: Result, loops: Sequence[Loop]) -> list[list[Loop]]:
    groups: dict[str, list[Loop]] = {}
    for loop in loops:
        groups.setdefault(result.unit(loop.truth), []).append(loop)
    return list(groups.values())


def _show_errors(result: Result, group: Sequence[Loop]) -> BenchPanel:
    def draw_panel(axes: Any) -> None:
        errors = [compute_shown_error(result, loop) for loop in group]
        how = describe_axis(result, group[0].truth)
        for loop, error, tint in zip(group, errors, choose_colours(len(group)), strict=True):
            size = f"rms {np.sqrt(np.mean(error**2)):.3g} {how.difference_unit}".rstrip()
            label = size if len(group) == 1 else f"{loop.drive}: {size}"
            axes.plot(result.times, error, color=tint, label=label)
        axes.axhline(0.0, color=QUIET, linewidth=0.6, zorder=1.5)
        axes.set(ylabel=f"$e$ [{how.difference_unit or '–'}]", ylim=enclose_values(*errors))

    return BenchPanel("reference less response", draw_panel)


def _show_signals(result: Result, loops: Sequence[Loop]) -> list[BenchPanel]:
    got, wants = (
        map_applied_signals(result),
        {loop.drive: loop.requested_signal for loop in loops if loop.requested_signal},
    )
    drives = [drive.name for drive in find_bench(result).plant.drives()]
    groups: dict[str, list[str]] = {}
    for drive in drives:
        name = wants.get(drive) or got.get(drive)
        if name is not None:
            groups.setdefault(result.unit(name), []).append(drive)
    return [_show_signal(result, group, wants, got) for group in groups.values()]


def _show_signal(result: Result, group: Sequence[str], wants: Mapping[str, str], got: Mapping[str, str]) -> BenchPanel:
    names = [name for drive in group for name in (wants.get(drive), got.get(drive)) if name]

    def draw_panel(axes: Any) -> None:
        for drive, tint in zip(group, choose_colours(len(group)), strict=True):
            prefix = "" if len(group) == 1 else f"{drive} "
            for word, columns, look in (("wanted", wants, WANTED), ("applied", got, APPLIED)):
                if drive in columns:
                    style = {"color": tint, "label": prefix + word, **HELD, **look}
                    axes.plot(result.times, read_column(result, columns[drive]), **style)
        axes.set_ylabel(describe_axis(result, names[-1]).label)
        axes.set_ylim(*enclose_values(*(read_column(result, name) for name in names)))

    return BenchPanel("signal", draw_panel)


def _show_temperatures(result: Result, loops: Sequence[Loop], records: Sequence[MeasuredRecord]) -> list[BenchPanel]:
    """Return the panel of all element temperatures, unless another panel shows the only one."""
    names = list_temperatures(result)
    other_names = {loop.truth for loop in loops} | {
        one.removeprefix(ESTIMATED) for one in list_estimates(result, loops)
    }
    if not names or (len(names) == 1 and names[0] in other_names):
        return []

    def draw_panel(axes: Any) -> None:
        for name, tint in zip(names, choose_colours(len(names)), strict=True):
            label = name.rpartition(".")[0] or "_nolegend_"
            axes.plot(result.times, read_column(result, name), color=tint, label=label)
            draw_overlays(axes, describe_axis(result, name), find_overlays(result, records, name))
        axes.set_ylabel(describe_axis(result, names[0]).label)
        axes.set_ylim(*enclose_values(*(read_column(result, name) for name in names)))

    return [BenchPanel(describe_axis(result, names[0]).long_name.partition(", ")[0], draw_panel)]


def _show_estimate(result: Result, name: str) -> BenchPanel:
    truth = name.removeprefix(ESTIMATED)

    def draw_panel(axes: Any) -> None:
        true, estimate = read_column(result, truth), read_column(result, name)
        if f"{name}_std" in result.columns:
            how = describe_axis(result, name)
            factor, _ = units.find_conversion(how.display_unit, how.unit)
            wide = SURE * np.asarray(result[f"{name}_std"]) / factor
            axes.fill_between(
                result.times, estimate - wide, estimate + wide, color=READ["color"], alpha=0.2, linewidth=0.0
            )
        axes.plot(result.times, true, color=choose_colours(1)[0], label="true")
        axes.plot(result.times, estimate, label="estimated", **READ)
        axes.set(ylabel=describe_axis(result, truth).label, ylim=choose_limits(truth, true, estimate))

    return BenchPanel(describe_axis(result, truth).long_name, draw_panel)
