"""Profile likelihoods: how fast the fit gets worse when one parameter is held elsewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.base.errors import InputError
from martensite.show.figures.labels import QuantityAxis
from martensite.show.figures.panels import add_key, make_grid, write_title
from martensite.show.figures.style import HEATING, INK, QUIET, SIMULATED, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.fit.fit import Fit
    from martensite.search.profile import Profile

TOP = 2.4
"""Height of a panel, in limits."""
BAND = "#e8eef3"


def plot_likelihood(profiles: Sequence[Profile], fit: Fit | None = None, title: str = "") -> Figure:
    """Draw profile likelihoods, one panel for each parameter.

    Args:
        profiles: at least one.
        fit: the fit that they start from; its parabola is drawn beside each.
        title: headline.

    Raises:
        InputError: there is no profile.
    """
    if not profiles:
        raise InputError("There is no profile likelihood to draw.")
    with use_style():
        figure, panels = make_grid(len(profiles), title or "Profile likelihoods")
        for axes, one in zip(panels, profiles, strict=True):
            _draw_panel(axes, one, fit)
        add_key(figure, *panels[0].get_legend_handles_labels())
        return figure


def _draw_panel(axes: Any, one: Profile, fit: Fit | None) -> None:
    shown = QuantityAxis(one.name, one.name, one.name, one.unit, units.choose_familiar_unit(one.value, one.unit))
    at = shown.values([point.at for point in one.points])
    excess = np.asarray([point.excess for point in one.points]) / one.limit
    limit = {"color": HEATING, "linewidth": 1.0, "linestyle": (0, (4, 2)), "zorder": 1.4}
    axes.axhline(1.0, label=f"{100.0 * one.level:g} % limit", **limit)
    dots = {"color": SIMULATED, "marker": "o", "markersize": 3.2}
    axes.plot(at, excess, linestyle="none", zorder=2.2, **dots)
    curve = _interpolate_root(at, excess, shown.values([one.value])[0])
    axes.plot(*curve, markevery=[], zorder=2.1, label="refitted", **dots)
    seen = at[excess <= TOP]
    low, high = float(seen.min()), float(seen.max())
    room = 0.06 * (high - low) or 1.0
    axes.set_xlim(low - room, high + room)
    if fit is not None:
        _draw_parabola(axes, one, fit, shown)
    ends = shown.values([one.below.at, one.above.at])
    axes.axvspan(*ends, color=BAND, linewidth=0.0, zorder=0.4)
    axes.axvline(float(shown.values([one.value])[0]), color=QUIET, linewidth=0.8, zorder=1.3)
    axes.set_ylim(min(-0.08, 1.1 * float(excess.min())), TOP)
    axes.set_xlabel(f"[{shown.label.partition('[')[2]}")
    axes.set_ylabel("cost above the least / limit")
    write_title(axes, one.name, fontweight="bold", color=INK)
    write_title(axes, _describe_interval(one), loc="right", color=QUIET, fontsize=8.0)


def _interpolate_root(at: Any, excess: Any, best: float) -> tuple[Any, Any]:
    """A curve through the points of a profile, interpolated in its root: nearly straight."""
    root = np.sign(at - best) * np.sqrt(np.maximum(excess, 0.0))
    fine = np.linspace(at[0], at[-1], 401)
    return fine, np.interp(fine, at, root) ** 2


def _draw_parabola(axes: Any, one: Profile, fit: Fit, shown: QuantityAxis) -> None:
    """What the Jacobian at the optimum says of the same, in the same units."""
    unsure = fit.uncertainty
    error = unsure.errors[unsure.names.index(one.name)]
    if not 0.0 < error < math.inf:
        return
    factor, offset = units.find_conversion(shown.shown, shown.unit)
    first, last = axes.get_xlim()
    at = np.linspace(first, last, 201)
    moved = (at * factor + offset - one.value) / error
    curve = (moved * unsure.noise) ** 2 / one.limit
    look = {"color": QUIET, "linewidth": 1.0, "linestyle": (0, (1, 1.4)), "zorder": 1.8}
    axes.plot(at, np.where(curve <= TOP, curve, np.nan), label="from the Jacobian", **look)


def _describe_interval(one: Profile) -> str:
    sides = [end.reason != "limit" for end in (one.below, one.above)]
    if all(sides):
        return "open on both sides"
    return "" if not any(sides) else f"open {'below' if sides[0] else 'above'}"
