"""What the page draws of the mechanism in space: shapes once, and where they are over time.

Places are whole numbers of a `quantum` [m]; shapes that stand still are sent once, so that a run is
some ten thousand numbers. An element is drawn by what it is made of: as a wire, or as a coil.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.lengths import measure_lengths
from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.mechanisms.drawing import NEWTON, DrawingShape, DrawingState, Point
from martensite.scenario.scenario import Scenario
from martensite.simulate.result import Result
from martensite_app.messages import JsonTable
from martensite_app.views.columns import choose_rows

MOST, LEAST = 241, 61
"""Pictures of a run: as many, and as few where there are many shapes."""
MOST_NUMBERS = 60_000
"""Coordinates of all pictures together."""
FINENESS = 1e-5
"""Quantum as a share of the size of the picture."""
SHOWN = ("temperature", "martensite_fraction", "force", "stress")


def describe_scene(scenario: Scenario, result: Result) -> JsonTable:
    """Shapes and pictures of a run; see `Scene` in the page's types for what is what."""
    system: AbstractSystem = scenario.system
    lengths = measure_lengths(system, result.columns)
    names = list(system.mechanism.outputs())
    first = draw_row(system, result, lengths, names, 0)
    numbers = 3 * sum(len(shape.points) for shape in first)
    rows = choose_rows(len(result.times), max(min(MOST, MOST_NUMBERS // max(numbers, 1)), LEAST))
    pictures = [first, *(draw_row(system, result, lengths, names, row) for row in rows[1:])]
    low, high = _find_bounds(pictures)
    quantum = _choose_quantum(math.dist(low, high))
    still = [_is_still(pictures, k) for k in range(len(first))]
    return {
        "shapes": [_describe_shape(shape, stands, system, quantum) for shape, stands in zip(first, still, strict=True)],
        "times": [result.times[row] for row in rows],
        "quantum": quantum,
        "newton": NEWTON,
        "frames": [_flatten_points(_list_moving(shapes, still), quantum) for shapes in pictures],
        "turns": [[s.turn for s in shapes if s.kind in TURNING] for shapes in pictures],
        "low": low,
        "high": high,
        "ports": {
            port: {
                **{name: system.label(port, name) for name in SHOWN},
                "slack": _list_slack(result.columns[system.label(port, "force")], rows),
            }
            for port in system.actuators()
        },
    }


TURNING = ("pulley", "rotor")
"""Kinds of shapes that turn."""


def draw_row(
    system: AbstractSystem, result: Result, lengths: Mapping[str, float], names: Sequence[str], row: int
) -> list[DrawingShape]:
    """The mechanism at one row of the result, from its outputs by name."""
    return system.mechanism.draw_shapes(DrawingState({n: result.columns[n][row] for n in names}, lengths))


def _describe_shape(shape: DrawingShape, stands: bool, system: AbstractSystem, quantum: float) -> JsonTable:
    found: JsonTable = {
        "name": shape.name,
        "kind": shape.kind,
        "size": shape.size,
        "count": len(shape.points),
        "still": _flatten_points([shape], quantum) if stands else None,
    }
    if shape.mass:
        found["mass"] = shape.mass
    if shape.port:
        found |= {"port": shape.port, **_describe_element(system.actuators()[shape.port].element)}
    return found


def _describe_element(element: AbstractElement) -> JsonTable:
    one = getattr(element, "one", None)
    if isinstance(one, AbstractElement):
        return _describe_element(one)
    return {
        "diameter": getattr(element, "diameter", 0.0),
        "coil": getattr(element, "coil_diameter", 0.0),
        "coils": getattr(element, "turns", 0.0),
    }


def _list_slack(force: Sequence[float], rows: Sequence[int]) -> list[int]:
    """1 where an element hangs slack, which it does without any force."""
    least = 1e-9 * max(map(abs, force), default=0.0)
    return [int(force[row] <= least) for row in rows]


def _is_still(pictures: Sequence[Sequence[DrawingShape]], k: int) -> bool:
    points = pictures[0][k].points
    return all(shapes[k].points == points for shapes in pictures)


def _list_moving(shapes: Sequence[DrawingShape], still: Sequence[bool]) -> list[DrawingShape]:
    return [shape for shape, stands in zip(shapes, still, strict=True) if not stands]


def _flatten_points(shapes: Sequence[DrawingShape], quantum: float) -> list[int]:
    share = 1.0 / quantum
    return [round(x * share) for shape in shapes for point in shape.points for x in point]


def _choose_quantum(size: float) -> float:
    """A round length [m] that nobody sees in a picture of a size."""
    return 10.0 ** math.floor(math.log10(max(size, 1e-9) * FINENESS))


def _find_bounds(pictures: Sequence[Sequence[DrawingShape]]) -> tuple[Point, Point]:
    columns = list(zip(*(p for shapes in pictures for s in shapes for p in s.points), strict=True))
    if not columns:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    xs, ys, zs = columns
    return (min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs))
