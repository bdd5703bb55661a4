"""Pictures of environments: the mechanism, and references and outputs of the episode.

The shapes are those of `draw_shapes` of the mechanism, projected by

    x' = x + y/3,    y' = z + y/4

Wires are coloured by temperature, from blue at ambient to red at the limit. Only matplotlib is needed, and no screen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from martensite.actuators.assembly.lengths import measure_lengths
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, Point
from martensite.export.episodes import Episodes

SIZE, DOTS = (4.8, 3.6), 100
"""Width and height [in], and dots per inch."""
GREY, DARK, WANTED = "#9aa5ad", "#22303c", "#d55e00"
BARS = ("link", "phalanx", "fingertip", "beam")
WIDTHS = {"ground": 5.0, "wall": 5.0, **dict.fromkeys(BARS, 4.0), "wire": 1.8, "joint": 3.0}
"""Line widths by kind of shape [points]; 1.2 for all others."""
HOTTER = 60.0
"""Temperature rise at which a wire without a limit is red [K]."""


class Frames:
    """Pictures of the environments of an `Episodes`."""

    def __init__(self, episodes: Episodes) -> None:
        """Create pictures after the first episodes have begun, at the present pose."""
        self._episodes, self._plant = episodes, episodes.bench.plant
        rest = episodes.list_outputs(0)
        self._lengths = measure_lengths(self._plant, {name: [value] for name, value in rest.items()})
        self._cold = [rest[name] for name in self._hottest()]
        first = self._list_shapes(0)
        self._box = _find_box([_project(point) for shape in first for point in shape.points])
        self._histories: list[list[tuple[float, Any, Any]]] = [[] for _ in range(episodes.count)]

    def watch(self) -> None:
        """Record present references and outputs; a new episode clears the record."""
        references, reached, at = self._episodes.list_followed()
        for k, episode in enumerate(self._histories):
            if at[k] == 0:
                episode.clear()
            episode.append((float(at[k]) * self._episodes.bench.period, references[:, k], reached[:, k]))

    def draw(self, k: int) -> Any:
        """Return the picture of one environment, 8 bits, shape (height, width, 3)."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(SIZE, DOTS)
        canvas = FigureCanvasAgg(figure)
        self._draw_mechanism(figure.add_axes((0.02, 0.3, 0.96, 0.68)), k)
        self._draw_course(figure.add_axes((0.1, 0.06, 0.88, 0.22)), k)
        canvas.draw()
        return np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[:, :, :3])

    def _hottest(self) -> list[str]:
        return [self._plant.label(port, "hottest") for port in self._plant.actuators()]

    def _list_shapes(self, k: int) -> list[DrawingShape]:
        return self._plant.mechanism.draw_shapes(DrawingState(self._episodes.list_outputs(k), self._lengths))

    def _draw_mechanism(self, axes: Any, k: int) -> None:
        from matplotlib.collections import LineCollection

        shapes = self._list_shapes(k)
        colours = self._choose_colours(self._episodes.list_outputs(k))
        lines = [_close_line(shape) for shape in shapes]
        colour = [colours.get(shape.port, DARK if shape.kind in BARS else GREY) for shape in shapes]
        widths = [WIDTHS.get(shape.kind, 1.2) for shape in shapes]
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=widths, capstyle="round"))
        dots = [_project(shape.points[0]) for shape in shapes if len(shape.points) == 1]
        if dots:
            axes.scatter(*np.transpose(dots), s=80, color=DARK, marker="s")
        (left, right), (low, high) = self._box
        axes.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        axes.set_axis_off()

    def _choose_colours(self, outputs: Mapping[str, float]) -> dict[str, tuple[float, float, float]]:
        colours: dict[str, tuple[float, float, float]] = {}
        limits = self._episodes.temperature_limits
        for port, name, cold, limit in zip(self._plant.actuators(), self._hottest(), self._cold, limits, strict=True):
            most = limit - cold if np.isfinite(limit) else HOTTER
            share = float(np.clip((outputs[name] - cold) / most, 0.0, 1.0))
            colours[port] = 0.15 + 0.75 * share, 0.35 * (1.0 - share) + 0.05, 0.75 * (1.0 - share)
        return colours

    def _draw_course(self, axes: Any, k: int) -> None:
        times, wanted, reached = (np.array(one) for one in zip(*self._histories[k], strict=True))
        axes.plot(times, wanted, color=WANTED, linewidth=0.9, linestyle="--")
        axes.plot(times, reached, color=DARK, linewidth=1.2)
        task = self._episodes.task
        room = 0.1 * (task.high - task.low)
        axes.set(xlim=(0.0, task.duration), ylim=(task.low - room, task.high + room), yticks=[])
        axes.tick_params(labelsize=6, length=2)


def _project(point: Point) -> tuple[float, float]:
    x, y, z = point
    return x + y / 3.0, z + y / 4.0


def _close_line(shape: DrawingShape) -> list[tuple[float, float]]:
    """Return the projected points; a plate is closed."""
    points = [*shape.points, shape.points[0]] if shape.kind == "plate" else shape.points
    return [_project(point) for point in points]


def _find_box(points: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], tuple[float, float]]:
    xs, ys = np.transpose(points)
    room = 0.2 * max(np.ptp(xs), np.ptp(ys), 1e-3)
    return (xs.min() - room, xs.max() + room), (ys.min() - room, ys.max() + room)
