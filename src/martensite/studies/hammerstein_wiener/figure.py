"""The figure of the study: models on pulses, on slow ramps, and in closed loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.kernels.compiler import find_compiler
from martensite.show.figures.style import HEATING, INK, QUIET, SIMULATED
from martensite.studies.figures import draw_page
from martensite.studies.hammerstein_wiener import comparisons, loops, models
from martensite.studies.hammerstein_wiener.bench import INTERVAL
from martensite.studies.hammerstein_wiener.fit_numbers import BETTER, PAPER, WHOLE
from martensite.studies.readings import ZERO
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EVERY = 25
"""Step between drawn samples."""
PART = slice(0, 42_000)
"""Drawn part of the validation record."""
COLOURS = {PAPER: HEATING, BETTER: SIMULATED, WHOLE: SIMULATED, "stage 1": HEATING}


def draw_figure(printed: Printed) -> Figure:
    """Draw the figure; without a C compiler, a message."""
    title = "A wire identified in two stages, and what that is worth"
    compiled = find_compiler() is not None
    line = (
        "simulated bench of the paper's kind: 0.51 mm × 230 mm, 1 kg, PWM at 500 Hz; models "
        "fitted to one record of pulses, run free on records they have not seen"
    )
    without = "needs a C compiler: a search takes hundreds of runs"
    with draw_page(13.0, 7.4, title, line if compiled else without) as figure:
        if not compiled:
            return figure
        left, middle, right = figure.add_gridspec(
            1, 3, left=0.05, right=0.985, top=0.875, bottom=0.075, width_ratios=(1.25, 1.0, 1.1), wspace=0.24
        )
        rows = left.subgridspec(3, 1, height_ratios=(0.5, 1.0, 1.2), hspace=0.16)
        _draw_record([figure.add_subplot(row) for row in rows])
        halves = middle.subgridspec(2, 1, hspace=0.32)
        for row, name in enumerate((PAPER, BETTER)):
            _draw_loop(figure.add_subplot(halves[row]), name)
        halves = right.subgridspec(2, 1, hspace=0.32)
        _draw_steps(figure.add_subplot(halves[0]))
        _draw_sine(figure.add_subplot(halves[1]))
        return figure


def _draw_record(axes: list[Any]) -> None:
    whole = models.read_record("validation")
    times, rows = whole.times[PART][::EVERY], slice(PART.start, PART.stop, EVERY)
    duty, heat, place = axes
    duty.plot(times, 100.0 * whole.inputs[rows, 0], color=INK, linewidth=0.9)
    duty.set_ylabel("duty [%]")
    heat.plot(times, whole.outputs[rows, 0] - ZERO, color=INK, label="bench")
    first = models.estimate_recipe("stage 1").simulate(whole)[rows, 0]
    fit = comparisons.compare_position("stage 1", "validation").fit
    heat.plot(times, first - ZERO, color=HEATING, label=f"stage 1, as in the paper: {fit:.1f} %")
    heat.set_ylabel("measured\ntemperature [°C]")
    place.plot(times, 1e3 * whole.outputs[rows, 1], color=INK, label="bench")
    series = 1e3 * models.join_stages(PAPER).simulate(whole)[rows, -1]
    fit = comparisons.in_series(PAPER, "validation").fit
    place.plot(times, series, color=HEATING, label=f"both stages, as in the paper: {fit:.1f} %")
    one = 1e3 * models.estimate_recipe(WHOLE).simulate(whole)[rows, -1]
    fit = comparisons.compare_position(WHOLE, "validation").fit
    place.plot(times, one, color=SIMULATED, label=f"one model with latent heat: {fit:.1f} %")
    place.set(ylabel="position [mm]", xlabel="time [s]", ylim=(-0.4, 14.5))
    heat.set_ylim(20, 95)
    for axis in (heat, place):
        axis.legend(loc="upper right", ncols=1, fontsize=8)
    for axis in (duty, heat):
        axis.tick_params(labelbottom=False)
    duty.set_title("pulses: the cadence of the fit")


def _draw_loop(axis: Any, name: str) -> None:
    """Draw position over measured temperature on slow ramps."""
    signals = models.mapped_signals(name, models.read_record("slow"))
    heat = signals.inputs[::EVERY, 0] - ZERO
    axis.plot(heat, 1e3 * signals.outputs[::EVERY, 0], color=INK, linewidth=0.8, label="bench")
    computed = 1e3 * models.estimate_recipe(name).simulate(signals)[::EVERY, 0]
    fit = comparisons.compare_position(name, "slow").fit
    axis.plot(heat, computed, color=COLOURS[name], linewidth=0.9, label=f"model: {fit:.1f} %")
    words = {PAPER: "slow ramps: stage 2 as in the paper", BETTER: "slow ramps: 12 plays instead"}
    axis.set(xlabel="measured temperature [°C]", ylabel="position [mm]")
    axis.set_title(words[name])
    axis.legend(loc="upper left", fontsize=8)


def _draw_steps(axis: Any) -> None:
    both = loops.compare_steps(WHOLE)
    _overlay_runs(axis, both.model, both.bench)
    axis.set_title(f"PID tuned on the model: steps, {both.likeness:.1f} % alike")


def _draw_sine(axis: Any) -> None:
    both = loops.compare_sines(WHOLE)
    _overlay_runs(axis, both.model, both.bench)
    axis.set_title(f"sine: model and bench {1e3 * both.apart:.2f} mm apart (rms)")


def _overlay_runs(axis: Any, model: Any, bench: Any) -> None:
    times = INTERVAL * np.arange(len(bench.output))[::EVERY]
    axis.plot(times, 1e3 * bench.reference[::EVERY], color=QUIET, linewidth=0.8, label="reference")
    axis.plot(times, 1e3 * bench.output[::EVERY], color=INK, label="bench")
    axis.plot(times, 1e3 * model.output[::EVERY], color=SIMULATED, linewidth=0.9, label="model")
    axis.set(xlabel="time [s]", ylabel="position [mm]")
    axis.legend(loc="lower right", fontsize=8)
