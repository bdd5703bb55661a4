"""Every registered mechanism is drawn as its kinematics say.

Sources of truth: the elongation of elastic elements in runs, which no drawing knows, and the list
of kinds. Drawings only place what the coordinates of a run give.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest
from builders import FunctionWaveform, examples, label
from elastic import REST, SURROUNDINGS, Elastic
from page_runs import draw_row

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.actuators.mechanisms.beam_siblings import BeamHarvester, BeamMotors
from martensite.actuators.mechanisms.drawing import (
    KINDS,
    DrawingShape,
    DrawingState,
    lead_wire,
    measure_length,
    trace_arc,
)
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.app.views.scene import describe_shapes
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.simulate.api import simulate

NATURAL = 0.25
"""Length of the elements of the tests at zero elongation [m]."""
AGREES = 1e-6
"""Share of its length by which a drawn wire may be wrong."""
KEPT = dict.fromkeys(
    (BeamMotor, BeamMotors, BeamHarvester),
    "its path is the length of the wire, whatever the element's: changes are compared",
)
"""Mechanisms whose geometry says how long a path is."""


class Long(Elastic):
    """An elastic element that has a length."""

    length: ClassVar[float] = NATURAL


class Pictures:
    """A run of a mechanism with elastic elements, drawn at all of its samples."""

    def __init__(self, mechanism: AbstractMechanism) -> None:
        self.ports = mechanism.ports()
        one = Actuator(element=Long(compliance=5e-4), environment=SURROUNDINGS, source=PrescribedTemperature())
        self.system = Machine(mechanism=mechanism, group=Group(**dict.fromkeys(mechanism.ports(), one)))
        drives = {name: wave(1.0, 0.0) for name in mechanism.signals()} | {
            self.system.drive_at(p): wave(2.0 if k % 2 == 0 else 0.0, REST) for k, p in enumerate(mechanism.ports())
        }
        self.result = simulate(self.system, drives, 0.032, step=1e-3, samples=9, runtime="floats")
        self.rows = [draw_row(self.system, self.result, k) for k in range(9)]

    def wire(self, port: str) -> list[float]:
        """Drawn length [m] of the element at a port, over time."""
        found = [[s for s in shapes if s.port == port] for shapes in self.rows]
        return [measure_length(wire.points) for (wire,) in found]

    def element(self, port: str) -> list[float]:
        """Its length in the run [m]: the `strain` of the tests' element is its elongation."""
        return [NATURAL + elongation for elongation in self.result[f"{port}.strain"]]


def wave(high: float, rest: float) -> FunctionWaveform:
    return FunctionWaveform(function=lambda t: rest + 0.5 * high * (1.0 - math.cos(2.0 * math.pi * t / 0.1)))


# ---------------------------------------------------------------- what is promised


def shapes_are_sound(pictures: Pictures) -> None:
    """Names of their own, kinds that are known, finite places; and the same shapes all the time."""
    first = pictures.rows[0]
    assert len({shape.name for shape in first}) == len(first) > 0
    for shapes in pictures.rows:
        assert [(s.name, s.kind, len(s.points), s.port) for s in shapes] == [
            (s.name, s.kind, len(s.points), s.port) for s in first
        ]
        for shape in shapes:
            numbers = [x for point in shape.points for x in point]
            assert shape.kind in KINDS, shape
            assert shape.size >= 0.0, shape
            assert len(numbers) == 3 * len(shape.points) > 0, shape
            assert all(map(math.isfinite, (*numbers, shape.size, shape.turn))), shape


def elements_are_drawn(pictures: Pictures) -> None:
    """Every element once, as a wire."""
    wires = [shape for shape in pictures.rows[0] if shape.kind == "wire"]
    assert sorted(shape.port for shape in wires) == sorted(pictures.ports)
    assert not [s for s in pictures.rows[0] if s.port and s.kind != "wire"]


def wires_are_as_long_as_elements(pictures: Pictures) -> None:
    """At every sample at which they are taut."""
    for port in pictures.ports:
        force = pictures.result[f"{port}.force"]
        wire, element = pictures.wire(port), pictures.element(port)
        taut = [k for k in range(len(force)) if force[k] > 0.0]
        assert taut
        more = 0.0
        if type(pictures.system.mechanism) in KEPT:
            more = wire[taut[0]] - element[taut[0]]
        for k in taut:
            assert wire[k] == pytest.approx(element[k] + more, rel=AGREES), (port, k)


def something_moves(pictures: Pictures) -> None:
    """As the coordinate does."""
    moved = max(pictures.result[pictures.result.coordinate], key=abs)
    first, *others = pictures.rows
    changes = [
        math.dist(p, q)
        for shapes in others
        for a, b in zip(first, shapes, strict=True)
        for p, q in zip(a.points, b.points, strict=True)
    ]
    assert moved != 0.0
    assert max(changes) > 1e-7


def page_can_draw_it(pictures: Pictures) -> None:
    """Its drawing is recorded as formulas, which asks for no value of a number."""
    assert describe_shapes(pictures.system, pictures.result)["sentence"] == ""


