"""Records of a staircase: repair a counter, reduce to plateaus, find the offset of a supply.

`reduce_to_plateaus` reduces a record of equal steps to one row per plateau, from its settled last part.

The set-point V of a supply can have an offset V₀ from the voltage at the wire. Where the resistance R is constant, V =
V₀ + R I is a straight line: `supply_offset` fits it by least squares. With n plateaus, residuals r, the mean current m
and S = Σ (I - m)²,

    s² = Σ r²/(n - 2),    error of R: s/√S,    error of V₀: s √(1/n + m²/S)

If the resistance rises as the wire warms, V₀ is too low: use small currents.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from statistics import fmean, stdev

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.regression import fit_powers
from martensite.signals.records import Record

COUNT = "count"
DEVIATION = "_deviation"
"""Suffix of standard deviation columns."""


@dataclass(frozen=True)
class UnwrappedCounter:
    """Values without the jumps of their counter."""

    values: list[float]
    jumps: list[int]
    """Index of the first value after each jump."""


@dataclass(frozen=True)
class SupplyOffset:
    """The line V = V₀ + R I through plateaus of constant resistance, with standard errors."""

    offset: float
    """V₀ [V]."""
    offset_error: float
    """[V]"""
    resistance: float
    """R [ohm]."""
    resistance_error: float
    """[ohm]"""
    count: int
    """Number of plateaus."""


def unwrap_counter(values: Sequence[float], drop: float) -> UnwrappedCounter:
    """Repair a counter that has fallen back by a constant, once or repeatedly.

    A fall between half and one and a half times `drop` from one value to the next is a jump; `drop` is added to all
    values after it.

    Args:
        values: readings of the counter.
        drop: fall of the counter, positive, in the unit of the values.

    Raises:
        ParameterError: `drop` is not above zero.
    """
    if not 0.0 < drop < math.inf:
        raise ParameterError(f"Argument `drop` must be above 0, but is {drop:g}.")
    jumps = [i for i in range(1, len(values)) if 0.5 * drop < values[i - 1] - values[i] < 1.5 * drop]
    passed, mended = set(jumps), list[float]()
    lost = 0
    for i, value in enumerate(values):
        lost += i in passed
        mended.append(value + lost * drop if lost else value)
    return UnwrappedCounter(mended, jumps)


def reduce_to_plateaus(
    record: Record, column: str, *, settled: float = 0.5, tolerance: float = 0.0, shortest: int = 2
) -> Record:
    """Reduce the record of a staircase to one row per plateau.

    A plateau is a run of rows with `column` within `tolerance` of its first value. Other columns are averaged over its
    settled last part, at least two rows.

    Args:
        record: the record of a staircase.
        column: column that is constant on each plateau.
        settled: settled fraction of the rows of a plateau, above 0 to 1.
        tolerance: allowed variation of the column, in its SI unit.
        shortest: smallest number of rows of a plateau, at least 2.

    Returns:
        A record of the level of `column`, the mean of each other column (`time` too), their sample standard deviations
        under `<name>_deviation`, and the `count` of averaged rows. `dropped` counts the rows of omitted plateaus.

    Raises:
        ParameterError: an argument is out of range.
        DataError: the column does not exist, a name is taken, or no plateau is long enough.
    """
    _check_settled(settled, tolerance, shortest)
    runs = _find_runs(record[column].tolist(), tolerance)
    plateaus = [(first, last) for first, last in runs if last - first >= shortest]
    if not plateaus:
        raise DataError(
            f"Column `{column}` of record `{record.name}` has no plateau of at least "
            f"{shortest} rows. Hold each level of a staircase test for that long."
        )
    parts = [(max(first, last - _build_rows(settled, last - first)), last) for first, last in plateaus]
    others = [name for name in record.columns if name != column]
    table = dict(zip(others, _reduce_columns(record, others, parts, fmean), strict=True))
    table[column] = [record[column][first] for first, _ in plateaus]
    names = [name + DEVIATION for name in others]
    scatter = dict(zip(names, _reduce_columns(record, others, parts, stdev), strict=True))
    scatter[COUNT] = [float(b - a) for a, b in parts]
    if taken := scatter.keys() & table.keys():
        raise DataError(f"Record `{record.name}` has a column `{min(taken)}` already; rename it.")
    units = record.units | {COUNT: "1"} | {name + DEVIATION: record.units[name] for name in others}
    dropped = len(record) - sum(last - first for first, last in plateaus)
    return Record(f"{record.name}, plateaus", table | scatter, units, record.source, dropped)


def _reduce_columns(
    record: Record, names: Sequence[str], parts: Sequence[tuple[int, int]], function: Callable[[list[float]], float]
) -> list[list[float]]:
    """Apply a function to each part of each column."""
    return [[function(record[name][a:b].tolist()) for a, b in parts] for name in names]


def supply_offset(table: Record, set_point: str, current: str, low: float, high: float) -> SupplyOffset:
    """Return the offset of a supply from plateaus of constant resistance.

    Args:
        table: plateaus from `reduce_to_plateaus`.
        set_point: column of the set-point [V].
        current: column of the current [A].
        low: lowest set-point used [V].
        high: highest set-point used [V].

    Raises:
        DataError: fewer than 3 plateaus are in range, or their currents are equal.
    """
    pairs = zip(table[current].tolist(), table[set_point].tolist(), strict=True)
    slack = 1e-9 * max(abs(low), abs(high))
    points = [(i, v) for i, v in pairs if low - slack <= v <= high + slack]
    n = len(points)
    if n < 3 or len({i for i, _ in points}) < 2:
        raise DataError(
            f"Record `{table.name}` has {n} plateaus from {low:g} to {high:g} V; an offset needs "
            "at least 3, of different currents."
        )
    line = fit_powers([i for i, _ in points], [v for _, v in points], (0, 1))
    return SupplyOffset(line.values[0], line.error(0), line.values[1], line.error(1), n)


def _find_runs(values: Sequence[float], tolerance: float) -> list[tuple[int, int]]:
    level, group, groups = values[0], 0, list[int]()
    for value in values:
        if abs(value - level) > tolerance:
            level, group = value, group + 1
        groups.append(group)
    lengths = [len(list(members)) for _, members in groupby(groups)]
    ends = [sum(lengths[: i + 1]) for i in range(len(lengths))]
    return [(end - length, end) for end, length in zip(ends, lengths, strict=True)]


def _build_rows(settled: float, rows: int) -> int:
    return max(2, math.ceil(settled * rows))


def _check_settled(settled: float, tolerance: float, shortest: int) -> None:
    if not 0.0 < settled <= 1.0:
        raise ParameterError(f"Argument `settled` must be above 0 to 1, but is {settled:g}.")
    if not 0.0 <= tolerance < math.inf:
        raise ParameterError(f"Argument `tolerance` must be at least 0, but is {tolerance:g}.")
    if shortest < 2:
        raise ParameterError(f"Argument `shortest` must be at least 2, but is {shortest}.")
