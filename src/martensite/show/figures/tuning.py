"""The figure of a tuning: a loop before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from martensite.base import units
from martensite.control.tuning.bench_tuning import TunedBench
from martensite.control.tuning.loop_runs import find_judged_output
from martensite.show.figures.panels import make_panels
from martensite.show.figures.style import HEATING, INK, QUIET, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TUNING_WIDTH, TUNING_HEIGHT = 7.0, 5.2
BEFORE: dict[str, Any] = {"color": QUIET, "linewidth": 1.1, "label": "before"}
AFTER: dict[str, Any] = {"color": HEATING, "linewidth": 1.4, "label": "after"}
WANTED: dict[str, Any] = {"color": INK, "linewidth": 0.9, "linestyle": (0, (4, 2)), "label": "reference"}


def plot_tuning(tuned_bench: TunedBench, drive: str, title: str = "") -> Figure:
    """Return reference and output, error and signal of a drive's loop, before and after."""
    bench = tuned_bench.bench
    output = bench.outputs()[find_judged_output(bench, drive)]
    display_unit = units.choose_readable_unit(output.unit)
    factor, _ = units.find_conversion(display_unit, output.unit)
    label = {"1": "", "degC": " [K]"}.get(display_unit, f" [{display_unit}]")
    runs = ((tuned_bench.outputs_before, BEFORE), (tuned_bench.outputs, AFTER))
    with use_style():
        ratios = (2.0, 1.0, 1.2)
        figure, panels = make_panels(TUNING_WIDTH, TUNING_HEIGHT, 3, 1, title, sharex=True, height_ratios=ratios)
        panels = panels[:, 0]
        for run, look in runs:
            values = [units.from_si(v, display_unit, output.unit) for v in run.output.tolist()]
            panels[0].plot(tuned_bench.times, values, **look)
            panels[1].plot(tuned_bench.times, (run.reference - run.output) / factor, **look)
            panels[2].plot(tuned_bench.times, run.signal, drawstyle="steps-post", **look)
        wanted = [units.from_si(v, display_unit, output.unit) for v in tuned_bench.outputs.reference.tolist()]
        panels[0].plot(tuned_bench.times, wanted, drawstyle="steps-post", **WANTED)
        panels[0].legend(loc="best")
        panels[0].set(ylabel=f"{output.long_name}{label.replace('[K]', '[°C]')}")
        panels[1].set(ylabel=f"error{label}")
        panels[2].set(ylabel=f"signal of {drive}", xlabel="time [s]")
    return figure
