"""Figure of the workspace of a platform: its reachable angles, and the path of each leg alone.

The edge of the set is solid where a leg is at its shortest and dashed where it is at its longest. Contour lines show
the length of leg 0.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanics.platform_kinematics import compute_lengths
from martensite.base.errors import InputError
from martensite.kernels.arrays import ArrayNamespace
from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import HEATING, INK, QUIET, make_figure, use_style
from martensite.studies.platform.workspace import QUARTER, Workspace

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REGION = "#e9eff3"
FINER = 4
"""Refinement of the grid of the set, for sharp corners."""
LINES = 14
"""Largest number of contour lines."""
ROW = 0.443
"""Height of contour labels, as a fraction of the axes."""
EDGES = ("-", (0, (4, 2)), (0, (1, 1.5)))
"""Line styles of shortest legs, longest legs, and the largest angle."""


def plot_workspace(workspace: Workspace, title: str = "") -> Figure:
    """Draw the reachable set in the plane of both angles.

    Raises:
        InputError: only the home posture is reachable.
    """
    if len(workspace.points()) == 1:
        raise InputError(
            "Nothing but the home posture is reachable on a grid of "
            f"{math.degrees(workspace.step):.3g}°: there is no set to draw. Widen the limits of "
            "the legs, or make the step smaller."
        )
    with use_style():
        figure = make_figure(6.4, 6.9)
        axes = add_panels(figure, 1, 1, (0.74, 0.13, 0.93, 0.52))[0, 0]
        write_headline(figure, title or "Reachable angles of the platform")
        _set_frame(axes, workspace)
        _draw_contours(axes, workspace, _draw_region(axes, workspace))
        _draw_rays(axes, workspace)
        figure.legend(
            *axes.get_legend_handles_labels(),
            loc="upper left",
            bbox_to_anchor=(0.01, 0.953),
            ncols=2,
            columnspacing=1.8,
            handlelength=2.2,
        )
        return figure


def _set_frame(axes: Any, workspace: Workspace) -> None:
    for place, (low, high) in zip("xy", workspace.bounds, strict=True):
        margin = 0.06 * (high - low) + workspace.step
        axes.set(**{f"{place}lim": (math.degrees(low - margin), math.degrees(high + margin))})
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set(xlabel="rotation about X, $α$ [°]", ylabel="rotation about Y, $β$ [°]")


def _draw_region(axes: Any, workspace: Workspace) -> Any:
    from matplotlib.path import Path

    alphas, betas = _refine_grid(workspace.alphas), _refine_grid(workspace.betas)
    room = _compute_rooms(workspace, alphas[:, None], betas[None, :]).min(axis=0)
    room = np.where(_outline_region(workspace), room, np.nan)
    x, y = np.degrees(alphas), np.degrees(betas)
    axes.contourf(x, y, room.T, [0.0, np.inf], colors=[REGION], zorder=0.5)
    contours = axes.contour(x, y, room.T, [0.0], linewidths=0.0)
    outline = [Path(points) for points in contours.allsegs[0]]
    contours.remove()
    kinds = {kind for path in outline for kind in _draw_edge(axes, workspace, path.vertices)}
    for kind, name in enumerate(_list_limits(workspace)):
        if kind in kinds:
            axes.plot([], [], color=INK, linestyle=EDGES[kind], linewidth=1.2, label=name)
    return Path.make_compound_path(*outline)


def _refine_grid(grid: list[float]) -> Any:
    return np.linspace(grid[0], grid[-1], FINER * (len(grid) - 1) + 1)


def _outline_region(workspace: Workspace) -> Any:
    wide = np.pad(np.asarray(workspace.reached), 1)
    rows = wide[:-2] | wide[1:-1] | wide[2:]
    near = rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]
    for axis in (0, 1):
        fine = np.arange(FINER * (near.shape[axis] - 1) + 1)
        near = near.take((fine + FINER // 2) // FINER, axis)
    return near


def _compute_rooms(workspace: Workspace, alphas: Any, betas: Any) -> Any:
    """Return the margins from the shortest and longest length, and of the plate from 90° [m], shape (3, …)."""
    legs = workspace.legs
    grid: tuple[Any, ...] = np.broadcast_arrays(alphas, betas)
    alphas, betas = grid
    lengths = np.array(compute_lengths(ArrayNamespace(np), legs.plates, alphas, betas))
    angle = QUARTER - np.maximum(np.abs(alphas), np.abs(betas))
    short, long = lengths.min(axis=0) - legs.shortest, legs.longest - lengths.max(axis=0)
    return np.array([short, long, legs.plates.height * angle])


def _draw_edge(axes: Any, workspace: Workspace, points: Any) -> list[int]:
    middles = np.radians(0.5 * (points[1:] + points[:-1]))
    kinds = _compute_rooms(workspace, *middles.T).argmin(axis=0)
    ends = [0, *(np.flatnonzero(np.diff(kinds)) + 1), len(kinds)]
    for first, end in pairwise(ends):
        x, y = points[first : end + 1].T
        axes.plot(x, y, color=INK, linestyle=EDGES[kinds[first]], linewidth=1.2, zorder=2.0)
    return [int(kind) for kind in kinds]


def _list_limits(workspace: Workspace) -> list[str]:
    short, long = (f"{1e3 * x:.4g} mm" for x in (workspace.legs.shortest, workspace.legs.longest))
    return [f"a leg at its shortest, {short}", f"a leg at its longest, {long}", "90°"]


def _draw_contours(axes: Any, workspace: Workspace, outline: Any) -> None:
    """Draw lines of equal length of leg 0 [mm], clipped to the set."""
    from matplotlib.ticker import MaxNLocator

    x, y = (np.linspace(low, high, 241) for low, high in (axes.get_xlim(), axes.get_ylim()))
    grid = np.array(np.meshgrid(x, y))
    lengths = compute_lengths(ArrayNamespace(np), workspace.legs.plates, *np.radians(grid))
    length = 1e3 * np.asarray(lengths[0])
    inside = outline.contains_points(grid.reshape(2, -1).T).reshape(length.shape)
    low, high = length[inside].min(), length[inside].max()
    levels = MaxNLocator(LINES, steps=[1, 2, 5, 10]).tick_values(low, high)
    room = 0.02 * (high - low)
    levels = levels[(low + room < levels) & (levels < high - room)]
    lines = axes.contour(x, y, length, levels, colors=QUIET, linewidths=0.7, zorder=1.2)
    lines.set_clip_path(outline, axes.transData)
    row = int(ROW * len(y))
    along = np.where(inside[row], length[row], np.nan)
    for level in levels:
        for place in _find_crossings(x, along - level):
            box = {"facecolor": REGION, "linewidth": 0.0, "pad": 1.2}
            middle = {"ha": "center", "va": "center", "fontsize": 7.5, "zorder": 1.3}
            axes.text(place, y[row], f"{level:g}", color=QUIET, bbox=box, **middle)
    axes.plot([], [], color=QUIET, linewidth=0.7, label="length of leg 0 [mm]")


def _find_crossings(x: Any, values: Any) -> list[float]:
    low, high = values[:-1], values[1:]
    return [
        float(x[i] + (x[i + 1] - x[i]) * low[i] / (low[i] - high[i]))
        for i in np.flatnonzero((low * high < 0.0) | ((low == 0.0) & (high != 0.0)))
    ]


def _draw_rays(axes: Any, workspace: Workspace) -> None:
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.0, foreground="white")]
    label = "one leg alone, against the other two"
    for leg, ray in enumerate(workspace.rays):
        if len(ray) == 1:
            continue
        points = np.degrees(np.asarray(ray))
        axes.plot(*points.T, color=HEATING, linewidth=1.6, label=label, zorder=2.6)
        axes.plot(*points[-1:].T, "o", color=HEATING, markersize=4.5, zorder=2.7)
        way = points[-1] - points[-2]
        way = 13.0 * way / max(float(np.hypot(*way)), 1e-300)
        sides = {"ha": "left" if way[0] > 0 else "right", "va": "center"}
        look = {"color": HEATING, "fontsize": 8.0, "zorder": 2.9, "path_effects": halo}
        axes.annotate(f"leg {leg}", points[-1], way, textcoords="offset points", **look, **sides)
        label = None
    axes.plot([0.0], [0.0], "o", color=INK, markersize=4.5, zorder=2.8)
