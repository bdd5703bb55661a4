"""Figure of the study: resistance against current and temperature, and its uncertainty."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from martensite.show.figures.style import INK, MEASURED, QUIET, SIMULATED
from martensite.studies.electrothermal import ElectrothermalStaircase, model, record
from martensite.studies.electrothermal.model_numbers import KEPT, calibrate_numbers
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.electrothermal.resistance_figure import over_offset, over_temperature
from martensite.studies.figures import draw_page, label_axes
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {
    "calibrated": ("calibrated: $\\rho_A$, $\\rho_M$, apparent $h$", SIMULATED, "solid"),
    "material": ("material, free convection", MEASURED[1], (0, (5, 1.6))),
    "maker": ("maker's sheet, free convection: no fit", MEASURED[0], (0, (1, 1.3))),
}


def draw_figure(stated: Printed) -> Figure:
    """Draw the figure."""
    run = RecordStaircase(stated) if record.has_files(record.UNTRAINED, record.WARMTH) else None
    below = "Points: Leal 2016, run 5 (MIT). All curves but the maker's were chosen or fitted "
    below += "on these points; hollow points below are held out."
    with draw_page(
        11.0,
        4.6 if run is None else 8.6,
        "Flexinol wire, 0.381 mm × 190 mm, no load: resistance on a staircase of voltage",
        ElectrothermalStaircase.table["absent"] if run is None else below,
    ) as figure:
        grid = figure.add_gridspec(
            1 if run is None else 2,
            2,
            left=0.06,
            right=0.98,
            top=0.82 if run is None else 0.9,
            bottom=0.12 if run is None else 0.07,
            width_ratios=(1.5, 1.0),
            wspace=0.16,
            hspace=0.28,
        )
        axes = figure.add_subplot(grid[0, :] if run is None else grid[0, 0])
        _draw_simulated(axes, stated, run)
        if run is not None:
            _draw_measured(axes, run)
            over_offset(figure.add_subplot(grid[0, 1]), stated)
            over_temperature(figure.add_subplot(grid[1, :]), stated)
        label_axes(axes, "resistance against current", "$I$ [A]", "$R$ [Ω]")
        axes.set_xlim(0.4, 3.2)
        axes.set_ylim(1.25, 1.82)
        axes.legend(loc="upper right", ncols=2)
        return figure


def _draw_simulated(axes: Any, stated: Printed, run: RecordStaircase | None) -> None:
    for key, (label, colour, dashes) in LOOKS.items():
        if key == "calibrated" and run is None:
            continue
        fitted = calibrate_numbers(stated) if key == "calibrated" else None
        table = model.predict_plateaus(key, stated, fitted)
        if run is not None:
            label += f", rms {model.resistance_rms(table, run, *KEPT):.3f} Ω"
        axes.plot(
            table["current"],
            table["resistance"],
            color=colour,
            linestyle=dashes,
            label=label,
            linewidth=1.8 if key == "calibrated" else 1.2,
        )


def _draw_measured(axes: Any, run: RecordStaircase) -> None:
    compared, error = run.within(*KEPT), run.offset(*run.stated.cold).offset_error
    current, resistance = run.table["current"], run.resistance
    axes.errorbar(
        [current[i] for i in compared],
        [resistance[i] for i in compared],
        yerr=[error / current[i] for i in compared],
        fmt="o",
        color=INK,
        markersize=3.8,
        elinewidth=0.6,
        ecolor=QUIET,
        label="run 5; bars: offset ± error",
        zorder=4,
    )
    others = [i for i in range(len(resistance)) if i not in compared]
    axes.plot(
        [current[i] for i in others],
        [resistance[i] for i in others],
        "o",
        color=QUIET,
        markerfacecolor="none",
        markersize=3.8,
        label="run 5, 1.0 to 1.2 V",
    )
