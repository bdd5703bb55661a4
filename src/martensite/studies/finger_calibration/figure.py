"""The figure of the study: two searches, and the information in the records."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.kernels.compiler import find_compiler
from martensite.show.figures.labels import typeset_symbol
from martensite.show.figures.style import HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.studies.figures import draw_page, label_axes
from martensite.studies.finger_calibration import bench
from martensite.studies.finger_calibration.bench import EVERY, FAR, NEAR, Data
from martensite.studies.finger_calibration.gauge_numbers import WRONG_ARMS, refit_finger
from martensite.studies.finger_calibration.record_numbers import parameter_errors
from martensite.studies.finger_calibration.searches import (
    COORDINATE,
    SQUARES,
    STILL,
    CalibrationSearch,
    best_fit,
    list_starts,
    moving_starts,
    prepare_searches,
    run_search,
)
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DASHED = (0, (4, 1.6))
WALK, SOLVE = HEATING, SIMULATED
NINETY_FIVE = 2.4477
"""Half axis of the 95 % ellipse of a plane normal distribution [deviations]."""
PATH = {"marker": "o", "markersize": 2.2, "linewidth": 0.9}


def draw_figure(printed: Printed, *, full: bool = False) -> Figure:
    """Draw the figure; without a C compiler, a message."""
    title = "Calibration of the finger: two searches, and the information of the test"
    compiled = find_compiler() is not None
    line = (
        "records simulated with Table 1, 201 samples of a sine at 0.015 Hz with white "
        "noise of 1°; five free parameters within the paper's ranges"
    )
    without = "needs a C compiler: a search takes thousands of runs"
    with draw_page(12.0, 7.2, title, line if compiled else without) as figure:
        if not compiled:
            return figure
        prepare_searches(printed, full=full)
        left, right = figure.add_gridspec(
            1, 2, left=0.05, right=0.985, top=0.885, bottom=0.075, width_ratios=(2.1, 1.0), wspace=0.2
        )
        cells = left.subgridspec(2, 2, hspace=0.33, wspace=0.22)
        last = right.subgridspec(2, 1, hspace=0.33)
        for column, data in enumerate((NEAR, FAR)):
            _draw_ridge(figure.add_subplot(cells[0, column]), data, printed, list_starts(full))
            _draw_costs(figure.add_subplot(cells[1, column]), data, printed, list_starts(full))
        _draw_loops(figure.add_subplot(last[0]), printed)
        halves = last[1].subgridspec(2, 1, hspace=0.75)
        for row, name in enumerate(("dsigma_dT", "E_M")):
            _draw_intervals(figure.add_subplot(halves[row]), name, printed)
        return figure


def _draw_walks(data: Data, printed: Printed, starts: tuple[int, ...]) -> list[tuple[CalibrationSearch, str, str]]:
    walked = [(run_search(data, k, COORDINATE, printed), WALK, "coordinate search") for k in starts]
    solved = [(run_search(data, k, SQUARES, printed), SOLVE, "least squares") for k in moving_starts()]
    return [*walked, *solved]


def _draw_ridge(axes: Any, data: Data, printed: Printed, starts: tuple[int, ...]) -> None:
    ranges = {one.name: one for one in printed.searched}
    width, slope = ranges["Delta_sigma"], ranges["dsigma_dT"]
    edge = np.array([slope.low, slope.high])
    kelvin = width.value / slope.value
    label = f"{typeset_symbol('Δσ')} = {kelvin:.0f} K · {typeset_symbol('dσ/dT')}"
    dashes = {"color": QUIET, "linestyle": DASHED, "linewidth": 0.9}
    axes.plot(kelvin * edge / 1e6, edge / 1e6, **dashes, label=label)
    for one, colour, name in _draw_walks(data, printed, starts):
        places = [(p.numbers["Delta_sigma"] / 1e6, p.numbers["dsigma_dT"] / 1e6) for p in one.path]
        x, y = zip(*places, strict=True)
        axes.plot(x, y, color=colour, **PATH, label=_label_once(axes, name))
        axes.plot(x[0], y[0], marker="s", markersize=5.0, color=colour, markerfacecolor="white")
        axes.plot(x[-1], y[-1], marker="D", markersize=5.5, color=colour, zorder=4)
    axes.plot(*_draw_ellipse(data, printed), color=INK, linewidth=1.0, label="95 % of fits")
    label_axes(
        axes,
        f"ways of the searches, {data.name}",
        f"{typeset_symbol('Δσ')} [MPa]",
        f"{typeset_symbol('dσ/dT')} [MPa/K]",
    )
    axes.set_xlim(36.0, 154.0)
    axes.set_ylim(3.9, 7.1)
    if data is NEAR:
        axes.legend(loc="lower right", fontsize=7.0)


def _label_once(axes: Any, name: str) -> str | None:
    return None if name in axes.get_legend_handles_labels()[1] else name


def _draw_ellipse(data: Data, printed: Printed) -> tuple[Any, Any]:
    """Return the 95 % ellipse of Δσ and dσ/dT about Table 1 [MPa, MPa/K]."""
    table = dict(zip(printed.searched.column("name"), printed.searched.column("value"), strict=True))
    bounds, pair = parameter_errors(data, printed), ("Delta_sigma", "dsigma_dT")
    angle = np.linspace(0.0, 2.0 * math.pi, 200)
    both = bounds.correlation[pair]
    first = np.cos(angle)
    second = both * first + math.sqrt(1.0 - both**2) * np.sin(angle)
    rows = [
        (table[name] + NINETY_FIVE * bounds.numbers[name] * turn) / 1e6
        for name, turn in zip(pair, (first, second), strict=True)
    ]
    return rows[0], rows[1]


def _draw_costs(axes: Any, data: Data, printed: Printed, starts: tuple[int, ...]) -> None:
    for one, colour, name in _draw_walks(data, printed, starts):
        runs = [*(point.runs for point in one.path), one.runs]
        errors_ = [*(point.rms for point in one.path), one.rms]
        axes.step(runs, errors_, where="post", color=colour, label=_label_once(axes, name))
        axes.plot(runs[-1], errors_[-1], marker="D", markersize=5.0, color=colour)
    axes.axhline(math.degrees(bench.NOISE), color=QUIET, linewidth=0.8, linestyle=DASHED)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks([1.0, 10.0, 100.0, 1000.0], ["1", "10", "100", "1000"])
    axes.set_yticks([1.0, 3.0, 10.0, 30.0, 100.0], ["1", "3", "10", "30", "100"])
    axes.set_ylim(0.8, 130.0)
    label_axes(
        axes,
        f"error over runs, {data.name}; dashed: the noise",
        "runs, those with derivatives included",
        "rms of the angle [°]",
        "upper right",
    )


def _draw_loops(axes: Any, printed: Printed) -> None:
    looks = ((NEAR, MEASURED[0], STILL), (FAR, MEASURED[1], STILL))
    for data, colour, start in looks:
        record = bench.table_problem(data, printed).experiments[0]
        power = [bench.load_scenario().single_waveform.value(float(time)) for time in record.times]
        axes.plot(power, np.degrees(record.measured[:, 0]), ".", color=colour, markersize=3.0)
        for one, look in (
            (best_fit(data, printed), {"color": SOLVE}),
            (run_search(data, start, COORDINATE, printed), {"color": WALK, "linestyle": DASHED}),
        ):
            axes.plot(power, np.degrees(one.fit.evaluation.fitted_records[0].model[:, 0]), **look)
    axes.text(0.62, 62.0, NEAR.name, color=MEASURED[0], ha="right", fontsize=8.0)
    axes.text(1.98, 71.0, FAR.name, color=MEASURED[1], ha="right", fontsize=8.0)
    axes.plot([], [], color=SOLVE, label="least squares")
    axes.plot([], [], color=WALK, linestyle=DASHED, label=f"coordinate, start {STILL + 1}")
    label_axes(axes, "records and fits", f"{typeset_symbol('P')} [W]", f"{typeset_symbol('θ')} [°]")
    axes.legend(loc="upper left", fontsize=7.0)


def _draw_intervals(axes: Any, name: str, printed: Printed) -> None:
    one: Printed = next(one for one in printed.searched if one.name == name)
    unit, display_unit, symbol = {"dsigma_dT": (1e6, "MPa/K", "dσ/dT"), "E_M": (1e9, "GPa", "E_M")}[name]
    names = [data.name.removeprefix("a = ") for data in EVERY]
    for row, data in enumerate(EVERY):
        fit = best_fit(data, printed).fit
        low, high = fit.uncertainty.interval(name)
        axes.plot([low / unit, high / unit], [row, row], color=SOLVE, linewidth=2.2)
        axes.plot(fit[name] / unit, row, marker="o", markersize=4.5, color=SOLVE)
    if name == "dsigma_dT":
        far = refit_finger(printed, WRONG_ARMS[0])
        axes.plot(far.fit[name] / unit, len(EVERY), marker="X", color=WALK)
        names.append("8 mm taken for 9")
    axes.axvline(one.value / unit, color=INK, linewidth=0.8, linestyle=DASHED)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xlim(*((3.4, 5.6) if name == "dsigma_dT" else (one.low / unit, one.high / unit)))
    axes.set_title(f"95 % interval of {typeset_symbol(symbol)} [{display_unit}]; dashed: Table 1")
