"""How the numbers of a run follow from the controls of a form, measured on the builder of scenarios.

A control is set to other values of its slider, the scenario is built again, and every number that
became another one is told as a sum,

    e = e0 + Σ c_a Δg_a + Σ c_ab Δg_a Δg_b,   Δg_a = g_a(x_a) - g_a(x_a0),

with a function g of each control: its value, a power of it, or its inverse. What is fitted through
two values must hold at others, up to both ends of the range; where it does not, the range ends
earlier, or the control is left out. Two controls that some number follows from, or that a builder
may compare, are tried together; those that do not fit are kept apart.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from martensite.base.errors import MartensiteError
from martensite.base.parameters import describe_structure
from martensite.scenario.scenario import Scenario
from martensite_app.documents import build_packaged
from martensite_app.forms.form_types import NumberNode, ScenarioForm
from martensite_app.forms.sections import describe_scenario
from martensite_app.messages import JsonTable
from martensite_app.static_site.flat_inputs import DriveShape, list_inputs

SAME = 1e-12
"""Share of a number up to which it is the same."""
PARTS = (0.37, 0.001, 1.0, 0.61)
"""Where between the value and an end of its slider a control is tried; hardly changed, too."""
SHORTER = (1.0, 0.95, 0.75, 0.5, 0.25, 0.1)
"""Shares of the way to an end that are tried as the end of the range."""
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


class UnmappedError(Exception):
    """A change that the page cannot make by itself."""


@dataclass(eq=False)
class MappedControl:
    """A control, the range of its map, and what follows from it."""

    node: NumberNode
    value: float
    low: float = 0.0
    high: float = 0.0
    terms: dict[str, tuple[str, float]] = field(default_factory=dict[str, tuple[str, float]])
    """Name of a number -> function and coefficient."""
    tried: list[float] = field(default_factory=list[float])
    said: tuple[str, ...] = ()
    """Cautions that come with any change of it."""

    @property
    def path(self) -> str:
        """Of the control in the document."""
        return self.node["path"]

    def change(self, name: str, value: float) -> float:
        """The change of the function of which a number follows."""
        function = FUNCTIONS[self.terms[name][0]]
        return function(value) - function(self.value)


Pair = tuple[int, int]


@dataclass
class InputMap:
    """What is known of a scenario and its controls."""

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

    def predict(self, changes: Mapping[int, float]) -> dict[str, float]:
        """The numbers under changes of controls."""
        found, moved = dict(self.numbers), dict[str, dict[int, float]]()
        for k, value in changes.items():
            for name in self.controls[k].terms:
                moved.setdefault(name, {})[k] = self.controls[k].change(name, value)
        for name, steps in moved.items():
            total = self.numbers[name] + sum(self.controls[k].terms[name][1] * step for k, step in steps.items())
            for (a, x), (b, y) in itertools.combinations(sorted(steps.items()), 2):
                total += self.products.get((name, a, b), 0.0) * x * y
            found[name] = total
        return found


def measure_map(text: str) -> InputMap:
    """The map of a scenario."""
    return _Measurement(text).measure()


def list_numbers(form: ScenarioForm) -> Iterator[NumberNode]:
    """All controls of numbers in a form."""
    waiting: list[Any] = list(form["sections"])
    while waiting:
        one = waiting.pop(0)
        if one["sort"] == "number":
            yield cast("NumberNode", one)
        waiting[:0] = one.get("items", [])


class _Measurement:
    def __init__(self, text: str) -> None:
        self.text = text
        scenario = build_packaged(text)
        form = describe_scenario(scenario)
        found = list_inputs(scenario)
        numbers = {**found.numbers, **_list_shown(form)}
        self.map = InputMap(scenario, form, numbers, found.drives, found.samples)
        self.digest, self.structure = found.digest(), describe_structure(scenario.whole)
        self.said = self._list_said(scenario)

    def measure(self) -> InputMap:
        made = self.map
        for node in list_numbers(made.form):
            try:
                made.controls.append(self._measure_control(node))
            except UnmappedError as error:
                made.left_out[node["path"]] = str(error)
        for a, b in itertools.combinations(range(len(made.controls)), 2):
            self._measure_pair(a, b)
        return made

    def build(self, changes: Sequence[tuple[NumberNode, float]], shown: bool = False) -> dict[str, float]:
        """The numbers under changes of controls; with those that the form shows if they are asked for."""
        settings: JsonTable = {node["path"]: write_quantity(node, value) for node, value in changes}
        try:
            scenario = build_packaged(self.text, settings)
            found = list_inputs(scenario, self.map.drives)
        except (MartensiteError, ArithmeticError, ValueError) as error:
            raise UnmappedError(f"at {settings}: {error}") from None
        if describe_structure(scenario.whole) != self.structure:
            raise UnmappedError("it changes the structure")
        if found.digest() != self.digest:
            raise UnmappedError("it changes readings of a signal")
        said = self._list_said(scenario)
        if said != self.said:
            raise UnmappedError("it changes what is said of the scenario")
        cautions = [one for one in scenario.cautions if one not in self.map.scenario.cautions]
        if not set(scenario.cautions) >= set(self.map.scenario.cautions):
            raise UnmappedError("it changes the cautions")
        self.cautions = tuple(cautions)
        return {**found.numbers, **(_list_shown(describe_scenario(scenario)) if shown else {})}

    def _list_said(self, scenario: Scenario) -> Any:
        return scenario.whole.description(), scenario.title, scenario.restart_at, scenario.seed

    def _measure_control(self, node: NumberNode) -> MappedControl:
        slider, value = node["slider"], node["value"]
        if slider is None or value is None:
            raise UnmappedError("it has no slider")
        control = MappedControl(node, value, value, value)
        rows: list[tuple[float, dict[str, float]]] = []
        for end in (slider["high"], slider["low"]):
            rows += self._explore(control, end)
        if not rows:
            raise UnmappedError(self.reason)
        return control

    def _explore(self, control: MappedControl, end: float) -> list[tuple[float, dict[str, float]]]:
        """Numbers on the way to one end of the slider, as far as the map holds."""
        for share in SHORTER:
            values = [self._choose_value(control, end, share * part) for part in PARTS]
            values = list(dict.fromkeys(x for x in values if x != control.value))
            if not values:
                return []
            try:
                shown = not control.terms
                rows = list[tuple[float, dict[str, float]]]()
                for x in values:
                    rows.append((x, self.build([(control.node, x)], shown)))
                    if self.cautions != control.said and (control.tried or len(rows) > 1):
                        raise UnmappedError("it changes the cautions")
                    control.said = self.cautions
                self._fit(control, rows)
            except UnmappedError as error:
                self.reason = str(error)
                continue
            control.tried += values
            reached = max(values, key=lambda x: abs(x - control.value))
            control.low, control.high = min(control.low, reached), max(control.high, reached)
            return rows
        return []

    def _choose_value(self, control: MappedControl, end: float, share: float) -> float:
        """A value of a share of the way to an end."""
        slider, value = control.node["slider"], control.value
        log = slider is not None and slider["log"] and value > 0.0 and end > 0.0
        found = value * (end / value) ** share if log else value + share * (end - value)
        if slider is not None and slider["whole"]:
            return float(round(found))
        how = control.node
        return _read_shown(how, float(f"{found * how['factor'] + how['offset']:.6g}"))

    def _fit(self, control: MappedControl, rows: Sequence[tuple[float, Numbers]]) -> None:
        """Terms of all numbers that moved; those there are must hold."""
        before, terms = self.map.numbers, dict(control.terms)
        for name in dict.fromkeys(n for _, row in rows for n in row if not _is_same(row[n], before[n])):
            if name not in terms:
                if control.tried or control.terms:
                    raise UnmappedError(f"`{name}` follows from it on one side only")
                terms[name] = self._choose_function(control, name, rows)
        trial = MappedControl(control.node, control.value, terms=terms)
        for x, row in rows:
            for name, (_, slope) in terms.items():
                if name in row and not _is_same(before[name] + slope * trial.change(name, x), row[name]):
                    raise UnmappedError(f"`{name}` is no simple function of it")
        control.terms = terms

    def _choose_function(
        self, control: MappedControl, name: str, rows: Sequence[tuple[float, Numbers]]
    ) -> tuple[str, float]:
        before, (at, row) = self.map.numbers[name], rows[0]
        positive = control.value > 0.0 and all(x > 0.0 for x, _ in rows)
        for word, function in FUNCTIONS.items():
            if word not in ("x", "x2", "x3") and not positive:
                continue
            slope = (row[name] - before) / (function(at) - function(control.value))
            if not math.isfinite(slope):
                continue
            slope = float(round(slope)) if abs(slope - round(slope)) < SAME * abs(slope) else slope
            others = (before + slope * (function(x) - function(control.value)) for x, _ in rows)
            if all(_is_same(x, one[name]) for x, (_, one) in zip(others, rows, strict=True)):
                return word, slope
        raise UnmappedError(f"`{name}` is no simple function of it")

    def _measure_pair(self, a: int, b: int) -> None:
        one, two = self.map.controls[a], self.map.controls[b]
        shared = sorted(set(one.terms) & set(two.terms))
        likely = one.node["unit"] == two.node["unit"] and _is_near(one.path, two.path)
        if one.said and two.said:  # they might be one sentence then
            self.map.apart.add((a, b))
        if not (shared or likely):
            return
        try:
            if shared:
                self._fit_products(a, b, shared)
            for x, y in itertools.product((one.low, one.high), (two.low, two.high)):
                if x != one.value and y != two.value:
                    self._check_pair(a, b, x, y)
        except UnmappedError:
            self.map.apart.add((a, b))

    def _fit_products(self, a: int, b: int, shared: Sequence[str]) -> None:
        made = self.map
        x, y = made.controls[a].tried[0], made.controls[b].tried[0]
        row = self.build([(made.controls[a].node, x), (made.controls[b].node, y)], any("form:" in n for n in shared))
        found = made.predict({a: x, b: y})
        for name in shared:
            missing = row.get(name, found[name]) - found[name]
            if not _is_same(row.get(name, found[name]), found[name]):
                own = made.controls[a].change(name, x) * made.controls[b].change(name, y)
                made.products[name, a, b] = missing / own

    def _check_pair(self, a: int, b: int, x: float, y: float) -> None:
        made = self.map
        row = self.build([(made.controls[a].node, x), (made.controls[b].node, y)])
        found = made.predict({a: x, b: y})
        if self.cautions != (*made.controls[a].said, *made.controls[b].said):
            raise UnmappedError("both together change the cautions")
        wrong = [name for name, value in row.items() if not _is_same(found[name], value, 10.0)]
        if wrong:
            raise UnmappedError(f"`{wrong[0]}` follows from both otherwise")


def _is_near(one: str, two: str) -> bool:
    """Whether two paths end in the same part, or in parts of the same one."""
    a, b = one.split("."), two.split(".")
    return a[:-1] == b[:-1] or (len(a) > 1 and len(b) > 1 and (a[:-2] or a[:1]) == (b[:-2] or b[:1]))


def _is_same(one: float, other: float, slack: float = 1.0) -> bool:
    return one == other or abs(one - other) <= slack * SAME * max(abs(one), abs(other))


def _list_shown(form: ScenarioForm) -> dict[str, float]:
    shown = ((f"form:{node['path']}", node["value"]) for node in list_numbers(form))
    return {name: value for name, value in shown if value is not None}


def write_quantity(node: NumberNode, value: float) -> str | float:
    """A value in SI as the page sends it."""
    shown = value * node["factor"] + node["offset"]
    number = float(f"{shown:.15g}")
    if node["slider"] is not None and node["slider"]["whole"]:
        return round(number)
    return f"{number!r} {node['shown']}" if node["shown"] else number


def _read_shown(node: NumberNode, shown: float) -> float:
    return (shown - node["offset"]) / node["factor"]
