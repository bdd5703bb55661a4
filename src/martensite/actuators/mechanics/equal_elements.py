"""Steps of equal elements in one loop, traced once for any number of them.

Equal elements have one structure (class, law, options), also of environment and source; parameters may differ.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from martensite.actuators.elements.base import Heating, Pull, Spring
from martensite.actuators.mechanisms.base import Load
from martensite.base.parameters import Parametrised, describe_structure
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.physics.laws.coupling import StepReport

LEAST_ELEMENTS = 3
"""Smallest number of elements for a loop, which cannot precompute with constant parameters."""


class LoadLineEquation(NamedTuple):
    """α (e - e*) + β (F - F*) = g: the rest of the system for an element."""

    alpha: Scalar
    beta: Scalar
    offset: Scalar
    elongation: Scalar
    force: Scalar

    def pull(self) -> Pull:
        """Return the force at which a spring meets the line; never below zero."""

        def meet(xp: Namespace, spring: Spring) -> Scalar:
            above = self.alpha * (self.elongation - spring.free) + self.beta * self.force
            below = self.alpha * spring.compliance + self.beta
            return xp.maximum((above + self.offset) / below, 0.0)

        return meet


class ElementResponse(NamedTuple):
    """Response of an element on its load line."""

    state: Any
    force: Scalar
    spring: Spring
    report: StepReport


def answer_loads(
    xp: Namespace, loads: Sequence[Load], lines: Sequence[LoadLineEquation], dt: Scalar
) -> list[ElementResponse]:
    """Return the step of each element on its own line, in the order of the loads."""
    responses: dict[int, ElementResponse] = {}
    for places in group_alike([_list_parts(one) for one in loads]):
        first = loads[places[0]]
        if len(places) < LEAST_ELEMENTS:
            responses |= {i: _answer_load(xp, loads[i], lines[i], dt) for i in places}
            continue
        shape = NestedShape(ElementResponse(first.state, 0.0, Spring(0.0, 0.0), StepReport(0.0, 0.0)))

        def row(*numbers: Scalar, first: Load = first) -> list[Scalar]:
            line, load = LoadLineEquation(*numbers[:5]), _rebuild_load(first, numbers[5:])
            return flatten_numbers(_answer_load(xp, load, line, dt))

        rows = [[*lines[i], *_list_numbers(loads[i])] for i in places]
        columns = xp.each(row, *zip(*rows, strict=True))
        for i, numbers in zip(places, zip(*columns, strict=True), strict=True):
            responses[i] = shape.rebuild(numbers)
    return [responses[i] for i in range(len(loads))]


def _answer_load(xp: Namespace, load: Load, line: LoadLineEquation, dt: Scalar) -> ElementResponse:
    element, state, heating = load
    after, report = element.advance(xp, state, heating, line.pull(), dt)
    force = element.force(after)
    return ElementResponse(after, force, element.tangent(xp, after, force), report)


def group_alike(rows: Sequence[tuple[Parametrised, ...]]) -> Iterable[list[int]]:
    """Return the places of rows whose parts have one structure, by group."""
    groups: dict[Any, list[int]] = {}
    for place, parts in enumerate(rows):
        groups.setdefault(tuple(describe_structure(part) for part in parts), []).append(place)
    return groups.values()


def _list_parts(load: Load) -> tuple[Parametrised, ...]:
    return load.element, load.heating.environment, load.heating.source


def _list_numbers(load: Load) -> list[Scalar]:
    """Return all values that may differ between loads of one structure."""
    values = [leaf.value for part in _list_parts(load) for leaf in part.leaves()]
    heating = load.heating
    return [*values, *flatten_numbers(heating.drive), heating.owed, *flatten_numbers(load.state)]


def _rebuild_load(first: Load, numbers: Sequence[Scalar]) -> Load:
    """Return the load of the same structure with these values."""
    rest = iter(numbers)
    element, environment, source = (
        part.rebuilt({leaf.path: next(rest) for leaf in part.leaves()}) for part in _list_parts(first)
    )
    drive = NestedShape(first.heating.drive).rebuild([next(rest) for _ in flatten_numbers(first.heating.drive)])
    heating = Heating(environment, source, drive, next(rest))  # type: ignore[arg-type]
    return Load(element, NestedShape(first.state).rebuild(list(rest)), heating)  # type: ignore[arg-type]
