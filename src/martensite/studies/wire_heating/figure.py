"""The figure of the study: the heat balance that does not close, and two closures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.style import HEATING, INK, MEASURED, SIMULATED
from martensite.studies.figures import draw_page, label_axes
from martensite.studies.tables import Printed
from martensite.studies.wire_heating import bench, closures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"a": SIMULATED, "b": HEATING}
NAMES = {"a": "closure A: h of (3.2), {ohms:.2f} Ω", "b": "closure B: 1.3 and 1.5 Ω, {h:.0f} W/(m² K)"}


def draw_figure(printed: Printed) -> Figure:
    """Draw the figure."""
    with draw_page(
        11.0,
        5.6,
        "Wire of 0.375 mm heated by a voltage: the balance does not close",
        "Computed for this project; points from the thesis's Table 2. Assumed: an "
        f"ambient of {bench.AMBIENT:g} °C, and the alloy.",
    ) as figure:
        grid = figure.add_gridspec(
            2, 2, left=0.06, right=0.98, top=0.85, bottom=0.09, width_ratios=(1.25, 1.0), wspace=0.17, hspace=0.42
        )
        _draw_steady(figure.add_subplot(grid[:, 0]), printed)
        _draw_film(figure.add_subplot(grid[0, 1]), printed)
        _draw_course(figure.add_subplot(grid[1, 1]))
        return figure


def legend_labels(printed: Printed) -> dict[str, str]:
    """Return the legend entries of the closures."""
    a, b = closures.closure_a(printed), closures.closure_b(printed)
    return {"a": NAMES["a"].format(ohms=a.resistance), "b": NAMES["b"].format(h=b.h)}


def _draw_steady(axes: Any, printed: Printed) -> None:
    volts, at = printed.rows.column("voltage"), np.asarray(printed.rows.column("temperature"))
    readings = (
        ("13 and 15 Ω as printed", [closures.printed_resistance(v, printed) for v in volts], MEASURED[0], "v"),
        ("read as 1.3 and 1.5 Ω", closures.read_per_metre(printed), MEASURED[1], "^"),
    )
    for label, ohms, colour, marker in readings:
        axes.plot(
            volts,
            closures.predict_temperatures(printed, ohms),
            color=colour,
            marker=marker,
            markersize=4.0,
            linewidth=1.0,
            linestyle=(0, (4, 1.5)),
            label=f"h of (3.2), {label}",
        )
    for key, closure in (("a", closures.closure_a(printed)), ("b", closures.closure_b(printed))):
        axes.plot(
            volts,
            at + np.asarray(closure.errors),
            color=COLOURS[key],
            label=f"{legend_labels(printed)[key]}, rms {closure.rms:.1f} K",
        )
    axes.plot(volts, at, "o", color=INK, markersize=5.5, zorder=4, label="Table 2")
    label_axes(axes, "steady temperature", "voltage [V]", "$T$ [°C]", "upper left")


def _draw_film(axes: Any, printed: Printed) -> None:
    at = np.linspace(25.0, 105.0, 81)
    axes.plot(
        at,
        [bench.film_coefficient(float(t), bench.AMBIENT, printed) for t in at],
        color=SIMULATED,
        label="air of a textbook",
    )
    axes.plot(
        printed.rows.column("temperature"),
        [bench.printed_film(row, printed) for row in printed.rows],
        "o",
        color=INK,
        markersize=4.5,
        label="air as printed in Table 2",
    )
    axes.set_ylim(38.0, 48.0)
    label_axes(
        axes,
        "film coefficient by (3.2); closure B needs three times as much",
        "$T$ [°C]",
        "$h$ [W/(m² K)]",
        "lower right",
    )


def _draw_course(axes: Any) -> None:
    end = 0.0
    for key, colour in COLOURS.items():
        run = bench.heating_run(key)
        end = run.times[-1]
        axes.plot(run.times, np.asarray(run["temperature"]) - bench.ZERO, color=colour, label=f"closure {key.upper()}")
    axes.set_xlim(0.0, end)
    label_axes(
        axes, "1.2 V on for 60 s, simulated; no measured course is printed", "time [s]", "$T$ [°C]", "upper right"
    )
