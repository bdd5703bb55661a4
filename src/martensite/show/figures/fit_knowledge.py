"""Information of data on parameters: correlations, the least certain direction, likelihoods, the search."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.base.errors import InputError
from martensite.search.quantity_text import format_number
from martensite.show.figures.labels import QuantityAxis
from martensite.show.figures.panels import add_key, add_panels, make_grid, shorten_name, write_headline, write_title
from martensite.show.figures.style import COOLING, FAINT, HEATING, INK, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.fit.fit import Fit
    from martensite.search.profile import Profile

NUMBERED = 14
"""Largest number of parameters with printed correlations."""
CELL = 0.46
"""Side of a cell [inch]."""
LETTER = 0.073
"""Approximate width of a letter [inch]."""
MOVERS = 8
"""Largest number of drawn parameters of a direction."""
ZERO_POSITION = 1e-3
"""Position of zero singular values, relative to the smallest other one."""
TOP = 2.4
"""Height of a panel, in limits."""
BAND = "#e8eef3"


def plot_correlation(fit: Fit, title: str = "") -> Figure:
    """Draw the correlations of the parameters of a fit."""
    names, matrix = ([shorten_name(name) for name in fit.uncertainty.names], np.asarray(fit.uncertainty.correlation))
    count = len(names)
    cell = CELL if count <= NUMBERED else 0.26
    margin = 0.25 + LETTER * max(map(len, names))
    with use_style():
        width, height = max(margin + cell * count + 1.1, 4.6), margin + cell * count + 0.5
        figure = make_figure(width, height)
        box = (margin / width, margin / height, cell * count / width, cell * count / height)
        axes = figure.add_axes(box)
        write_headline(figure, title or "Correlations of the parameters")
        image = axes.imshow(
            np.ma.array(matrix, mask=~np.tril(np.ones_like(matrix, bool))),
            cmap=_make_colour_map(),
            vmin=-1.0,
            vmax=1.0,
            aspect="auto",
        )
        _draw_cells(axes, matrix, count <= NUMBERED)
        _name_axes(axes, names)
        scale = figure.add_axes(((margin + cell * count + 0.25) / width, box[1], 0.12 / width, box[3]))
        figure.colorbar(image, cax=scale, ticks=[-1.0, -0.5, 0.0, 0.5, 1.0]).outline.set_visible(False)
        return figure


def plot_singular_values(fit: Fit, title: str = "") -> Figure:
    """Draw the singular values of a fit, and its least certain direction.

    Left: singular values of the Jacobian per search range over the noise; along a direction with value 1 the
    uncertainty is the whole search range. Right: parameters of the least certain direction.
    """
    longer, moves, how = _find_weakest(fit)
    names = [shorten_name(name) for name in longer]
    margin = 0.35 + LETTER * max(map(len, names))
    with use_style():
        figure = make_figure(4.55 + margin + 3.2, 3.6)
        room, gaps = (0.72, 0.2, 0.68, 0.5), (0.13 + margin, 0.0)
        ((left, right),) = add_panels(figure, 1, 2, room, gaps, width_ratios=(3.7, 3.0))
        write_headline(figure, title or "What the data determine")
        _draw_values(left, fit)
        _draw_direction(right, names, moves)
        write_title(right, how, color=QUIET, fontsize=8.0)
        return figure


def plot_search(fit: Fit, title: str = "") -> Figure:
    """Draw the cost over the runs of the search."""
    runs, costs = (np.asarray(column, float) for column in zip(*fit.history, strict=True))
    total = fit.simulations + fit.jacobians
    with use_style():
        figure = make_figure(6.4, 3.4)
        axes = add_panels(figure, 1, 1, (0.83, 0.19, 0.61, 0.48))[0, 0]
        write_headline(figure, title or "Search")
        axes.step([*runs, total], [*costs, costs[-1]], where="post", color=SIMULATED)
        axes.plot(runs, costs, "o", color=SIMULATED, markersize=3.2)
        axes.set(yscale="log", xlim=(0.0, 1.03 * total))
        _set_decades(axes, costs)
        axes.set(xlabel="runs of single records, with and without derivatives", ylabel="cost")
        ended = f"{fit.method}: {fit.reason}; cost {format_number(fit.cost, 3)}"
        write_title(axes, ended, color=QUIET, fontsize=8.0)
        return figure


def _make_colour_map() -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("correlation", [COOLING, "#ffffff", HEATING])


def _draw_cells(axes: Any, matrix: Any, numbered: bool) -> None:
    from matplotlib.patches import Rectangle

    count = len(matrix)
    for row in range(count):
        for column in range(row + 1):
            value = float(matrix[row, column])
            corner = (column - 0.5, row - 0.5)
            if math.isnan(value):
                hatched: dict[str, Any] = {"facecolor": "white", "edgecolor": FAINT, "hatch": "////"}
                axes.add_patch(Rectangle(corner, 1.0, 1.0, linewidth=0.0, **hatched))
            elif numbered and row != column:
                words = f"{value:.2f}".replace("0.", ".").replace("-.00", ".00")
                tint = "white" if abs(value) > 0.7 else INK
                axes.text(column, row, words, color=tint, ha="center", va="center", fontsize=7.0)
            own: dict[str, Any] = {"facecolor": FAINT} if row == column else {"fill": False}
            axes.add_patch(Rectangle(corner, 1.0, 1.0, edgecolor="white", linewidth=1.0, **own))


def _name_axes(axes: Any, names: Sequence[str]) -> None:
    places = range(len(names))
    axes.set_xticks(places, names, rotation=90)
    axes.set_yticks(places, names)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set_parse_math(False)
    axes.tick_params(length=0.0)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _draw_values(axes: Any, fit: Fit) -> None:
    """Draw singular values over the noise; zero values as open marks at the lower edge."""
    entries = [1.0 / u if u else math.inf for u in fit.identifiability.uncertainties]
    positive = [value for value in entries if 0.0 < value < math.inf]
    bottom = ZERO_POSITION * min([*positive, 1.0]) if 0.0 in entries else 0.3 * min([*positive, 1.0])
    places = np.arange(1, len(entries) + 1)
    heights = np.asarray([value if value > 0.0 else 2.0 * bottom for value in entries])
    axes.set_yscale("log")
    axes.axhline(1.0, color=HEATING, linewidth=1.0, linestyle=(0, (4, 2)), zorder=1.4)
    place = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    look = {"ha": "right", "va": "top", "fontsize": 7.5, "color": HEATING}
    words = "below: uncertain by more than the search range"
    axes.annotate(words, (1.0, 1.0), (-2, -3), **place, **look)
    axes.vlines(places, bottom, heights, color=FAINT, linewidth=1.2, zorder=1.5)
    for some, fill in ((heights > 2.0 * bottom, SIMULATED), (heights <= 2.0 * bottom, "white")):
        axes.plot(places[some], heights[some], "o", color=SIMULATED, markerfacecolor=fill, markersize=5.0, zorder=2.2)
    _set_decades(axes, np.asarray([bottom, 1.0, *heights]))
    axes.set(ylim=(bottom, 2.5 * max([*positive, 1.0])), xlim=(0.4, len(entries) + 0.6))
    axes.set_xticks(places if len(entries) <= 16 else places[:: len(entries) // 8])
    axes.set(xlabel="direction of the parameters", ylabel="singular value / noise")
    if 0.0 in entries:
        write_title(axes, "open: 0, nothing is seen at all", color=QUIET, fontsize=8.0)


def _set_decades(axes: Any, values: Any) -> None:
    """Label powers of ten, and intermediate values for few decades."""
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter

    span = math.log10(float(np.max(values)) / float(np.min(values)))
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if span > 2.0 else (1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(9.0, 9.0)))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _find_weakest(fit: Fit) -> tuple[list[str], list[float], str]:
    """Return names, changes relative to search ranges, and description of the least certain direction."""
    identifiability, names = fit.identifiability, fit.problem.names
    if identifiability.weak:
        first = identifiability.weak[0]
        slopes = {free.name: free.slope(u) for free, u in zip(fit.problem.free, fit.values, strict=True)}
        moves = {n: c / slopes[n] for n, c in zip(first.names, first.changes, strict=True)}
        others = f", first of {len(identifiability.weak)}" if len(identifiability.weak) > 1 else ""
        how = f"not determined{others}"
    else:
        right = np.linalg.svd(fit.evaluation.jacobian, full_matrices=False)[2]
        moves = dict(zip(names, map(float, right[-1]), strict=True))
        how = f"to {format_number(100.0 * identifiability.uncertainties[-1], 2)} % of the search range"
    size = math.sqrt(sum(move**2 for move in moves.values())) or 1.0
    order = sorted(moves, key=lambda name: -abs(moves[name]))[:MOVERS]
    sign = math.copysign(1.0, moves[order[0]]) / size
    return order, [sign * moves[name] for name in order], f"least certain direction: {how}"


def _draw_direction(axes: Any, names: Sequence[str], moves: Sequence[float]) -> None:
    places = np.arange(len(names))
    colours = [SIMULATED if move > 0.0 else HEATING for move in moves]
    axes.barh(places, moves, height=0.62, color=colours, zorder=2.0)
    axes.axvline(0.0, color=QUIET, linewidth=0.7, zorder=2.5)
    axes.set_yticks(places, names)
    for label in axes.get_yticklabels():
        label.set_parse_math(False)
    axes.tick_params(axis="y", length=0.0)
    axes.set(ylim=(max(len(names), 4) - 0.4, -0.6), xlim=(min(0.0, 1.15 * min(moves)), 1.08))
    axes.grid(False, axis="y")
    axes.set_xlabel("move, as a share of the search range")


def plot_likelihood(profiles: Sequence[Profile], fit: Fit | None = None, title: str = "") -> Figure:
    """Draw profile likelihoods, one panel per parameter.

    Args:
        profiles: at least one.
        fit: their fit; its parabola is drawn for comparison.
        title: headline.

    Raises:
        InputError: the profiles are empty.
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
    axis = QuantityAxis(one.name, one.name, one.name, one.unit, units.choose_familiar_unit(one.value, one.unit))
    at = axis.values([point.at for point in one.points])
    excess = np.asarray([point.excess for point in one.points]) / one.limit
    limit = {"color": HEATING, "linewidth": 1.0, "linestyle": (0, (4, 2)), "zorder": 1.4}
    axes.axhline(1.0, label=f"{100.0 * one.level:g} % limit", **limit)
    dots = {"color": SIMULATED, "marker": "o", "markersize": 3.2}
    axes.plot(at, excess, linestyle="none", zorder=2.2, **dots)
    curve = _interpolate_root(at, excess, axis.values([one.value])[0])
    axes.plot(*curve, markevery=[], zorder=2.1, label="refitted", **dots)
    visible = at[excess <= TOP]
    low, high = float(visible.min()), float(visible.max())
    room = 0.06 * (high - low) or 1.0
    axes.set_xlim(low - room, high + room)
    if fit is not None:
        _draw_parabola(axes, one, fit, axis)
    ends = axis.values([one.below.at, one.above.at])
    axes.axvspan(*ends, color=BAND, linewidth=0.0, zorder=0.4)
    axes.axvline(float(axis.values([one.value])[0]), color=QUIET, linewidth=0.8, zorder=1.3)
    axes.set(ylim=(min(-0.08, 1.1 * float(excess.min())), TOP), xlabel=f"[{axis.label.partition('[')[2]}")
    axes.set(ylabel="cost above the least / limit")
    write_title(axes, one.name, fontweight="bold", color=INK)
    write_title(axes, _describe_interval(one), loc="right", color=QUIET, fontsize=8.0)


def _interpolate_root(at: Any, excess: Any, best: float) -> tuple[Any, Any]:
    """Return a curve through the points of a profile, interpolated in the square root."""
    root = np.sign(at - best) * np.sqrt(np.maximum(excess, 0.0))
    fine = np.linspace(at[0], at[-1], 401)
    return fine, np.interp(fine, at, root) ** 2


def _draw_parabola(axes: Any, one: Profile, fit: Fit, axis: QuantityAxis) -> None:
    """Draw the likelihood from the Jacobian at the optimum, in the same units."""
    unsure = fit.uncertainty
    error = unsure.errors[unsure.names.index(one.name)]
    if not 0.0 < error < math.inf:
        return
    factor, offset = units.find_conversion(axis.display_unit, axis.unit)
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
