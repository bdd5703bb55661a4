"""The figure of the study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.hysteresis import find_senses, find_strips, split_runs
from martensite.show.figures.labels import typeset_symbol
from martensite.show.figures.style import COOLING, HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.studies.figures import add_right_axis, draw_page, label_axes
from martensite.studies.migaone import bench, film_numbers
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEAN, REFIT, LINE = MEASURED[3], MEASURED[2], MEASURED[0]
"""Colours of the mean constant h, of the refit with h₁ = 0, of the straight line."""
OTHERS = (
    ("constant", "mean constant h", MEAN, (0, (5, 1.6))),
    ("paper", "paper: 320 J/(kg K), no latent heat", MEASURED[0], (0, (1, 1.3))),
    ("one-curve", "paper, eq. (6) also for cooling", MEASURED[1], (0, (4, 1.2, 1, 1.2))),
)
"""Other variants: key, label, colour, dashes."""


def draw_figure(printed: Printed) -> Figure:
    """Draw the figure."""
    with draw_page(
        11.5,
        6.6,
        "MigaOne-15 wire under 400 g: stroke at 0.005 Hz, and h(T)",
        "Simulated for this project; points from the paper's Table 2. Assumed: 0 to 2.5 V, 90 °C alloy.",
    ) as figure:
        grid = figure.add_gridspec(
            2,
            2,
            left=0.06,
            right=0.985,
            top=0.875,
            bottom=0.085,
            width_ratios=(1.45, 1.0),
            height_ratios=(1.55, 1.0),
            wspace=0.2,
            hspace=0.3,
        )
        stroke = figure.add_subplot(grid[0, 0])
        _draw_stroke(stroke, printed)
        _draw_heat(figure.add_subplot(grid[1, 0], sharex=stroke), printed)
        _draw_film(figure.add_subplot(grid[0, 1]), printed)
        _draw_steady(figure.add_subplot(grid[1, 1]), printed)
        return figure


def _second_period(key: str, printed: Printed) -> tuple[Any, dict[str, Any]]:
    """Return times from the start of the second period [s], and its columns [SI]."""
    run = bench.sine_run(key, printed)
    half = len(run.times) // 2
    times = np.asarray(run.times[half:]) - run.times[half]
    return times, {name: np.asarray(values[half:]) for name, values in run.columns.items()}


def _draw_stroke(axes: Any, printed: Printed) -> None:
    times, columns = _second_period("polynomial", printed)
    position, named = 1e3 * columns["position"], set[int]()
    for sense, first, last in split_runs(find_senses(columns["temperature"])):
        axes.plot(
            times[first : last + 1],
            position[first : last + 1],
            color=HEATING if sense > 0 else COOLING,
            linewidth=2.2,
            zorder=3,
            label="_nolegend_" if sense in named else "heating" if sense > 0 else "cooling",
        )
        named.add(sense)
    for key, label, colour, dashes in OTHERS:
        times, columns = _second_period(key, printed)
        axes.plot(times, 1e3 * columns["position"], color=colour, linestyle=dashes, linewidth=1.1, label=label)
    axes.set_title("stroke in the second period; thick: printed h(T), 837 J/(kg K), latent heat")
    axes.set_ylabel("stroke [mm]")
    axes.set_ylim(-0.25, 8.6)
    axes.set_xlim(times[0], times[-1])
    axes.legend(loc="center left", bbox_to_anchor=(0.0, 0.62))


def _draw_heat(axes: Any, printed: Printed) -> None:
    times, columns = _second_period("polynomial", printed)
    axes.plot(times, columns["temperature"] - bench.ZERO, color=SIMULATED)
    for mark in find_strips(bench.sine_run("polynomial", printed)):
        names = mark.low_name, mark.high_name
        axes.axhspan(mark.low, mark.high, color=mark.colour, alpha=0.12, linewidth=0.0)
        axes.text(
            2.0,
            0.5 * (mark.low + mark.high),
            " … ".join(map(typeset_symbol, names)),
            color=mark.colour,
            fontsize=8.0,
            va="center",
        )
    label_axes(
        axes, "wire temperature (solid), voltage (dashed), transformation at this stress", "time [s]", "$T$ [°C]"
    )
    axes.set_ylim(30.0, 90.0)
    start = bench.load_scenario().duration / 2.0
    volts = add_right_axis(axes, "$V$ [V]", 0.0, 3.0, QUIET)
    volts.plot(
        times,
        [bench.load_scenario().single_waveform.value(start + t) for t in times],
        color=QUIET,
        linestyle=(0, (3, 1.5)),
        linewidth=1.0,
    )


def _draw_film(axes: Any, printed: Printed) -> None:
    at = np.linspace(40.0, 92.0, 105)
    even, line = film_numbers.no_linear(printed), film_numbers.fit_straight(printed)
    printed_film = [printed.h0 + t * (printed.h1 + t * printed.h2) for t in at]
    r_squared = film_numbers.printed_r_squared(printed)
    mean = bench.mean_constant(printed).h
    axes.plot(
        at,
        printed_film,
        color=SIMULATED,
        linewidth=1.6,
        label=f"printed coefficients, R² {r_squared:.4f} (printed: {printed.r_squared})",
    )
    axes.plot(
        at,
        [even.film(t) for t in at],
        color=REFIT,
        linestyle=(0, (5, 1.6)),
        label=f"least squares with $h_1$ = 0, R² {even.r_squared:.4f}",
    )
    axes.plot(
        at,
        [line.film(t) for t in at],
        color=LINE,
        linestyle=(0, (1, 1.3)),
        label=f"least squares, straight line, R² {line.r_squared:.4f}",
    )
    axes.axhline(mean, color=MEAN, linewidth=1.0, label=f"mean, {mean:.1f} W/(m² K)")
    axes.plot(
        printed.steps.column("temperature"),
        printed.steps.column("film"),
        "o",
        color=INK,
        markersize=5.5,
        zorder=4,
        label="Table 2",
    )
    label_axes(axes, "film coefficient against wire temperature", "$T$ [°C]", "$h$ [W/(m² K)]", "upper left")


def _draw_steady(axes: Any, printed: Printed) -> None:
    volts = [step.voltage for step in printed.steps]
    bars = (
        ("polynomial", "printed h(T)", SIMULATED),
        ("refitted", "least squares with $h_1$ = 0", REFIT),
        ("constant", "mean constant h", MEAN),
    )
    for i, (key, label, colour) in enumerate(bars):
        errors = film_numbers.steady_errors(key, printed)
        places = [v + 0.14 * (i - 1) for v in volts]
        axes.bar(places, errors, width=0.13, color=colour, label=label)
        for place, error in zip(places, errors, strict=True):
            axes.annotate(
                f"{error:+.1f}",
                (place, error),
                xytext=(0, 2 if error > 0 else -2),
                textcoords="offset points",
                ha="center",
                va="bottom" if error > 0 else "top",
                fontsize=7.0,
            )
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    axes.set_xticks(volts)
    axes.set_ylim(-2.6, 9.4)
    axes.grid(False, axis="x")
    label_axes(axes, "steady temperature, simulated less Table 2", "voltage step [V]", "difference [K]", "upper left")
