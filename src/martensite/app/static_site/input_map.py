"""Map from the controls of a form to the numbers of a run, measured on the builder of scenarios.

A control is set to other values of its slider, the scenario is built again, and every changed number is written as a
sum,

    e = e0 + Σ c_a Δg_a + Σ c_ab Δg_a Δg_b,   Δg_a = g_a(x_a) - g_a(x_a0),

with a function g of each control: its value, a power of it, or its inverse; if the inverse of a number is such a sum,
as for resistances in series, the inverse is used. A function fitted through two values must hold at others, up to both
ends of the range. If it does not, the range ends earlier, or the control is left out. Two controls that affect the same
number, or that a builder may compare, are tried together; incompatible controls are separated. A row of numbers, such
as the values of a table, has one control for each: by one trial each, and by trials of all at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from martensite.app.documents import build_packaged
from martensite.app.forms.form_types import NumberNode, ScenarioForm
from martensite.app.forms.sections import describe_scenario
from martensite.app.messages import JsonTable
from martensite.app.static_site.flat_inputs import DriveShape, list_inputs
from martensite.app.static_site.number_rows import NumberRow, list_rows, read_row
from martensite.base.errors import MartensiteError
from martensite.base.parameters import describe_structure
from martensite.scenario.scenario import Scenario

SAME = 1e-12
"""Share of a number up to which it is the same."""
SHORTER = (1.0, 0.95, 0.75, 0.5, 0.25, 0.1)
"""Shares of the way to an end that are tried as the end of the range."""
SMALLEST_SHIFT = 0.001
"""Smallest step of a slider, as a fraction of its travel: a refused control is refused already there."""
ROUNDING_TOLERANCE = 8.0 * 2.0**-52
"""Share of its terms that a sum is rounding, and 0."""
PATTERNS = ((0.0, 1.0), (1.0, 0.0), (1.0,), (0.1, 0.9, 0.4, 0.75, 0.3))
"""Shares of the way from the low to the high end, by turns, at which a row is tried."""
NARROW, WITHIN = 0.02, (0.05, 0.5, 0.93)
"""Spacing of two ordered numbers in a trial, and its positions, as fractions of their common range."""
TOGETHER = 8
"""So many trials are made in one."""
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
    rows: list[Row] = field(default_factory=list[Row])
    """Values that were tried, and the numbers that came of them."""
    said: tuple[str, ...] = ()
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


def _invert(value: float, inverted: bool) -> float:
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
        found, moved = dict(self.numbers), dict[str, dict[int, float]]()
        for k, value in changes.items():
            for name in self.controls[k].terms:
                moved.setdefault(name, {})[k] = self.controls[k].change(name, value)
        for name, steps in moved.items():
            inverted = name in self.inverted
            begin = _invert(self.numbers[name], inverted)
            parts = [begin, *(self.controls[k].terms[name][1] * step for k, step in steps.items())]
            for (a, x), (b, y) in itertools.combinations(sorted(steps.items()), 2):
                parts.append(self.products.get((name, a, b), 0.0) * x * y)
            total = sum(parts)
            is_rounding = not inverted and abs(total) <= ROUNDING_TOLERANCE * sum(map(abs, parts))
            found[name] = 0.0 if is_rounding else _invert(total, inverted)
        return found


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
        found = list_inputs(scenario)
        self.map = InputMap(scenario, describe_scenario(scenario), found.numbers, found.drives, found.samples)
        self.digest, self.structure = found.digest(), describe_structure(scenario.whole)
        self.said = self._list_said(scenario)
        self.cautions: tuple[str, ...] = ()

    def measure(self, only: Collection[str] | None) -> InputMap:
        made = self.map
        nodes = [one for one in list_numbers(made.form) if only is None or one["path"] in only]
        for node in nodes:
            try:
                made.controls.append(self._begin_control(node))
            except UnmappedError as error:
                made.left_out[node["path"]] = str(error)
        self._reach_ends()
        for a, b in itertools.combinations(range(len(made.controls)), 2):
            self._multiply(a, b)
        self._try_pairs()
        for row in list_rows(made.form):
            if only is None or row["path"] in only:
                try:
                    self._map_row(read_row(row))
                except (UnmappedError, MartensiteError, ValueError) as error:
                    made.left_out[row["path"]] = str(error)
        return made

    # ------------------------------------------------------------ building

    def build(self, changes: Sequence[tuple[NumberNode, float]]) -> dict[str, float]:
        """Return the numbers under changes of controls."""
        settings = self._write_settings(changes)
        try:
            scenario = build_packaged(self.text, settings)
            found, cautions = list_inputs(scenario, self.map.drives), scenario.cautions
        except (MartensiteError, ArithmeticError, ValueError) as error:
            raise UnmappedError(f"at {settings}: {error}") from None
        if describe_structure(scenario.whole) != self.structure:
            raise UnmappedError("it changes the structure")
        if found.digest() != self.digest:
            raise UnmappedError("it changes readings of a signal")
        said = self._list_said(scenario)
        if said != self.said:
            raise UnmappedError("it changes what is said of the scenario")
        if not set(cautions) >= set(known := self.map.scenario.cautions):
            raise UnmappedError("it changes the cautions")
        self.cautions = tuple(one for one in cautions if one not in known)
        return found.numbers

    def _write_settings(self, changes: Sequence[tuple[NumberNode, float]]) -> JsonTable:
        """Return the entries to set in the document; a row is set as a whole."""
        found: JsonTable = {node["path"]: write_quantity(node, value) for node, value in changes}
        for row in self.map.rows:
            moved = {one["path"]: found.pop(one["path"]) for one in row.items if one["path"] in found}
            if moved:
                listed = zip(row.items, row.entries, strict=True)
                found[row.path] = [moved.get(node["path"], entry) for node, entry in listed]
        return found

    def _list_said(self, scenario: Scenario) -> Any:
        return scenario.whole.description(), scenario.title, scenario.restart_at, scenario.seed

    def check(self, changes: Mapping[int, float]) -> None:
        """Raise `UnmappedError` where the map does not say what is built."""
        made = self.map
        row = self.build([(made.controls[k].node, value) for k, value in changes.items()])
        found = made.predict(changes)
        moved = [made.controls[k] for k, value in changes.items() if value != made.controls[k].value]
        if self.cautions != tuple(caution for one in moved for caution in one.said):
            raise UnmappedError("it changes the cautions")
        wrong = [name for name, value in row.items() if not _is_same(found[name], value, 10.0)]
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

    # ------------------------------------------------------------ single controls

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
            control.said = self.cautions
            return control
        raise UnmappedError(reason)

    def _choose_value(self, control: MappedControl, end: float, share: float) -> float:
        """Return a value of a share of the way to an end."""
        slider, value = control.node["slider"], control.value
        log = slider is not None and slider["log"] and value > 0.0 and end > 0.0
        found = value * (end / value) ** share if log else value + share * (end - value)
        if slider is not None and slider["whole"]:
            return float(round(found))
        how = control.node
        return _read_shown(how, float(f"{found * how['factor'] + how['offset']:.6g}"))

    def _fit(self, control: MappedControl) -> None:
        """Functions of all numbers that moved."""
        before = self.map.numbers
        moved = dict.fromkeys(n for _, row in control.rows for n, x in row.items() if not _is_same(x, before[n]))
        control.terms = {name: self._find_function(control, name) for name in moved}

    def _find_function(self, control: MappedControl, name: str) -> tuple[str, float]:
        """Return the function of a number of a control; if only its inverse is simple, use it for all controls."""
        inverted = name in self.map.inverted
        found = self._choose_function(control, name, inverted)
        if found is None and not inverted:
            found = self._choose_function(control, name, True)
            others = [one for one in self.map.controls if name in one.terms]
            anew = [self._choose_function(one, name, True) for one in others]
            if found is not None and None not in anew:
                self.map.inverted.add(name)
                for one, term in zip(others, anew, strict=True):
                    one.terms[name] = cast("tuple[str, float]", term)
                return found
            found = None
        if found is None:
            raise UnmappedError(f"`{name}` is no simple function of it")
        return found

    def _choose_function(self, control: MappedControl, name: str, inverted: bool) -> tuple[str, float] | None:
        """Return the function through the rows of a control; None if no known one is."""
        before = _invert(self.map.numbers[name], inverted)
        rows = [(x, _invert(row[name], inverted)) for x, row in control.rows]
        at, value = rows[0]
        positive = control.value > 0.0 and all(x > 0.0 for x, _ in rows)
        for word, function in FUNCTIONS.items():
            if word not in ("x", "x2", "x3") and not positive:
                continue
            slope = (value - before) / (function(at) - function(control.value))
            if not math.isfinite(slope):
                continue
            slope = float(round(slope)) if abs(slope - round(slope)) < SAME * abs(slope) else slope
            if all(_is_same(before + slope * (function(x) - function(control.value)), y, 3.0) for x, y in rows):
                return word, slope
        return None

    def _reach_ends(self) -> None:
        """Widen the range of every control as far as its map holds: to the ends of its slider, or less far."""
        made = self.map
        for upward in (True, False):
            ways = [(k, self._choose_end(one, upward, SMALLEST_SHIFT)) for k, one in enumerate(made.controls)]
            late = self.sort_out([{k: x} for k, x in ways])  # effects that appear only later, or refused at once
            left = [k for number, (k, _) in enumerate(ways) if number not in late]
            for share in SHORTER:
                trials = [(k, self._choose_end(made.controls[k], upward, share)) for k in left]
                failed = self.sort_out([{k: x} for k, x in trials])
                for k, x in (trial for number, trial in enumerate(trials) if number not in failed):
                    one = made.controls[k]
                    one.low, one.high = min(one.low, x), max(one.high, x)
                left = [trials[number][0] for number in failed]
        made.left_out |= {one.path: self.reason for one in made.controls if one.low == one.high}
        made.controls = [one for one in made.controls if one.low < one.high]

    def _choose_end(self, control: MappedControl, upward: bool, share: float) -> float:
        """Return a value towards an end of the slider; the value of the control without a slider."""
        slider = control.node["slider"]
        return (
            control.value if slider is None else self._choose_value(control, slider["high" if upward else "low"], share)
        )

    # ------------------------------------------------------------ rows

    def _map_row(self, row: NumberRow) -> None:
        """The numbers of a row: each is linear, and none minds the others."""
        made, others = self.map, len(self.map.controls)
        made.rows.append(row)
        try:
            made.controls += [self._begin_item(node) for node in row.items]
            for shares in PATTERNS:
                turns = enumerate(made.controls[others:])
                places = {others + k: one.low + shares[k % len(shares)] * (one.high - one.low) for k, one in turns}
                self.check(places)
        except UnmappedError:
            made.rows.pop()
            del made.controls[others:]
            raise
        for a, b in itertools.product(range(others), range(others, len(made.controls))):
            if made.controls[a].terms.keys() & made.controls[b].terms.keys():
                made.apart.add((a, b))

    def _begin_item(self, node: NumberNode) -> MappedControl:
        """Return a number of a row, from one trial."""
        slider, value = node["slider"], node["value"]
        if slider is None or value is None:
            raise UnmappedError("it has no slider")
        control = MappedControl(node, value, slider["low"], slider["high"])
        control.rows = [(control.high, self.build([(node, control.high)]))]
        self._fit(control)
        return control

    # ------------------------------------------------------------ two controls

    def _multiply(self, a: int, b: int) -> None:
        """Coefficients of the products of two controls from which the same numbers follow."""
        made = self.map
        one, two = made.controls[a], made.controls[b]
        shared = [name for name in one.terms if name in two.terms]
        if not shared:
            return
        x, y = one.rows[0][0], two.rows[0][0]
        try:
            row = self.build([(one.node, x), (two.node, y)])
        except UnmappedError:
            made.apart.add((a, b))
            return
        found = made.predict({a: x, b: y})
        for name in shared:
            if not _is_same(row[name], found[name], 3.0):
                inverted = name in made.inverted
                missing = _invert(row[name], inverted) - _invert(found[name], inverted)
                made.products[name, a, b] = missing / (one.change(name, x) * two.change(name, y))

    def _try_pairs(self) -> None:
        """Try pairs of which some number follows, or which a builder may compare, at opposite ends."""
        made, pairs, trials = self.map, list[Pair](), list[dict[int, float]]()
        for a, b in itertools.combinations(range(len(made.controls)), 2):
            one, two = made.controls[a], made.controls[b]
            if one.said and two.said:  # they might be one sentence then
                made.apart.add((a, b))
            likely = one.node["unit"] == two.node["unit"] and _is_near(one.path, two.path)
            if (a, b) in made.apart or not (likely or one.terms.keys() & two.terms.keys()):
                continue
            for x, y in ((one.low, two.high), (one.high, two.low)):
                if x != one.value and y != two.value:
                    pairs.append((a, b))
                    trials.append({a: x, b: y})
        failed = self.sort_out(trials)
        made.apart |= {pairs[number] for number in failed}
        made.ordered = {pair for pair in map(self._find_order, sorted({pairs[number] for number in failed})) if pair}
        made.apart -= {pair for one, other in made.ordered for pair in ((one, other), (other, one))}

    def _find_order(self, pair: Pair) -> Pair | None:
        """Return a pair that a builder refuses in the wrong order only, the smaller one first."""
        (a, one), (b, two) = sorted(((k, self.map.controls[k]) for k in pair), key=lambda item: item[1].value)
        low, high = max(one.low, two.low), min(one.high, two.high)
        if one.node["unit"] != two.node["unit"] or one.value >= two.value or low >= high:
            return None  # they cannot be in the wrong order: it is something else
        kept = [
            (one.low, two.high),
            *((low + part * (high - low), low + (part + NARROW) * (high - low)) for part in WITHIN),
        ]
        turned = [(y, x) for x, y in kept[1:]]
        right = self.sort_out([{a: x, b: y} for x, y in kept])
        wrong = self.sort_out([{a: x, b: y} for x, y in turned])
        return (a, b) if not right and len(wrong) == len(turned) else None


def _is_near(one: str, two: str) -> bool:
    """Return whether two paths end in the same part, or in parts of the same one."""
    a, b = one.split("."), two.split(".")
    return a[:-1] == b[:-1] or (len(a) > 1 and len(b) > 1 and (a[:-2] or a[:1]) == (b[:-2] or b[:1]))


def _is_same(one: float, other: float, slack: float = 1.0) -> bool:
    return one == other or abs(one - other) <= slack * SAME * max(abs(one), abs(other))


def write_quantity(node: NumberNode, value: float) -> str | float:
    """Return a value in SI as the page sends it."""
    shown = value * node["factor"] + node["offset"]
    number = float(f"{shown:.15g}")
    if node["slider"] is not None and node["slider"]["whole"]:
        return round(number)
    return f"{number!r} {node['shown']}" if node["shown"] else number


def _read_shown(node: NumberNode, shown: float) -> float:
    return (shown - node["offset"]) / node["factor"]
