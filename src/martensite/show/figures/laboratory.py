"""Figures of laboratory tests: tangents of isobaric cycles, and a fitted film coefficient.

Tangents: one panel per cycle with the three lines of each branch and their intersections; also stress over temperature
with the lines of common slope, and the transformation strain over stress. Film coefficient: the points and each form
with the confidence band of its mean; also the same heat fluxes converted to h at other ambient temperatures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.labels import STRAIN, STRESS, TEMPERATURE, QuantityAxis, enclose_values, typeset_symbol
from martensite.show.figures.panels import add_panels, pick_evenly, write_headline
from martensite.show.figures.style import COOLING, HEATING, INK, MEASURED, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.characterise.film_ambient import AtAmbient
    from martensite.characterise.film_report import FilmReport
    from martensite.characterise.isobaric_cycles import CycleBranch
    from martensite.characterise.tangent_fit import Direction, TangentFit
    from martensite.characterise.tangent_lines import BranchTangents
    from martensite.characterise.tangent_points import TangentPoints

TRANSFORMATION = QuantityAxis("H", "transformation strain", "H", "1", "%")
MOST_PANELS = 6
"""Largest number of drawn cycles; of more, those evenly spread over the stresses."""
DOTS = 120
"""Largest number of rows of a branch with dots."""
_MARKS = {"A_s": "o", "A_f": "s", "M_s": "s", "M_f": "o"}
LOOKS: dict[str, tuple[str, Any]] = {
    "constant": (MEASURED[0], (0, (1, 1.3))),
    "linear": (SIMULATED, "-"),
    "quadratic": (HEATING, (0, (5, 1.6))),
    "h1=0": (MEASURED[2], (0, (4, 1.2, 1, 1.2))),
}
"""Colour and dashes by form."""
BANDED = ("linear", "quadratic")
"""Forms with a drawn band, if several forms are drawn."""


def plot_tangents(tangents: TangentFit | TangentPoints, title: str = "") -> Figure:
    """Draw the tangents of one cycle, or of cycles under several stresses with their fit."""
    from martensite.characterise.tangent_points import TangentPoints

    with use_style():
        if isinstance(tangents, TangentPoints):
            figure = make_figure(6.0, 4.4)
            _draw_cycle(add_panels(figure, 1, 1, (0.66, 0.18, 0.66, 0.53))[0, 0], tangents)
        else:
            figure = _draw_several(tangents)
        write_headline(figure, title or "Tangents")
        return figure


def _draw_several(tangent_fit: TangentFit) -> Figure:
    levels = pick_evenly(tangent_fit.levels, MOST_PANELS)
    columns = 1 if len(levels) < 3 else 2
    rows = -(-len(levels) // columns)
    figure = make_figure(11.5, max(2.3 * rows, 5.6))
    wide = 10.64 * 0.85 * columns / (0.85 * columns + 1.0)  # of the cycles [inch]
    room = (0.69, 10.81 - wide, 0.64, 0.5)
    cycles = list(add_panels(figure, rows, columns, room, (0.45, 0.4), sharex=True).flat)
    for k, (axes, points) in enumerate(zip(cycles, levels, strict=False)):
        _draw_cycle(axes, points)
        bottom, edge = k + columns >= len(levels), k % columns == 0
        axes.tick_params(labelbottom=bottom)
        axes.set(xlabel=TEMPERATURE.label if bottom else "", ylabel=STRAIN.label if edge else "")
    for axes in cycles[len(levels) :]:
        axes.remove()
    room = (1.3 + wide, 0.17, 0.64, 0.5)
    (diagram,), (strain,) = add_panels(figure, 2, 1, room, (0.0, 0.65), height_ratios=(1.5, 1.0))
    _draw_diagram(diagram, tangent_fit)
    _draw_strain(strain, tangent_fit)
    return figure


def _draw_cycle(axes: Any, points: TangentPoints) -> None:
    _draw_branch(axes, points.cycle.heating, points.heating, ("A_s", "A_f"), HEATING)
    _draw_branch(axes, points.cycle.cooling, points.cooling, ("M_f", "M_s"), COOLING)
    H = TRANSFORMATION.values([points.H])[0]
    axes.set(title=f"{points.stress / 1e6:.3g} MPa:  $H$ = {H:.2f} %", xlabel=TEMPERATURE.label, ylabel=STRAIN.label)


def _draw_branch(axes: Any, rows: CycleBranch, tangents: BranchTangents, names: tuple[str, str], colour: str) -> None:
    x, y = TEMPERATURE.values(rows.temperature), STRAIN.values(rows.strain)
    dots = {"marker": "o", "markersize": 1.8, "markeredgewidth": 0.0} if len(x) <= DOTS else {}
    axes.plot(x, y, color=colour, linewidth=0.8, alpha=0.55, zorder=1.8, **dots)
    low, high = tangents.low, tangents.high
    beyond = 0.18 * (high - low)
    pieces = (
        (tangents.cold, tangents.span[0], low + beyond),
        (tangents.steep, low - beyond, high + beyond),
        (tangents.hot, high - beyond, tangents.span[1]),
    )
    for line, begin, end in pieces:
        at = [begin, end]
        strain = STRAIN.values([line.value(t) for t in at])
        axes.plot(TEMPERATURE.values(at), strain, color=INK, linewidth=0.7, zorder=2.2)
    for name, at, line in zip(names, (low, high), (tangents.cold, tangents.hot), strict=True):
        _mark_point(axes, name, at, float(line.value(at)), colour)


def _mark_point(axes: Any, name: str, kelvin: float, strain: float, colour: str) -> None:
    x, y = TEMPERATURE.values([kelvin])[0], STRAIN.values([strain])[0]
    look = {"markersize": 4.2, "markeredgecolor": "white", "markeredgewidth": 0.6}
    axes.plot([x], [y], _MARKS[name], color=colour, zorder=3.0, **look)
    right, above = name.startswith("A"), name in ("A_s", "M_f")
    beside = 5 if right else -5, 4 if above else -4
    sides = {"ha": "left" if right else "right", "va": "bottom" if above else "top"}
    look = {"textcoords": "offset points", "color": colour, "fontsize": 8.0, "zorder": 3.0}
    axes.annotate(typeset_symbol(name), (x, y), beside, **sides, **look)


def _draw_diagram(axes: Any, tangent_fit: TangentFit) -> None:
    top = 1.12 * max(points.stress for points in tangent_fit.levels)
    for one, colour in ((tangent_fit.reverse, HEATING), (tangent_fit.forward, COOLING)):
        _draw_lines(axes, tangent_fit, one, top, colour)
        for name in one.names:
            x = TEMPERATURE.values([getattr(points, name) for points in tangent_fit.levels])
            y = STRESS.values([points.stress for points in tangent_fit.levels])
            filled = colour if name in ("A_f", "M_f") else "white"
            look = {"color": colour, "markerfacecolor": filled, "markersize": 4.4}
            axes.plot(x, y, _MARKS[name], linestyle="none", zorder=3.0, **look)
    low, high = axes.get_xlim()
    axes.set(xlim=(low - 0.05 * (high - low), high), ylim=(0.0, STRESS.values([top])[0]), xlabel=TEMPERATURE.label)
    axes.set(ylabel=STRESS.label)
    slopes = (
        f"${symbol}$ = {one.slope / 1e6:.3g}{_describe_half(one)} MPa/K"
        for symbol, one in (("C_A", tangent_fit.reverse), ("C_M", tangent_fit.forward))
    )
    axes.set_title(",  ".join(slopes))


def _describe_half(one: Direction) -> str:
    low, high = one.slope_interval()
    return f" ± {0.5e-6 * (high - low):.2g}" if np.isfinite(high - low) else ""


def _draw_lines(axes: Any, tangent_fit: TangentFit, one: Direction, top: float, colour: str) -> None:
    stress = [0.0, top]
    sides = [TEMPERATURE.values([end.value + one.shift.value * s for s in stress]) for end in (one.start, one.finish)]
    y = STRESS.values(stress)
    axes.fill_betweenx(y, *sides, color=colour, alpha=0.10, linewidth=0.0, zorder=0.6)
    for name, x in zip(one.names, sides, strict=True):
        style = "-" if name in ("A_f", "M_f") else "--"
        axes.plot(x, y, style, color=colour, linewidth=1.0, zorder=1.5)
        left = name in ("A_s", "M_f")
        beside, side = (-4 if left else 8, 4), "right" if left else "left"
        look = {"textcoords": "offset points", "color": colour, "fontsize": 8.5, "ha": side}
        axes.annotate(typeset_symbol(name), (x[0], y[0]), beside, **look)


def _draw_strain(axes: Any, tangent_fit: TangentFit) -> None:
    stress = [points.stress for points in tangent_fit.levels]
    x = STRESS.values(stress)
    for way, colour in (("heating", HEATING), ("cooling", COOLING)):
        y = [getattr(points, way).transformation_strain for points in tangent_fit.levels]
        axes.plot(x, TRANSFORMATION.values(y), "o", color=colour, markersize=3.6, label=way)
    at = np.linspace(0.0, 1.12 * max(stress), 101).tolist()
    fitted = TRANSFORMATION.values([tangent_fit.strain.value(s) for s in at])
    axes.plot(STRESS.values(at), fitted, color=SIMULATED, label=f"{tangent_fit.strain.form} $H(σ)$")
    strokes = TRANSFORMATION.values([points.stroke for points in tangent_fit.levels])
    axes.plot(x, strokes, "x", color=QUIET, markersize=4.0, label="stroke")
    axes.set(xlim=(0.0, STRESS.values([at[-1]])[0]), ylim=(0.0, enclose_values([0.0], strokes, fitted)[1]))
    axes.set(xlabel=STRESS.label, ylabel=TRANSFORMATION.label)
    axes.legend(loc="lower right", ncols=2)


def plot_film(report: FilmReport, forms: Sequence[str] | None = None, title: str = "") -> Figure:
    """Draw fits of a film coefficient, and its dependence on the ambient temperature.

    Args:
        report: fits and tests.
        forms: names of the forms to draw; by default all.
        title: headline.
    """
    names = [form for form in report.fits if forms is None or form in forms]
    ambient = report.ambient
    with use_style():
        figure = make_figure(10.5 if ambient else 6.0, 4.2)
        write_headline(figure, title or "Film coefficient")
        panels = add_panels(figure, 1, 2 if ambient else 1, (0.68, 0.14, 0.72, 0.5), (0.72, 0.0))
        _draw_fits(panels[0, 0], report, names)
        if ambient is not None:
            _draw_ambients(panels[0, 1], report, ambient.shifts)
        return figure


def _draw_fits(axes: Any, report: FilmReport, forms: Sequence[str]) -> None:
    points = report.points
    at = np.linspace(*_find_span(points.temperatures_degC), 101)
    banded = forms if len(forms) == 1 else BANDED
    top = max(points.h)
    for form in forms:
        fit, (colour, dashes) = report.fits[form], LOOKS[form]
        line = np.asarray([fit.film(t) for t in at])
        label = f"{form}: $R^2$ {fit.r_squared:.4f}, adjusted {fit.adjusted:.3f}"
        axes.plot(at, line, color=colour, linestyle=dashes, label=label)
        if form in banded and fit.linear.freedom:
            half = np.asarray([fit.half_width(t, report.level) for t in at])
            axes.fill_between(at, line - half, line + half, color=colour, alpha=0.13, linewidth=0.0)
    axes.plot(points.temperatures_degC, points.h, "o", color=INK, markersize=5.0, zorder=4, label="points")
    axes.set(ylim=(0.0, 1.35 * top), title=f"fits; bands: {100 * report.level:g} % for the mean")
    _name_form(axes)


def _draw_ambients(axes: Any, report: FilmReport, shifts: Sequence[AtAmbient]) -> None:
    at = np.asarray(_find_span(report.points.temperatures_degC))
    for shift in shifts:
        over = shift.points.ambient - report.points.ambient
        colour = INK if over == 0.0 else HEATING if over > 0.0 else COOLING
        shade = 1.0 if abs(over) < 2.0 else 0.55
        axes.plot(at, [shift.line.film(t) for t in at], color=colour, alpha=shade, linewidth=1.0)
        look = {"color": colour, "alpha": shade, "markersize": 4.0}
        label = f"{shift.points.ambient:g} °C ({over:+g} K)"
        axes.plot(shift.points.temperatures_degC, shift.points.h, "o", label=label, **look)
    axes.set_title("the same powers with another ambient temperature; straight lines")
    axes.set_ylim(0.0, 1.1 * max(max(shift.points.h) for shift in shifts))
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    _name_form(axes)


def _find_span(temperatures: Sequence[float]) -> tuple[float, float]:
    low, high = min(temperatures), max(temperatures)
    margin = 0.06 * (high - low)
    return low - margin, high + margin


def _name_form(axes: Any) -> None:
    axes.set(xlabel="$T$ [°C]", ylabel="$h$ [W/(m² K)]")
    axes.legend(loc="lower left")