CHECKS: list[Callable[[Pictures], None]] = [
    shapes_are_sound,
    elements_are_drawn,
    wires_are_as_long_as_elements,
    something_moves,
    page_can_draw_it,
]


def one_each() -> list[AbstractMechanism]:
    """Examples of all mechanisms; of those that differ in their motion alone, the first."""
    found: dict[Any, AbstractMechanism] = {}
    for one in examples("mechanism"):
        options = [
            (name, getattr(one, name))
            for name in one.declarations
            if isinstance(getattr(one, name), str) and name not in ("motion", "coupling")
        ]
        found.setdefault((type(one), *options), one)
    return list(found.values())


@cache
def pictures_of(place: int) -> Pictures:
    return Pictures(ALL[place])


ALL = one_each()


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("place", range(len(ALL)), ids=[label(one) for one in ALL])
def test_it_is_drawn_as_it_is(place: int, check: Callable[[Pictures], None]) -> None:
    check(pictures_of(place))


# ---------------------------------------------------------------- mechanisms from outside


class Silent(AntagonisticPulley):
    """Says nothing of how it looks; not registered."""

    drawn = AbstractMultibody.draw_shapes


class SilentWeight(DeadWeight):
    """Likewise, with one coordinate and no path."""

    drawn = AbstractMechanism.draw_shapes


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize(
    "mechanism",
    [Silent(radius=8e-3, preload=1.0, stiffness=0.01), SilentWeight(mass=1.0)],
    ids=lambda one: type(one).__name__,
)
def test_one_that_says_nothing_is_drawn_too(mechanism: AbstractMechanism, check: Callable[[Pictures], None]) -> None:
    check(Pictures(mechanism))


# ---------------------------------------------------------------- what drawings are made with


@pytest.mark.parametrize("last", [0.0, 0.4, 3.0, -2.0])
def test_an_arc_is_as_long_as_that_of_the_circle(last: float) -> None:
    points = [(x, 0.0, z) for x, z in trace_arc(0.01, 0.3, 0.3 + last, 8)]
    assert measure_length(points) == pytest.approx(0.01 * abs(last), rel=1e-12)


@pytest.mark.parametrize("rest", [0.05, 0.0, -0.03, -0.12])
def test_a_wire_is_as_long_as_it_is_meant(rest: float) -> None:
    path = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, 0.0, 0.2)]
    shapes = lead_wire("element", path, rest, (-1.0, 0.0, 0.0))
    (wire,) = [shape for shape in shapes if shape.kind == "wire"]
    assert measure_length(wire.points) == pytest.approx(0.3 + rest, rel=1e-12)
    assert wire.points[-1] == path[-1]


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, -40.0])
def test_the_unbalance_is_drawn_where_it_is(angle: float) -> None:
    """At x + r sin φ, by the equations of the motor; the arm turns about the rotor's axis."""
    (motor,) = [one for one in ALL if isinstance(one, BeamMotor) and not one.ports()][:1]
    shapes = motor.draw_shapes(DrawingState({"displacement": 0.01, "rotor_angle": angle}, {}))
    (rotor,) = [shape for shape in shapes if shape.kind == "rotor"]
    first, last, mass = map(np.array, rotor.points)
    axis = (last - first) / np.linalg.norm(last - first)
    arm = mass - last
    turned = arm * math.cos(rotor.turn) + np.cross(axis, arm) * math.sin(rotor.turn)
    assert (last + turned)[2] == pytest.approx(0.01 + motor.eccentricity * math.sin(angle))


# ---------------------------------------------------------------- the checks can fail


def spoiled(change: Callable[[DrawingShape, Mapping[str, float]], DrawingShape]) -> AbstractMechanism:
    """A dead weight whose shapes are changed as they are drawn."""

    class Spoiled(DeadWeight):
        def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
            return [change(shape, reading.outputs) for shape in super().draw_shapes(reading)]

    return Spoiled(mass=1.0)


def no_place(shape: DrawingShape, outputs: Mapping[str, float]) -> DrawingShape:
    return shape._replace(points=((math.nan, 0.0, 0.0), *shape.points[1:]))


def no_port(shape: DrawingShape, outputs: Mapping[str, float]) -> DrawingShape:
    return shape._replace(port="")


def too_long(shape: DrawingShape, outputs: Mapping[str, float]) -> DrawingShape:
    x, y, z = shape.points[-1]
    return shape._replace(points=(*shape.points[:-1], (x, y, z - 1e-3 * outputs["position"])))


def frozen(shape: DrawingShape, outputs: Mapping[str, float]) -> DrawingShape:
    return shape._replace(points=tuple((0.0, 0.0, float(k)) for k in range(len(shape.points))))


def valued(shape: DrawingShape, outputs: Mapping[str, float]) -> DrawingShape:
    return shape._replace(size=abs(math.sin(outputs["position"])))


@pytest.mark.parametrize(
    ("change", "check"),
    list(zip((no_place, no_port, too_long, frozen, valued), CHECKS, strict=True)),
    ids=lambda one: one.__name__,
)
def test_a_wrong_drawing_is_noticed(change: Any, check: Callable[[Pictures], None]) -> None:
    pictures = Pictures(spoiled(change))
    with pytest.raises(AssertionError):
        check(pictures)
