"""Records of a staircase: mend its counter, reduce it to plateaus, find the offset of a supply.

A supply that goes up in equal steps, and is held on each, leaves a record of which only the
last part of each plateau is steady. `plateaus` turns that into one row per plateau.

The set-point V of a supply may carry an offset V₀ against what is across the wire. Where the
resistance R does not change, V = V₀ + R I is a straight line: `supply_offset` fits it by least
squares. With n plateaus, residuals r, the mean current m and S = Σ (I - m)²,

    s² = Σ r²/(n - 2),    error of R: s/√S,    error of V₀: s √(1/n + m²/S)

A wire that resists more as it warms tilts the line and so lowers V₀: keep to small currents.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from statistics import fmean, stdev

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.regression import fit_powers
from martensite.signals.records import Record

COUNT = "count"
DEVIATION = "_deviation"
"""Suffix of the column of a standard deviation."""


@dataclass(frozen=True)
class Unwrapped:
    """Values without the jumps of their counter, and where those were."""

    values: list[float]
    jumps: list[int]
    """Index of the first value after each jump."""


@dataclass(frozen=True)
class SupplyOffset:
    """The line V = V₀ + R I through plateaus of constant resistance, with standard errors."""

    offset: float
    """V₀ [V]"""
    offset_error: float
    """[V]"""
    resistance: float
    """R [ohm]"""
    resistance_error: float
    """[ohm]"""
    count: int
    """Number of plateaus."""


def unwrap_counter(values: Sequence[float], drop: float) -> Unwrapped:
    """Mend a counter that has fallen back by a constant, once or repeatedly.

    A fall of between half and one and a half times `drop` from one value to the next is a
    jump; from there on `drop` is added once more. Every other change is left as it is.

    Args:
        values: what the counter showed.
        drop: by how much it falls back, above zero, in the unit of the values.

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
    return Unwrapped(mended, jumps)


def reduce_to_plateaus(
    record: Record, column: str, *, settled: float = 0.5, tolerance: float = 0.0, shortest: int = 2
) -> Record:
    """Reduce the record of a staircase to one row per plateau.

    A plateau is a run of rows on which `column` stays within `tolerance` of its first value.
    Every other column is averaged over the settled last part of it, at least two rows.

    Args:
        record: the record of a staircase.
        column: the column that is held on each plateau.
        settled: share of the rows of a plateau that counts as settled, above 0 to 1.
        tolerance: by how much the column may stray, in its SI unit.
        shortest: plateaus of fewer rows are left out; at least 2.

    Returns:
        A record of the level of `column`, the mean of every other column (`time` too), their
        sample standard deviations under `<name>_deviation`, and the `count` of rows averaged.
        `dropped` counts the rows of the plateaus left out.

    Raises:
        ParameterError: an argument is out of range.
        DataError: the column does not exist, a name is taken, or no plateau is long enough.
    """
    _check_settled(settled, tolerance, shortest)
    runs = _find_runs(record[column], tolerance)
    kept = [(first, last) for first, last in runs if last - first >= shortest]
    if not kept:
        raise DataError(
            f"Column `{column}` of record `{record.name}` has no plateau of at least "
            f"{shortest} rows; a staircase is held on its levels."
        )
    parts = [(max(first, last - _build_rows(settled, last - first)), last) for first, last in kept]
    others = [name for name in record.columns if name != column]
    table = {name: [fmean(record[name][a:b]) for a, b in parts] for name in others}
    table[column] = [record[column][first] for first, _ in kept]
    units = dict(record.units)
    for name in (*others, None):
        own = COUNT if name is None else name + DEVIATION
        if own in table:
            raise DataError(f"Record `{record.name}` has a column `{own}` already; rename it.")
        table[own] = [float(b - a) if name is None else stdev(record[name][a:b]) for a, b in parts]
        units[own] = "1" if name is None else record.units[name]
    dropped = len(record) - sum(last - first for first, last in kept)
    return Record(f"{record.name}, plateaus", table, units, record.source, dropped)


def supply_offset(table: Record, set_point: str, current: str, low: float, high: float) -> SupplyOffset:
    """Return the offset of a supply from plateaus on which the resistance does not change.

    Args:
        table: plateaus, as `plateaus` returns them.
        set_point: column of the set-point [V].
        current: column of the current [A].
        low: lowest set-point used [V].
        high: highest set-point used [V].

    Raises:
        DataError: fewer than 3 plateaus lie between, or their currents do not differ.
    """
    pairs = zip(table[current], table[set_point], strict=True)
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
