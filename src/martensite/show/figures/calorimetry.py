"""Figure of a calorimeter's ramps: apparent heat capacity, baseline, and intersections of the tangents."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.labels import TEMPERATURE
from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, HEATING, INK, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.characterise.calorimetry import Calorimetry
    from martensite.characterise.heat_peaks import RampPeaks


def plot_calorimetry(calorimetry: Calorimetry, title: str = "") -> Figure:
    """Draw all ramps of a DSC, with cooling downwards."""
    with use_style():
        figure = make_figure(6.0, 4.4)
        axes = add_panels(figure, 1, 1, (0.66, 0.18, 0.66, 0.53))[0, 0]
        for one in calorimetry.ramps:
            _draw_ramp(axes, one)
        label = r"$\pm\,q/|\mathrm{d}T/\mathrm{d}t|$ [J/(g K)], absorbed heat upwards"
        axes.set(xlabel=TEMPERATURE.label, ylabel=label)
        write_headline(figure, title or f"DSC with {calorimetry.baseline} baseline")
        return figure


def _draw_ramp(axes: Any, one: RampPeaks) -> None:
    way = 1e-3 if one.ramp.is_heating else -1e-3
    colour = HEATING if one.ramp.is_heating else COOLING
    x = TEMPERATURE.values(one.ramp.temperature)
    axes.plot(x, way * one.capacity, color=colour, linewidth=1.0)
    axes.plot(x, way * one.baseline, color=INK, linewidth=0.7)
    for peak in one.peaks:
        ends = TEMPERATURE.values([peak.low, peak.high])
        axes.plot(ends, way * np.interp(ends, x, one.baseline), "o", color=colour, markersize=4.2)
