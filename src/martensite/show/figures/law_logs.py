"""Laws compared with a log: one panel with all curves, and phase diagrams with the path."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from martensite.base.errors import InputError
from martensite.scenario.law_logs import LawComparison
from martensite.show.figures.labels import STRAIN, STRESS, TEMPERATURE
from martensite.show.figures.law_paths import CASES
from martensite.show.figures.panels import add_colour_key, make_grid
from martensite.show.figures.phase_diagram import draw_phase_diagram
from martensite.show.figures.style import MEASURED, QUIET, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_law_log(comparisons: Sequence[LawComparison], *, title: str | None = None) -> Figure:
    """Return the figure of laws compared with logs of one kind, from `compare_laws_with_log`.

    Raises:
        InputError: there is nothing to draw, or stress is constant in one log and varies in another.
    """
    if len({one.compared for one in comparisons}) != 1:
        raise InputError("Draw logs of one kind together: with a stress that rests, or with one that moves.")
    by_law: dict[str, list[LawComparison]] = {}
    for one in comparisons:
        by_law.setdefault(one.configured.law.registered_name, []).append(one)
    logs = ", ".join(dict.fromkeys(one.log for one in comparisons))
    across, up = (TEMPERATURE, STRAIN) if comparisons[0].compared == "strain" else (STRAIN, STRESS)
    with use_style():
        figure, (loops, *diagrams) = make_grid(1 + len(by_law), title or f"{', '.join(by_law)} beside {logs}")
        keys = {"recorded": MEASURED[0]}
        for (name, own), colour, axes in zip(by_law.items(), CASES * 9, diagrams, strict=False):
            for one in own:
                x, y = across.values(one.recorded[across.name]), up.values(one.recorded[one.compared])
                loops.plot(x, y, color=MEASURED[0], linewidth=2.4, alpha=0.5, zorder=1.5)
                loops.plot(x, up.values(one.computed), color=colour)
            keys[f"{name}, RMS {100.0 * max(one.rms for one in own):.3g} % of range"] = colour
            draw_phase_diagram(axes, own[0].configured.law, [one.result for one in own], [[colour]] * len(own))
            axes.set_title(name, color=QUIET)
        loops.set(xlabel=across.label, ylabel=up.label)
        add_colour_key(figure, keys)
    return figure
