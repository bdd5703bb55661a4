"""A fitted film coefficient: points, forms with their bands, and what the ambient does to them.

Left: the points and each form with the confidence band of its mean. Right: the same fluxes
turned into h with other ambient temperatures, and the straight line through each set.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, HEATING, INK, MEASURED, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.characterise.film_ambient import AtAmbient
    from martensite.characterise.film_report import FilmReport

LOOKS: dict[str, tuple[str, Any]] = {
    "constant": (MEASURED[0], (0, (1, 1.3))),
    "linear": (SIMULATED, "-"),
    "quadratic": (HEATING, (0, (5, 1.6))),
    "h1=0": (MEASURED[2], (0, (4, 1.2, 1, 1.2))),
}
"""Form -> colour and dashes."""
BANDED = ("linear", "quadratic")
"""Forms whose band is drawn, if no single one was asked for."""


def plot_film(report: FilmReport, forms: Sequence[str] | None = None, title: str = "") -> Figure:
    """Draw fits of a film coefficient, and its dependence on the ambient temperature.

    Args:
        report: what `judge_film` found.
        forms: names of the forms to draw; all if left out.
        title: headline.
    """
    shown = [form for form in report.fits if forms is None or form in forms]
    ambient = report.ambient
    with use_style():
        figure = make_figure(10.5 if ambient else 6.0, 4.2)
        write_headline(figure, title or "Film coefficient")
        panels = add_panels(figure, 1, 2 if ambient else 1, (0.68, 0.14, 0.72, 0.5), (0.72, 0.0))
        _draw_fits(panels[0, 0], report, shown)
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
    dots = {"color": INK, "markersize": 5.0, "zorder": 4, "label": "points"}
    axes.plot(points.temperatures_degC, points.h, "o", **dots)
    axes.set_ylim(0.0, 1.35 * top)
    axes.set_title(f"fits; bands: {100 * report.level:g} % for the mean")
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
    axes.set_xlabel("$T$ [°C]")
    axes.set_ylabel("$h$ [W/(m² K)]")
    axes.legend(loc="lower left")
