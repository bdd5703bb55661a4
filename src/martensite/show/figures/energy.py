"""Figure of the energies per cycle of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, FAINT, HEATING, INK, SIMULATED, make_figure, use_style
from martensite.simulate.cycle_energies import CycleEnergies

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENERGY_WIDTH, ENERGY_HEIGHT, BAR = 9.0, 3.1, 0.38


def plot_energy(energies: CycleEnergies, title: str = "") -> Figure:
    """Draw the energies and the efficiency of each cycle."""
    with use_style():
        figure = make_figure(ENERGY_WIDTH, ENERGY_HEIGHT)
        ((heat, work, share),) = add_panels(figure, 1, 3, (0.6, 0.15, 0.71, 0.48))
        write_headline(figure, title or f"Energy per cycle of {energies.period:.4g} s")
        _draw_bars(heat, (("electrical", energies.electrical, HEATING), ("heat", energies.lost, COOLING)), 1.0)
        heat.set_title("into and out of the elements [J]")
        pair = (("given", energies.work, SIMULATED), ("returned", energies.returned, FAINT))
        _draw_bars(work, pair, 1e3)
        work.set_title("work [mJ]")
        cycles = np.arange(1, len(energies.work) + 1)
        share.plot(cycles, 100.0 * energies.efficiency, ".-", color=INK)
        share.set_title("work over electrical energy [%]")
        share.set(ylim=(0.0, 1.08 * share.get_ylim()[1]), xlim=(0.5, len(cycles) + 0.5))
        for axes in (heat, work, share):
            axes.set_xlabel("cycle")
            axes.locator_params(axis="x", integer=True, min_n_ticks=1)
        return figure


def _draw_bars(axes: Any, pairs: Any, factor: float) -> None:
    for shift, (word, values, tint) in zip((-0.5, 0.5), pairs, strict=True):
        places = np.arange(1, len(values) + 1) + shift * BAR
        axes.bar(places, factor * values, BAR, label=word, color=tint, edgecolor=INK, linewidth=0.4)
    axes.grid(visible=False, axis="x")
    axes.set_xlim(0.4, len(pairs[0][1]) + 0.6)
    axes.legend(loc="upper right", ncols=2)
    axes.set_ylim(0.0, 1.22 * axes.get_ylim()[1])
