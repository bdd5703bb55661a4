"""The figure of an element that differs along itself: temperature and fraction over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import PROFILES
from martensite.base import units
from martensite.base.errors import InputError
from martensite.show.figures.labels import typeset_symbol
from martensite.show.figures.style import INK, make_figure, use_style
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"cell_temperature": "inferno", "cell_fraction": "cividis"}


def plot_profile(result: Result, title: str | None = None) -> Figure:
    """Temperature and martensite fraction of every cell over time, as two maps.

    Raises:
        InputError: the element of the result is the same all over.
    """
    elements = [one.element for one in result.system.actuators().values()]
    if not result.profiles:
        names = ", ".join(f"`{element.registered_name}`" for element in elements) or "none"
        raise InputError(
            f"There is no profile to draw of the elements of this run ({names}). "
            "A single `axial-wire` or `ribbon` has one."
        )
    with use_style():
        figure = make_figure(10.0, 3.6)
        figure.set_layout_engine("constrained")
        panels = figure.subplots(1, len(PROFILES), sharex=True, sharey=True)
        for panel, name in zip(panels, PROFILES, strict=True):
            _draw_map(figure, panel, result, name)
        panels[0].set_ylabel(f"{typeset_symbol('y')} [mm]")
        element = elements[0].registered_name
        figure.suptitle(
            title or f"Profile of a simulated {element}", x=0.01, ha="left", fontweight="bold"
        )
        return figure


def _draw_map(figure: Any, panel: Any, result: Result, name: str) -> None:
    unit, long_name, symbol = PROFILES[name]
    shown = units.choose_readable_unit(unit)
    factor, offset = units.find_conversion(shown, unit)
    values = (np.asarray(result.profiles[name]) - offset) / factor
    low, high = (0.0, 1.0) if unit == "1" else (None, None)
    (actuator,) = result.system.actuators().values()
    places = 1e3 * np.asarray(actuator.element.places())
    drawn = panel.pcolormesh(
        np.asarray(result.times),
        places,
        values,
        shading="nearest",
        cmap=COLOURS[name],
        vmin=low,
        vmax=high,
        rasterized=True,
    )
    label = {"degC": "°C", "1": "–"}.get(shown, shown)
    bar = figure.colorbar(drawn, ax=panel, pad=0.02)
    bar.set_label(f"{typeset_symbol(symbol)} [{label}]", color=INK)
    bar.outline.set_visible(False)
    panel.set(title=long_name, xlabel=f"{typeset_symbol('t')} [s]")
    panel.grid(False)
