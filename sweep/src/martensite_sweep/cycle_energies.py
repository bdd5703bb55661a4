"""Energy of every cycle of a run, by `martensite.design.analysis.energy`, and its figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanisms.load_line import AbstractLoadLine
from martensite.base.errors import InputError, require_known
from martensite.design.analysis.energy import EnergyCourses, integrate_energies
from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, FAINT, HEATING, INK, SIMULATED, make_figure, use_style
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Pair = tuple[str, str]
ENERGY_WIDTH, ENERGY_HEIGHT, BAR = 9.0, 3.1, 0.38


@dataclass(frozen=True, eq=False)
class CycleEnergies(EnergyCourses):
    """Energies of every cycle, shape (cycles,) [J]."""

    period: float
    """[s]"""

    @property
    def net_work(self) -> Numbers:
        """Work less what was returned."""
        return self.work - self.returned

    @property
    def kept(self) -> Numbers:
        """Electrical less heat: what is left in the elements at the end of a cycle."""
        return self.electrical - self.lost


def compute_cycle_energies(result: Result, period: float, *, pairs: Sequence[Pair] | None = None) -> CycleEnergies:
    """Energies of all whole cycles of a run.

    Args:
        result: a run, of a plant or of a bench.
        period: length of a cycle [s].
        pairs: columns of force and of the coordinate that grows as it pulls, such as a torque and
            an angle; by default force and position of a mechanism with one element on a line.

    Raises:
        InputError: there is no whole cycle, a column is missing, or the mechanism needs `pairs`.
    """
    result = add_step_rows(result)
    times = np.asarray(result.times)
    cycles = math.floor((times[-1] - times[0]) / period * (1.0 + 1e-9)) if period > 0.0 else 0
    if cycles < 1:
        raise InputError(f"A run of {times[-1] - times[0]:g} s has no whole cycle of {period:g} s.")
    ends = times[0] + period * np.arange(cycles + 1)
    ways = [
        (np.asarray(result.columns[force]), np.asarray(result.columns[coordinate]))
        for force, coordinate in _find_columns(result, pairs)
    ]
    over = integrate_energies(result, ways)
    totals = over.electrical, over.lost, over.work, over.returned
    found = [np.diff(np.interp(ends, times, total)) for total in totals]
    return CycleEnergies(found[0], found[1], found[2], found[3], period)


def _find_columns(result: Result, pairs: Sequence[Pair] | None) -> Sequence[Pair]:
    """Columns of force and coordinate."""
    if pairs is None:
        if not isinstance(result.system.mechanism, AbstractLoadLine):
            raise InputError("Say by `pairs` which force of this mechanism works along which coordinate.")
        (port,) = result.system.actuators()
        return [(result.system.label(port, "force"), result.coordinate)]
    for name in (one for pair in pairs for one in pair):
        require_known("column", name, result.columns)
    return pairs


def plot_energy(found: CycleEnergies, title: str = "") -> Figure:
    """Draw the energies of every cycle that `compute_cycle_energies` found, and the efficiency."""
    with use_style():
        figure = make_figure(ENERGY_WIDTH, ENERGY_HEIGHT)
        ((heat, work, share),) = add_panels(figure, 1, 3, (0.6, 0.15, 0.71, 0.48))
        write_headline(figure, title or f"Energy per cycle of {found.period:.4g} s")
        _draw_bars(heat, (("electrical", found.electrical, HEATING), ("heat", found.lost, COOLING)), 1.0)
        heat.set_title("into and out of the elements [J]")
        pair = (("given", found.work, SIMULATED), ("returned", found.returned, FAINT))
        _draw_bars(work, pair, 1e3)
        work.set_title("work [mJ]")
        cycles = np.arange(1, len(found.work) + 1)
        share.plot(cycles, 100.0 * found.efficiency, ".-", color=INK)
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
