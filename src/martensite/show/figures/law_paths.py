"""Figures of material points: stress over strain, strain over temperature, ξ, phase diagram.

Paths of one law fill four panels; several laws have one column each, with axes shared along each row. A single path is
coloured by the kind of its legs, several paths by path.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import InputError
from martensite.show.figures.labels import STRAIN, STRESS, TEMPERATURE, QuantityAxis, enclose_values
from martensite.show.figures.panels import (
    add_colour_key,
    add_panels,
    draw_arrow,
    draw_start,
    make_colour_samples,
    measure_way,
    share_limits,
    write_headline,
)
from martensite.show.figures.phase_diagram import ARROWS, draw_phase_diagram
from martensite.show.figures.style import COOLING, HEATING, INK, SIMULATED, make_figure, use_style
from martensite.simulate.path_stages import list_stages
from martensite.simulate.point import PointResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = (SIMULATED, "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#6f6f6f")
"""Colours of several paths."""
KINDS = {
    "loading": SIMULATED,
    "stretching": SIMULATED,
    "unloading": "#009e73",
    "releasing": "#009e73",
    "heating": HEATING,
    "cooling": COOLING,
}
"""Colours of the legs of a single path."""
AXES = {
    "strain": STRAIN,
    "stress": STRESS,
    "temperature": TEMPERATURE,
    "martensite": QuantityAxis("martensite", "martensite fraction", "ξ", "1", "1"),
}
LOOP = ("strain", "stress")
COLUMN, ROW, HEAD = 3.7, 2.9, 0.95
"""Width of a column, height of a row, and space for the title [inch]."""
ROOM, GAPS = (0.75, 0.2, HEAD, 0.5), (0.8, 0.65)
"""Margins around the panels, and between them [inch]."""


def plot_point(
    results: PointResult | Sequence[PointResult], *, title: str | None = None, plane: tuple[str, str] = LOOP
) -> Figure:
    """Return the figure of a material-point study.

    Args:
        results: one path, several paths of one law, or paths of several laws.
        title: first line of the figure; by default the names of the laws.
        plane: columns (horizontal, vertical) of the first row for several laws.

    Raises:
        InputError: there is nothing to draw.
    """
    every = [results] if isinstance(results, PointResult) else list(results)
    if not every:
        raise InputError("A figure needs at least one result of `material_point`; none given.")
    by_law: dict[Any, list[PointResult]] = {}
    for result in every:
        by_law.setdefault(result.law, []).append(result)
    with use_style():
        return _draw_one(every, title) if len(by_law) == 1 else _draw_beside(by_law, title, plane)


def _draw_one(results: Sequence[PointResult], title: str | None) -> Figure:
    figure = _make_figure(2, 2, 4.6, 3.1)
    (loop, diagram), (recovery, fraction) = add_panels(figure, 2, 2, ROOM, GAPS)
    draw_curves(loop, results, *LOOP)
    draw_curves(recovery, results, "temperature", "strain")
    draw_fractions(fraction, results)
    draw_phase_diagram(diagram, results[0].law, results, _choose_leg_colours(results))
    write_headline(figure, title or _join_names([results[0]]))
    add_colour_key(figure, _make_legend(results))
    return figure


def _draw_beside(by_law: dict[Any, list[PointResult]], title: str | None, plane: tuple[str, str]) -> Figure:
    figure = _make_figure(3, len(by_law), COLUMN, ROW)
    panels = add_panels(figure, 3, len(by_law), ROOM, GAPS)
    for column, (law, results) in enumerate(by_law.items()):
        curves, fraction, diagram = (row[column] for row in panels)
        draw_curves(curves, results, *plane)
        draw_fractions(fraction, results)
        draw_phase_diagram(diagram, law, results, _choose_leg_colours(results))
        curves.set_title(law.registered_name or type(law).__name__, fontweight="bold")
    for row in panels:
        share_limits(row)
    legends = [_make_legend(results) for results in by_law.values()]
    alike = all(legend == legends[0] for legend in legends)
    if not alike:  # conditions differ between laws
        for axes, legend in zip(panels[0], legends, strict=True):
            axes.legend(make_colour_samples(legend), list(legend), loc="best")
    write_headline(figure, title or _join_names([own[0] for own in by_law.values()]))
    add_colour_key(figure, legends[0] if alike else {})
    return figure


def draw_curves(axes: Any, results: Sequence[PointResult], x: str, y: str) -> None:
    """Draw one column over another, with an arrow on each leg."""
    across, up = AXES[x], AXES[y]
    curves = [(across.values(r[x]), up.values(r[y])) for r in results]
    axes.set(xlim=enclose_values(*(s[0] for s in curves)), ylim=enclose_values(*(s[1] for s in curves)))
    for result, colour, (horizontal, vertical) in zip(results, _choose_colours(results), curves, strict=True):
        for leg, (first, last, own) in enumerate(_split_legs(result, colour, alone=len(results) == 1)):
            a, b = horizontal[first : last + 1], vertical[first : last + 1]
            axes.plot(a, b, color=own, zorder=2.2)
            if measure_way(axes, a, b)[-1] > 0.12 and leg < ARROWS:
                draw_arrow(axes, a, b, own)
        draw_start(axes, horizontal, vertical)
    axes.set(xlabel=across.label, ylabel=up.label)


def draw_fractions(axes: Any, results: Sequence[PointResult]) -> None:
    """Draw ξ (solid) and the oriented fraction (dotted) over the legs of the paths."""
    for result, colour in zip(results, _choose_colours(results), strict=True):
        for leg, (first, last, own) in enumerate(_split_legs(result, colour, alone=len(results) == 1)):
            x = np.linspace(leg, leg + 1.0, last - first + 1)
            axes.plot(x, result.martensite[first : last + 1], color=own, zorder=2.2)
            oriented = result.oriented[first : last + 1]
            axes.plot(x, oriented, ":", color=own, linewidth=1.6, zorder=2.3)
    most = max(len(result.legs) for result in results)
    axes.set(xlim=(0.0, most), ylim=(min(-0.06, min(min(r.oriented) for r in results) - 0.06), 1.06))
    axes.set_xticks(range(most + 1))
    axes.set(xlabel="leg of the path", ylabel=f"{AXES['martensite'].label}, oriented dotted")


def _split_legs(result: PointResult, colour: str, *, alone: bool) -> list[tuple[int, int, str]]:
    """Return first sample, last sample and colour of each leg."""
    spans = pairwise(result.ends)
    if not alone:
        return [(first, last, colour) for first, last in spans]
    kinds = [stage.kind for stage in list_stages(result)]
    return [(*span, KINDS.get(kind, INK)) for span, kind in zip(spans, kinds, strict=True)]


def _choose_leg_colours(results: Sequence[PointResult]) -> list[list[str]]:
    alone = len(results) == 1
    return [
        [own for _, _, own in _split_legs(result, colour, alone=alone)]
        for result, colour in zip(results, _choose_colours(results), strict=True)
    ]


def _choose_colours(results: Sequence[PointResult]) -> list[str]:
    if len(results) == 1:
        return [INK]
    return [CASES[i % len(CASES)] for i in range(len(results))]


def _make_legend(results: Sequence[PointResult]) -> dict[str, str]:
    if len(results) > 1:
        colours = _choose_colours(results)
        return {r.label or f"path {i + 1}": colours[i] for i, r in enumerate(results)}
    kinds = [stage.kind for stage in list_stages(results[0])]
    return {kind: KINDS.get(kind, INK) for kind in kinds}


def _join_names(results: Sequence[PointResult]) -> str:
    return ", ".join(r.law.registered_name or type(r.law).__name__ for r in results)


def _make_figure(rows: int, columns: int, width: float, height: float) -> Figure:
    return make_figure(0.5 + columns * width, HEAD + rows * height)
