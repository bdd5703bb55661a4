"""Columns over time for the page: thinned, with names and readable units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from martensite.app.messages import JsonTable
from martensite.base import units
from martensite.base.formats import choose_difference_unit
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.result import Result

MOST_ROWS = 2001
"""Largest number of drawn points of a column."""
MOST_CORNERS = 400
"""Largest number of drawn points of a curve."""


def list_columns(result: Result) -> JsonTable:
    """Return times [s] and columns in SI at samples and accepted steps, with ends and names of the columns.

    `ends` are the lowest and the highest value of each column in the run. `outputs` gives for each column its SI unit,
    the displayed unit with factor and offset (displayed number = SI · factor + offset), its long name and its symbol.
    """
    fine = add_step_rows(result)
    rows = choose_curve_rows(fine)
    return {
        "times": fine.times[rows].tolist(),
        "columns": {name: c[rows].tolist() for name, c in fine.columns.items()},
        "ends": {name: list(result.find_range(name)) for name in result.columns},
        "outputs": {name: describe_column(result, name) for name in result.columns},
    }


def choose_rows(count: int, most: int = MOST_ROWS) -> list[int]:
    """Return at most `most` rows, including first and last."""
    if count <= most:
        return list(range(count))
    return [round(i * (count - 1) / (most - 1)) for i in range(most)]


def choose_curve_rows(result: Result) -> list[int]:
    """Return the drawn rows of a run: evenly spaced, and the extremes of each column."""
    rows = choose_rows(len(result.times))
    if len(rows) == len(result.times):
        return rows
    ends = [place for name in result.columns for place in (int(result[name].argmin()), int(result[name].argmax()))]
    return sorted({*rows, *ends})


def describe_column(result: Result, name: str) -> JsonTable:
    """Return the name and the display of a column."""
    output = result.outputs[name]
    how = describe_display(name, output.unit)
    return {**how, "long_name": output.long_name, "symbol": output.symbol}


def describe_display(name: str, unit: str) -> JsonTable:
    """Return the display of a column or output; strain in percent."""
    return describe_conversion(unit, units.of_column(name, unit))


def describe_difference(name: str, unit: str) -> JsonTable:
    """Return the display of an error or an offset, without a shift of zero."""
    return {**describe_conversion(unit, choose_difference_unit(unit, name)[0]), "offset": 0.0}


def describe_conversion(unit: str, spelling: str) -> JsonTable:
    """Return SI unit, displayed unit, and conversion: displayed number = SI · factor + offset."""
    offset = units.from_si(0.0, spelling, unit)
    return {
        "unit": unit,
        "display_unit": "" if spelling == "1" else spelling,
        "factor": units.from_si(1.0, spelling, unit) - offset,
        "offset": offset,
    }


def round_digits(value: float, digits: int = 5) -> float:
    """Return a number rounded to the visible digits."""
    return float(f"{value:.{digits}g}")


def find_envelope(numbers: Any, most: int = MOST_CORNERS) -> list[int]:
    """Return the rows of a long column that keep its extremes."""
    import numpy as np

    count = len(numbers)
    if count <= most:
        return list(range(count))
    values = np.asarray(numbers, float)
    rows = {0, count - 1}
    for part in np.array_split(np.arange(count), most // 2):
        finite = part[np.isfinite(values[part])]
        if len(finite):
            rows |= {int(finite[values[finite].argmin()]), int(finite[values[finite].argmax()])}
    return sorted(rows)


def find_corners(times: Sequence[float], values: Sequence[float], most: int = 150) -> list[int]:
    """Return the corners of a piecewise linear approximation (Douglas and Peucker, 1973).

    The row farthest from the lines so far is added until `most` are kept, or all others are nearer than a thousandth of
    the range.
    """
    import numpy as np

    t, y = np.asarray(times, float), np.asarray(values, float)
    near = 1e-3 * float(np.ptp(y)) or 1.0
    chosen, pieces = {0, len(t) - 1}, [_find_farthest(t, y, 0, len(t) - 1)]
    while pieces and len(chosen) < most:
        pieces.sort(key=lambda piece: piece[0])
        distance, row, first, last = pieces.pop()
        if distance <= near:
            break
        chosen.add(row)
        pieces += [_find_farthest(t, y, a, b) for a, b in ((first, row), (row, last)) if b - a > 1]
    return sorted(chosen)


def _find_farthest(t: Any, y: Any, first: int, last: int) -> tuple[float, int, int, int]:
    """Return distance and index of the row farthest from the line between two rows."""
    import numpy as np

    inside = slice(first, last + 1)
    line = np.interp(t[inside], [t[first], t[last]], [y[first], y[last]])
    apart = np.abs(y[inside] - line)
    return float(apart.max()), first + int(apart.argmax()), first, last
