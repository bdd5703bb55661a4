"""Columns over time as the page draws them: thinned out, with names and readable units."""

from __future__ import annotations

from martensite.app.messages import JsonTable
from martensite.base import units
from martensite.base.formats import choose_difference_unit
from martensite.simulate.result import Result

MOST_ROWS = 2001
"""Points that are drawn of a column; more cannot be told apart on a screen."""


def list_columns(result: Result) -> JsonTable:
    """Times [s], columns in SI, and what each is called.

    `outputs` gives for every column its SI unit, the unit it is shown in with factor and offset
    (shown = SI · factor + offset), its long name and its symbol.
    """
    kept = choose_rows(len(result.times))
    return {
        "times": [result.times[i] for i in kept],
        "columns": {name: [c[i] for i in kept] for name, c in result.columns.items()},
        "outputs": {name: describe_column(result, name) for name in result.columns},
    }


def choose_rows(count: int, most: int = MOST_ROWS) -> list[int]:
    """Rows, at most so many, first and last among them."""
    if count <= most:
        return list(range(count))
    return [round(i * (count - 1) / (most - 1)) for i in range(most)]


def describe_column(result: Result, name: str) -> JsonTable:
    """How a column is called, and how it is shown."""
    output = result.outputs[name]
    how = describe_display(name, output.unit)
    return {**how, "long_name": output.long_name, "symbol": output.symbol}


def describe_display(name: str, unit: str) -> JsonTable:
    """How a column or output is shown; strain in percent."""
    return describe_conversion(unit, units.of_column(name, unit))


def describe_difference(name: str, unit: str) -> JsonTable:
    """How an error or an offset is shown, which has no zero to be shifted."""
    spelling = units.of_column(name, unit)
    spelling = spelling if spelling == "%" else choose_difference_unit(unit)[0]
    return {**describe_conversion(unit, spelling), "offset": 0.0}


def describe_conversion(unit: str, spelling: str) -> JsonTable:
    """A SI unit, the unit it is shown in, and how: shown = SI · factor + offset."""
    offset = units.from_si(0.0, spelling, unit)
    return {
        "unit": unit,
        "shown": "" if spelling == "1" else spelling,
        "factor": units.from_si(1.0, spelling, unit) - offset,
        "offset": offset,
    }


def round_digits(value: float, digits: int = 5) -> float:
    """As much of a number as can be seen."""
    return float(f"{value:.{digits}g}")
