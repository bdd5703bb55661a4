"""The figure of an element that differs along itself: temperature and fraction over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import PROFILES
from martensite.base import units
from martensite.base.errors import InputError
from martensite.base.formats import typeset_unit
from martensite.show.figures.labels import typeset_symbol
from martensite.show.figures.panels import add_colour_bar, make_panels
from martensite.show.figures.style import use_style
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
        headline = title or f"Profile of a simulated {elements[0].registered_name}"
        shared = {"sharex": True, "sharey": True}
        figure, (panels,) = make_panels(10.0, 3.6, 1, len(PROFILES), headline, **shared)
        for panel, name in zip(panels, PROFILES, strict=True):
            _draw_map(figure, panel, result, name)
        panels[0].set_ylabel(f"{typeset_symbol('y')} [mm]")
        return figure


def _draw_map(figure: Any, panel: Any, result: Result, name: str) -> None:
    unit, long_name, symbol = PROFILES[name]
    shown = units.choose_readable_unit(unit)
    factor, offset = units.find_conversion(shown, unit)
    values = (np.asarray(result.profiles[name]) - offset) / factor
    low, high = (0.0, 1.0) if unit == "1" else (None, None)
    (actuator,) = result.system.actuators().values()
    places = 1e3 * np.asarray(actuator.element.places())
    look = {"cmap": COLOURS[name], "vmin": low, "vmax": high, "rasterized": True}
    drawn = panel.pcolormesh(np.asarray(result.times), places, values, shading="nearest", **look)
    label = f"{typeset_symbol(symbol)} [{typeset_unit(shown, '–')}]"
    add_colour_bar(figure, drawn, panel, label)
    panel.set(title=long_name, xlabel=f"{typeset_symbol('t')} [s]")
    panel.grid(False)
