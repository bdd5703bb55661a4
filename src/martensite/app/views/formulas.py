"""Formulas for the page: operations of a function, recorded once and evaluated by the browser.

A `RecordedNumber` has a value, so that a function runs as on floats, and a row in a table of operations. Branches on
values are recorded: a recording is valid while all choices have the same outcome, which the browser checks
(`web/src/views/formulas.ts`).

A row is one of

    ["p", path]     a parameter          ["y", column]       a column, over time
    ["c", number]   a constant           ["first", column]   the first value of a column
    [operation, row, row, …]
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, cast

from martensite.actuators.assembly import AbstractSystem
from martensite.app.messages import JsonTable
from martensite.base.parameters import Parametrised
from martensite.control.loop.bench import Bench
from martensite.kernels.floats import expand_power, find_whole_exponent, power

LEAVES = frozenset({"p", "c", "y", "first"})
"""First entry of a row that does not depend on other rows."""
SAME = frozenset({"detach", "store", "implicit_root"})
"""Operations that return their first argument."""


def write_number(value: float) -> float | str:
    """Return a number for JavaScript, with names for infinity and NaN."""
    return value if math.isfinite(value) else "NaN" if math.isnan(value) else f"{'-' * (value < 0.0)}Infinity"


class Formulas:
    """A table of distinct rows."""

    def __init__(self, forced: Sequence[bool] = ()) -> None:
        self.rows: list[list[Any]] = []
        self.choices: dict[int, bool] = {}
        self._numbers: dict[tuple[Any, ...], RecordedNumber] = {}
        self._forced = forced

    def leaf(self, kind: str, name: str, value: float) -> RecordedNumber:
        """Return a parameter or a column, with its present value."""
        return self._add([kind, name], value)

    def constant(self, value: Any) -> RecordedNumber:
        """Return a constant number or flag."""
        if isinstance(value, RecordedNumber):
            return value
        number = float(value)
        return self._add(["c", write_number(number)], number)

    def apply(self, name: str, plain: Callable[..., Any], numbers: Sequence[Any]) -> RecordedNumber:
        """Record an operation on numbers."""
        if name in SAME:
            return self.constant(numbers[0])
        given = [self.constant(one) for one in numbers]
        try:
            value = plain(*(one.value for one in given))
        except (ZeroDivisionError, ValueError, OverflowError):
            value = math.nan
        if all(self.rows[one.row][0] == "c" for one in given):
            return self.constant(value)
        return self._add([name, *(one.row for one in given)], value)

    def choose(self, flag: RecordedNumber) -> bool:
        """Return the outcome of a condition, and record it."""
        if self.rows[flag.row][0] == "c":
            return bool(flag.value)
        if flag.row not in self.choices:
            k = len(self.choices)
            self.choices[flag.row] = self._forced[k] if k < len(self._forced) else bool(flag.value)
        return self.choices[flag.row]

    def collect(self, **results: Any) -> JsonTable:
        """Return the data for the page: the needed rows, the choices, and the results with rows for numbers."""
        places = dict.fromkeys(self.choices)
        placed = {name: self._place(one, places) for name, one in results.items()}
        needed_rows = self._list_needed(places)
        numbers = {row: k for k, row in enumerate(needed_rows)}
        rows = [self._renumber(self.rows[row], numbers) for row in needed_rows]
        choices = [[numbers[row], int(outcome)] for row, outcome in self.choices.items()]
        return {"rows": rows, "choices": choices, **{name: _replace(one, numbers) for name, one in placed.items()}}

    def _place(self, result: Any, places: dict[int, None]) -> Any:
        """Return the results with `_Row` for numbers."""
        if isinstance(result, dict):
            return {name: self._place(one, places) for name, one in result.items()}
        if isinstance(result, (list, tuple)):
            return [self._place(one, places) for one in result]
        if result is None or isinstance(result, str):
            places.update(dict.fromkeys(int(row) for row in re.findall("\x02(\\d+):", result or "")))
            return result
        row = self.constant(result).row
        places[row] = None
        return _Row(row)

    def _list_needed(self, places: Iterable[int]) -> list[int]:
        needed_rows, left = set[int](), list(places)
        while left:
            row = left.pop()
            if row not in needed_rows:
                needed_rows.add(row)
                left += [] if self.rows[row][0] in LEAVES else self.rows[row][1:]
        return sorted(needed_rows)

    def _renumber(self, row: list[Any], numbers: Mapping[int, int]) -> list[Any]:
        return row if row[0] in LEAVES else [row[0], *(numbers[one] for one in row[1:])]

    def _add(self, row: list[Any], value: Any) -> RecordedNumber:
        key = (*row, math.copysign(1.0, row[1])) if row[0] == "c" and isinstance(row[1], float) else tuple(row)
        if key not in self._numbers:
            self._numbers[key] = RecordedNumber(self, len(self.rows), value)
            self.rows.append(row)
        return self._numbers[key]


class _Row(int):
    """The index of a row."""


def _replace(result: Any, numbers: Mapping[int, int]) -> Any:
    if isinstance(result, dict):
        return {name: _replace(one, numbers) for name, one in cast("JsonTable", result).items()}
    if isinstance(result, list):
        return [_replace(one, numbers) for one in cast("list[Any]", result)]
    if isinstance(result, str):
        return re.sub("\x02(\\d+):", lambda m: f"\x02{numbers[int(m[1])]}:", result)
    return numbers[result] if isinstance(result, _Row) else result


def _write_operator(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *numbers: _find_table(numbers).apply(name, plain, numbers)


def _write_reflected(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    return lambda a, b: a.table.apply(name, plain, (b, a))


def _find_table(numbers: Sequence[Any]) -> Formulas:
    return next(one.table for one in numbers if isinstance(one, RecordedNumber))


class RecordedNumber:
    """A number with its row; `float` of it is refused, so that each operation is recorded."""

    __slots__ = ("row", "table", "value")

    def __init__(self, table: Formulas, row: int, value: Any) -> None:
        self.table, self.row, self.value = table, row, value

    def record(self, name: str, plain: Callable[..., Any], numbers: Sequence[Any]) -> RecordedNumber:
        """Record a function of `martensite.kernels.recordable_numbers`."""
        if name == "power" and isinstance(numbers[1], int):
            return expand_power(*numbers)
        return self.table.apply(name, plain, numbers)

    __add__, __radd__ = _write_operator("add", operator.add), _write_reflected("add", operator.add)
    __sub__, __rsub__ = _write_operator("sub", operator.sub), _write_reflected("sub", operator.sub)
    __mul__, __rmul__ = _write_operator("mul", operator.mul), _write_reflected("mul", operator.mul)
    __truediv__, __rtruediv__ = (one("div", operator.truediv) for one in (_write_operator, _write_reflected))
    __neg__, __abs__ = _write_operator("neg", operator.neg), _write_operator("abs", abs)
    __lt__, __le__ = _write_operator("lt", operator.lt), _write_operator("le", operator.le)
    __gt__, __ge__ = _write_operator("gt", operator.gt), _write_operator("ge", operator.ge)
    __eq__, __ne__ = _write_operator("eq", operator.eq), _write_operator("ne", operator.ne)
    __hash__ = object.__hash__

    def __pow__(self, exponent: Any) -> Any:
        whole = find_whole_exponent(exponent)
        return self.table.apply("power", power, (self, exponent)) if whole is None else expand_power(self, whole)

    def __bool__(self) -> bool:
        is_flag = isinstance(self.value, bool)
        return self.table.choose(self if is_flag else self.table.apply("ne", operator.ne, (self, 0.0)))

    def __round__(self) -> int:
        whole = round(self.value)
        bool(abs(self - whole) <= 0.5)
        return whole

    def __format__(self, form: str) -> str:
        """Return a placeholder in a text for the number of the browser."""
        return f"\x02{self.row}:{form}\x03"


def rebuild_recorded(whole: AbstractSystem, table: Formulas) -> AbstractSystem:
    """Return a system, or the plant of a bench, with recorded parameters."""
    recorded = record_part(whole, "", table)
    return recorded.plant if isinstance(recorded, Bench) else recorded


def record_part(part: Any, path: str, table: Formulas) -> Any:
    """Return a part at a path, which ends in a dot, with recorded parameters."""
    return part.rebuilt({leaf.path: table.leaf("p", path + leaf.path, leaf.value) for leaf in part.leaves()})


def locate_part(whole: Parametrised, part: object) -> str | None:
    """Return the path of a part, which ends in a dot; None if it is not in the tree."""
    for name, child in whole.children():
        below = "" if child is part else locate_part(child, part)
        if below is not None:
            return f"{name}.{below}"
    return None


def explore_choices(
    build: Callable[[Sequence[bool]], tuple[Formulas, Any]], most: int = 8
) -> Iterator[tuple[Formulas, Any]]:
    """Yield the results of a function for all outcomes of its choices, the present outcome first."""
    left: list[list[bool]] = [[]]
    while left and most:
        forced, most = left.pop(0), most - 1
        table, result = build(forced)
        outcomes = list(table.choices.values())
        yield table, result
        left += [[*outcomes[:k], not outcomes[k]] for k in range(len(forced), len(outcomes))]
