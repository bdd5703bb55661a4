"""Scene of the page: shapes of the mechanism as formulas of its outputs and of all parameters.

An element is drawn as a wire or as a coil.
"""

from __future__ import annotations

from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.lengths import record_lengths
from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.mechanisms.drawing import NEWTON, DrawingShape, DrawingState
from martensite.app.messages import JsonTable
from martensite.app.views.formulas import Formulas, rebuild_recorded
from martensite.simulate.result import Result

SHOWN = ("temperature", "martensite_fraction", "force", "stress")
TURNING = ("pulley", "rotor")
"""Kinds of shapes that turn."""
NOT_RECORDED = (
    "The drawing of `{}` needs the value of a traced number: in `draw_shapes` use the functions of "
    "`martensite.kernels.recordable_numbers.xp`, such as `xp.cos` and `xp.maximum`."
)


def describe_shapes(whole: AbstractSystem, result: Result) -> JsonTable:
    """Return the drawing of the mechanism, or a sentence if it cannot be recorded."""
    table = Formulas()
    system, columns = rebuild_recorded(whole, table), result.columns
    outputs: Any = {name: table.leaf("y", name, columns[name][0]) for name in system.mechanism.outputs()}
    ports = {port: {name: system.label(port, name) for name in SHOWN} for port in system.actuators()}
    labels = {port: whole.label(port, "strain") for port in whole.actuators()}
    strains: Any = {port: table.leaf("first", name, columns[name][0]) for port, name in labels.items()}
    try:
        lengths = record_lengths(whole, columns, system, strains)
        shapes = system.mechanism.draw_shapes(DrawingState(outputs, lengths))
    except TypeError:
        sentence = NOT_RECORDED.format(system.mechanism.registered_name)
        return {"rows": [], "choices": [], "shapes": [], "ports": ports, "newton": NEWTON, "sentence": sentence}
    columns = table.collect(shapes=[_record_shape(shape, system) for shape in shapes])
    return columns | {"ports": ports, "newton": NEWTON, "sentence": ""}


def _record_shape(shape: DrawingShape, system: AbstractSystem) -> JsonTable:
    element = _describe_element(system.actuators()[shape.port].element) if shape.port else {}
    return {
        "name": shape.name,
        "kind": shape.kind,
        "size": shape.size,
        "points": shape.points,
        "turn": shape.turn if shape.kind in TURNING else None,
        "port": shape.port or None,
        "mass": shape.mass,
        **element,
    }


def _describe_element(element: AbstractElement) -> JsonTable:
    one = getattr(element, "one", None)
    if isinstance(one, AbstractElement):
        return _describe_element(one)
    return {
        "diameter": getattr(element, "diameter", 0.0),
        "coil": getattr(element, "coil_diameter", 0.0),
        "coils": getattr(element, "turns", 0.0),
    }
