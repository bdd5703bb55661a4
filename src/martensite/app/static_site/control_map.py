"""Map from the values of controls to the numbers of a run, and its functions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from martensite.app.forms.form_types import NumberNode, ScenarioForm
from martensite.app.static_site.flat_inputs import DriveShape
from martensite.app.static_site.number_rows import NumberRow
from martensite.scenario.scenario import Scenario

SAME = 1e-12
"""Share of a number up to which it is the same."""
ROUNDING_TOLERANCE = 8.0 * 2.0**-52
"""Share of its terms that a sum is rounding, and 0."""
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "x": lambda x: x,
    "1/x": lambda x: 1.0 / x,
    "x2": lambda x: x * x,
    "root": math.sqrt,
    "x3": lambda x: x * x * x,
    "1/x2": lambda x: 1.0 / (x * x),
    "x4": lambda x: x * x * x * x,
    "1/root": lambda x: 1.0 / math.sqrt(x),
}
Numbers = Mapping[str, float]
Row = tuple[float, Numbers]


@dataclass(eq=False)
class MappedControl:
    """A control, the range of its map, and what follows from it."""

    node: NumberNode
    value: float
    low: float = 0.0
    high: float = 0.0
    terms: dict[str, tuple[str, float]] = field(default_factory=dict[str, tuple[str, float]])
    """Name of a number -> function and coefficient."""
    rows: list[Row] = field(default_factory=list[Row])
    """Values that were tried, and the numbers that came of them."""
    cautions: tuple[str, ...] = ()
    """Cautions that come with any change of it."""

    @property
    def path(self) -> str:
        """Return the path of the control in the document."""
        return self.node["path"]

    def change(self, name: str, value: float) -> float:
        """Return the change of the function of which a number follows."""
        function = FUNCTIONS[self.terms[name][0]]
        return function(value) - function(self.value)


Pair = tuple[int, int]


def invert(value: float, inverted: bool) -> float:
    """Return a number, or its inverse."""
    return (1.0 / value if value else math.inf) if inverted else value


@dataclass
class InputMap:
    """Map of a scenario and its controls."""

    scenario: Scenario
    form: ScenarioForm
    numbers: dict[str, float]
    drives: list[DriveShape]
    samples: list[Any]
    controls: list[MappedControl] = field(default_factory=list[MappedControl])
    left_out: dict[str, str] = field(default_factory=dict[str, str])
    """Path of a control that needs the server, and why."""
    products: dict[tuple[str, int, int], float] = field(default_factory=dict[tuple[str, int, int], float])
    """Coefficients of products, by number and both controls."""
    apart: set[Pair] = field(default_factory=set[Pair])
    ordered: set[Pair] = field(default_factory=set[Pair])
    """Pairs that may be changed together as long as the first stays below the second."""
    inverted: set[str] = field(default_factory=set[str])
    """Numbers of which the inverse is such a sum."""
    rows: list[NumberRow] = field(default_factory=list[NumberRow])

    def predict(self, changes: Mapping[int, float]) -> dict[str, float]:
        """Return the numbers under changes of controls."""
        numbers, moved = dict(self.numbers), dict[str, dict[int, float]]()
        for k, value in changes.items():
            for name in self.controls[k].terms:
                moved.setdefault(name, {})[k] = self.controls[k].change(name, value)
        for name, steps in moved.items():
            inverted = name in self.inverted
            begin = invert(self.numbers[name], inverted)
            parts = [begin, *(self.controls[k].terms[name][1] * step for k, step in steps.items())]
            for (a, x), (b, y) in itertools.combinations(sorted(steps.items()), 2):
                parts.append(self.products.get((name, a, b), 0.0) * x * y)
            total = sum(parts)
            is_rounding = not inverted and abs(total) <= ROUNDING_TOLERANCE * sum(map(abs, parts))
            numbers[name] = 0.0 if is_rounding else invert(total, inverted)
        return numbers


def is_same(one: float, other: float, slack: float = 1.0) -> bool:
    """Test whether two numbers are equal within a multiple of `SAME`."""
    return one == other or abs(one - other) <= slack * SAME * max(abs(one), abs(other))


def write_quantity(node: NumberNode, value: float) -> str | float:
    """Return a value in SI as the page sends it."""
    display_value = value * node["factor"] + node["offset"]
    number = float(f"{display_value:.15g}")
    if node["slider"] is not None and node["slider"]["whole"]:
        return round(number)
    return f"{number!r} {node['display_unit']}" if node["display_unit"] else number


def read_shown(node: NumberNode, display_value: float) -> float:
    """Return a value in SI from one in the unit of the page."""
    return (display_value - node["offset"]) / node["factor"]
