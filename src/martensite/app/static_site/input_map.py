"""Map from the controls of a form to the numbers of a run, measured on the builder of scenarios.

A control is set to other values of its slider, the scenario is built again, and every changed number is written as a
sum,

    e = e0 + Σ c_a Δg_a + Σ c_ab Δg_a Δg_b,   Δg_a = g_a(x_a) - g_a(x_a0),

with a function g of each control: its value, a power of it, or its inverse; if the inverse of a number is such a sum,
as for resistances in series, the inverse is used. A function fitted through two values must hold at others, up to both
ends of the range; otherwise the range ends earlier, or the control is left out. Two controls that affect the same
number, or that a builder may compare, are tried together. A row of numbers has one control for each.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, cast

from martensite.app.documents import build_packaged
from martensite.app.forms.form_types import NumberNode, ScenarioForm
from martensite.app.forms.sections import describe_scenario
from martensite.app.messages import JsonTable
from martensite.app.static_site.control_map import (
    FUNCTIONS,
    SAME,
    InputMap,
    MappedControl,
    Pair,
    invert,
    is_same,
    read_shown,
    write_quantity,
)
from martensite.app.static_site.flat_inputs import list_inputs
from martensite.app.static_site.number_rows import NumberRow, list_rows, read_row
from martensite.base.errors import MartensiteError
from martensite.base.parameters import describe_structure
from martensite.scenario.scenario import Scenario

SHORTER = (1.0, 0.95, 0.75, 0.5, 0.25, 0.1)
"""Shares of the way to an end that are tried as the end of the range."""
SMALLEST_SHIFT = 0.001
"""Smallest step of a slider, as a fraction of its travel: a refused control is refused already there."""
PATTERNS = ((0.0, 1.0), (1.0, 0.0), (1.0,), (0.1, 0.9, 0.4, 0.75, 0.3))
"""Shares of the way from the low to the high end, by turns, at which a row is tried."""
NARROW, WITHIN = 0.02, (0.05, 0.5, 0.93)
"""Spacing of two ordered numbers in a trial, and its positions, as fractions of their common range."""
TOGETHER = 8
"""So many trials are made in one."""


class UnmappedError(Exception):
    """A change that the page cannot make by itself."""


def measure_map(text: str, only: Collection[str] | None = None) -> InputMap:
    """Return the map of a scenario, of all controls or of those at some paths."""
    return _Measurement(text).measure(only)


def list_numbers(form: ScenarioForm) -> Iterator[NumberNode]:
    """Yield all controls of numbers in a form."""
    waiting: list[Any] = list(form["sections"])
    while waiting:
        one = waiting.pop(0)
        if one["sort"] == "number":
            yield cast("NumberNode", one)
        waiting[:0] = one.get("items", [])


class _Measurement:
    """Builds a scenario again and again."""

    reason = ""
    """Why the last trial failed."""

    def __init__(self, text: str) -> None:
        self.text = text
        scenario = build_packaged(text)
        inputs = list_inputs(scenario)
        self.map = InputMap(scenario, describe_scenario(scenario), inputs.numbers, inputs.drives, inputs.samples)
        self.digest, self.structure = inputs.digest(), describe_structure(scenario.whole)
        self.fixed_entries = self._list_fixed_entries(scenario)
        self.cautions: tuple[str, ...] = ()

    def measure(self, only: Collection[str] | None) -> InputMap:
        input_map = self.map
        nodes = [one for one in list_numbers(input_map.form) if only is None or one["path"] in only]
        for node in nodes:
            try:
                input_map.controls.append(self._begin_control(node))
            except UnmappedError as error:
                input_map.left_out[node["path"]] = str(error)
        self._reach_ends()
        for a, b in itertools.combinations(range(len(input_map.controls)), 2):
            self._multiply(a, b)
        self._try_pairs()
        for row in list_rows(input_map.form):
            if only is None or row["path"] in only:
                try:
                    self._map_row(read_row(row))
                except (UnmappedError, MartensiteError, ValueError) as error:
                    input_map.left_out[row["path"]] = str(error)
        return input_map

    def build(self, changes: Sequence[tuple[NumberNode, float]]) -> dict[str, float]:
        """Return the numbers under changes of controls."""
        settings = self._write_settings(changes)
        try:
            scenario = build_packaged(self.text, settings)
            inputs, cautions = list_inputs(scenario, self.map.drives), scenario.cautions
        except (MartensiteError, ArithmeticError, ValueError) as error:
            raise UnmappedError(f"at {settings}: {error}") from None
        if describe_structure(scenario.whole) != self.structure:
            raise UnmappedError("it changes the structure")
        if inputs.digest() != self.digest:
            raise UnmappedError("it changes readings of a signal")
        stated = self._list_fixed_entries(scenario)
        if stated != self.fixed_entries:
            raise UnmappedError("it changes what is said of the scenario")
        if not set(cautions) >= set(base_cautions := self.map.scenario.cautions):
            raise UnmappedError("it changes the cautions")
        self.cautions = tuple(one for one in cautions if one not in base_cautions)
        return inputs.numbers

    def _write_settings(self, changes: Sequence[tuple[NumberNode, float]]) -> JsonTable:
        """Return the entries to set in the document; a row is set as a whole."""
        table: JsonTable = {node["path"]: write_quantity(node, value) for node, value in changes}
        for row in self.map.rows:
            moved = {one["path"]: table.pop(one["path"]) for one in row.items if one["path"] in table}
            if moved:
                listed = zip(row.items, row.entries, strict=True)
                table[row.path] = [moved.get(node["path"], entry) for node, entry in listed]
        return table

    def _list_fixed_entries(self, scenario: Scenario) -> Any:
        return scenario.whole.description(), scenario.title, scenario.restart_at, scenario.seed

    def check(self, changes: Mapping[int, float]) -> None:
        """Raise `UnmappedError` where the map does not say what is built."""
        input_map = self.map
        row = self.build([(input_map.controls[k].node, value) for k, value in changes.items()])
        predicted = input_map.predict(changes)
        moved = [input_map.controls[k] for k, value in changes.items() if value != input_map.controls[k].value]
        if self.cautions != tuple(caution for one in moved for caution in one.cautions):
            raise UnmappedError("it changes the cautions")
        wrong = [name for name, value in row.items() if not is_same(predicted[name], value, 10.0)]
        if wrong:
            raise UnmappedError(f"`{wrong[0]}` is no simple function of it")

    def _name_kind(self, number: int) -> str:
        """Return the common kind of controls that a builder may compare, such as the ends of a range."""
        node = self.map.controls[number].node
        return node["path"].rpartition(".")[0] if node["unit"] in (None, "1") else str(node["unit"])

    def sort_out(self, trials: Sequence[Mapping[int, float]]) -> list[int]:
        """Return the failing trials.

        Trials of controls that are not compared with each other run together, and in halves after a failure.
        """
        failed, waiting = list[int](), [list(range(len(trials)))]
        while waiting:
            group = waiting.pop()
            together, later, used = list[int](), list[int](), set[str]()
            for number in group:
                kinds = {self._name_kind(k) for k in trials[number]}
                fits = len(together) < TOGETHER and not used & kinds
                (together if fits else later).append(number)
                used |= kinds if fits else set()
            if later:
                waiting.append(later)
            try:
                self.check({k: value for number in together for k, value in trials[number].items()})
            except UnmappedError as error:
                half = len(together) // 2
                if half:
                    waiting += [together[:half], together[half:]]
                else:
                    self.reason = str(error)
                    failed += together
        return failed

    def _begin_control(self, node: NumberNode) -> MappedControl:
        """Return a control with the functions of what follows from it, from two values beside its own."""
        slider, value = node["slider"], node["value"]
        if slider is None or value is None:
            raise UnmappedError("it has no slider")
        control = MappedControl(node, value, value, value)
        reason = "its slider has no way"
        for end, share in itertools.product((slider["high"], slider["low"]), (0.37, 0.05)):
            values = dict.fromkeys(self._choose_value(control, end, share * part) for part in (1.0, 0.3))
            values.pop(value, None)
            if not values:
                continue
            try:
                control.rows = [(x, self.build([(node, x)])) for x in values]
                self._fit(control)
            except UnmappedError as error:
                reason = str(error)
                continue
            control.cautions = self.cautions
            return control
        raise UnmappedError(reason)

    def _choose_value(self, control: MappedControl, end: float, share: float) -> float:
        slider, value = control.node["slider"], control.value
        log = slider is not None and slider["log"] and value > 0.0 and end > 0.0
        chosen = value * (end / value) ** share if log else value + share * (end - value)
        if slider is not None and slider["whole"]:
            return float(round(chosen))
        how = control.node
        return read_shown(how, float(f"{chosen * how['factor'] + how['offset']:.6g}"))

    def _fit(self, control: MappedControl) -> None:
        """Functions of all numbers that moved."""
        before = self.map.numbers
        moved = dict.fromkeys(n for _, row in control.rows for n, x in row.items() if not is_same(x, before[n]))
        control.terms = {name: self._find_function(control, name) for name in moved}

    def _find_function(self, control: MappedControl, name: str) -> tuple[str, float]:
        """Return the function of a number of a control; if only its inverse is simple, use it for all controls."""
        inverted = name in self.map.inverted
        candidate = self._choose_function(control, name, inverted)
        if candidate is None and not inverted:
            candidate = self._choose_function(control, name, True)
            others = [one for one in self.map.controls if name in one.terms]
            anew = [self._choose_function(one, name, True) for one in others]
            if candidate is not None and None not in anew:
                self.map.inverted.add(name)
                for one, term in zip(others, anew, strict=True):
                    one.terms[name] = cast("tuple[str, float]", term)
                return candidate
            candidate = None
        if candidate is None:
            raise UnmappedError(f"`{name}` is no simple function of it")
        return candidate

    def _choose_function(self, control: MappedControl, name: str, inverted: bool) -> tuple[str, float] | None:
        """Return the function through the rows of a control; None if no known one is."""
        before = invert(self.map.numbers[name], inverted)
        rows = [(x, invert(row[name], inverted)) for x, row in control.rows]
        at, value = rows[0]
        positive = control.value > 0.0 and all(x > 0.0 for x, _ in rows)
        for word, function in FUNCTIONS.items():
            if word not in ("x", "x2", "x3") and not positive:
                continue
            slope = (value - before) / (function(at) - function(control.value))
            if not math.isfinite(slope):
                continue
            slope = float(round(slope)) if abs(slope - round(slope)) < SAME * abs(slope) else slope
            if all(is_same(before + slope * (function(x) - function(control.value)), y, 3.0) for x, y in rows):
                return word, slope
        return None

    def _reach_ends(self) -> None:
        """Widen the range of every control as far as its map holds: to the ends of its slider, or less far."""
        input_map = self.map
        for upward in (True, False):
            every = range(len(input_map.controls))
            _, late = self._try_ends(every, upward, SMALLEST_SHIFT)  # refused at once, or no effect yet
            left = [k for k in every if k not in late]
            for share in SHORTER:
                reached, left = self._try_ends(left, upward, share)
                for k, x in reached:
                    one = input_map.controls[k]
                    one.low, one.high = min(one.low, x), max(one.high, x)
        input_map.left_out |= {one.path: self.reason for one in input_map.controls if one.low == one.high}
        input_map.controls = [one for one in input_map.controls if one.low < one.high]

    def _try_ends(
        self, numbers: Sequence[int], upward: bool, share: float
    ) -> tuple[list[tuple[int, float]], list[int]]:
        """Return the controls that reach a share of the way to an end, with their values, and the others."""
        trials = [(k, self._choose_end(self.map.controls[k], upward, share)) for k in numbers]
        failed = self.sort_out([{k: x} for k, x in trials])
        reached = [trial for number, trial in enumerate(trials) if number not in failed]
        return reached, [numbers[number] for number in failed]

    def _choose_end(self, control: MappedControl, upward: bool, share: float) -> float:
        """Return a value towards an end of the slider; the value of the control without a slider."""
        slider = control.node["slider"]
        return (
            control.value if slider is None else self._choose_value(control, slider["high" if upward else "low"], share)
        )

    def _map_row(self, row: NumberRow) -> None:
        """The numbers of a row: each is linear, and none minds the others."""
        input_map, others = self.map, len(self.map.controls)
        input_map.rows.append(row)
        try:
            input_map.controls += [self._begin_item(node) for node in row.items]
            for shares in PATTERNS:
                turns = enumerate(input_map.controls[others:])
                places = {others + k: one.low + shares[k % len(shares)] * (one.high - one.low) for k, one in turns}
                self.check(places)
        except UnmappedError:
            input_map.rows.pop()
            del input_map.controls[others:]
            raise
        for a, b in itertools.product(range(others), range(others, len(input_map.controls))):
            if input_map.controls[a].terms.keys() & input_map.controls[b].terms.keys():
                input_map.apart.add((a, b))

    def _begin_item(self, node: NumberNode) -> MappedControl:
        slider, value = node["slider"], node["value"]
        if slider is None or value is None:
            raise UnmappedError("it has no slider")
        control = MappedControl(node, value, slider["low"], slider["high"])
        control.rows = [(control.high, self.build([(node, control.high)]))]
        self._fit(control)
        return control

    def _multiply(self, a: int, b: int) -> None:
        """Coefficients of the products of two controls from which the same numbers follow."""
        input_map = self.map
        one, two = input_map.controls[a], input_map.controls[b]
        shared = [name for name in one.terms if name in two.terms]
        if not shared:
            return
        x, y = one.rows[0][0], two.rows[0][0]
        try:
            row = self.build([(one.node, x), (two.node, y)])
        except UnmappedError:
            input_map.apart.add((a, b))
            return
        predicted = input_map.predict({a: x, b: y})
        for name in shared:
            if not is_same(row[name], predicted[name], 3.0):
                inverted = name in input_map.inverted
                missing = invert(row[name], inverted) - invert(predicted[name], inverted)
                input_map.products[name, a, b] = missing / (one.change(name, x) * two.change(name, y))

    def _try_pairs(self) -> None:
        """Try pairs of which some number follows, or which a builder may compare, at opposite ends."""
        input_map, trials = self.map, list[dict[int, float]]()
        for a, b in itertools.combinations(range(len(input_map.controls)), 2):
            one, two = input_map.controls[a], input_map.controls[b]
            if one.cautions and two.cautions:  # both could give one sentence
                input_map.apart.add((a, b))
            if (a, b) in input_map.apart or not _may_interact(one, two):
                continue
            for x, y in ((one.low, two.high), (one.high, two.low)):
                if x != one.value and y != two.value:
                    trials.append({a: x, b: y})
        failed = {cast("Pair", tuple(trials[number])) for number in self.sort_out(trials)}
        input_map.apart |= failed
        input_map.ordered = set(filter(None, map(self._find_order, sorted(failed))))
        input_map.apart -= {pair for one, other in input_map.ordered for pair in ((one, other), (other, one))}

    def _find_order(self, pair: Pair) -> Pair | None:
        """Return a pair that a builder refuses in the wrong order only, the smaller one first."""
        (a, one), (b, two) = sorted(((k, self.map.controls[k]) for k in pair), key=lambda item: item[1].value)
        low, high = max(one.low, two.low), min(one.high, two.high)
        if one.node["unit"] != two.node["unit"] or one.value >= two.value or low >= high:
            return None  # their order is not the cause
        trials = [
            (one.low, two.high),
            *((low + part * (high - low), low + (part + NARROW) * (high - low)) for part in WITHIN),
        ]
        turned = [(y, x) for x, y in trials[1:]]
        right = self.sort_out([{a: x, b: y} for x, y in trials])
        wrong = self.sort_out([{a: x, b: y} for x, y in turned])
        return (a, b) if not right and len(wrong) == len(turned) else None


def _may_interact(one: MappedControl, two: MappedControl) -> bool:
    """Test whether two controls change the same number, or have the same unit and are in related parts."""
    if one.terms.keys() & two.terms.keys():
        return True
    a, b = one.path.split("."), two.path.split(".")
    return one.node["unit"] == two.node["unit"] and _is_near(a, b)


def _is_near(a: Sequence[str], b: Sequence[str]) -> bool:
    """Test whether two paths are in the same part, or in parts of the same one."""
    return a[:-1] == b[:-1] or (len(a) > 1 and len(b) > 1 and (a[:-2] or a[:1]) == (b[:-2] or b[:1]))
