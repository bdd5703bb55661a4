"""Table of the minimum and maximum values of a run, for screens and pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.base import units
from martensite.base.formats import show_quantity, typeset_unit
from martensite.base.summary import DataTable

if TYPE_CHECKING:
    from martensite.simulate.result import Result

ROUNDING = 1e-6
"""Fraction of the larger end of a range below which values are shown as 0."""
HEADINGS = ("quantity", "min", "max", "unit", "column")


def tabulate_ranges(result: Result) -> DataTable:
    """Return the lowest and highest value of each output of a run, with its unit and column name.

    Args:
        result: single run, loop or batch.

    Returns:
        A table with one row per output. The highest temperature of an element is left out if it is the temperature.
    """
    names = [name for name in result.outputs if not _repeats_temperature(result, name)]
    return DataTable(HEADINGS, [_write_row(result, name) for name in names], right=(1, 2))


def _write_row(result: Result, name: str) -> tuple[str, ...]:
    unit = result.unit(name)
    shown = units.of_column(name, unit)
    low, high = result.find_range(name)
    zero = ROUNDING * max(abs(low), abs(high))
    ends = (show_quantity(0.0 if abs(end) < zero else end, unit, 4, shown).partition(" ")[0] for end in (low, high))
    return (result.outputs[name].long_name, *ends, typeset_unit(shown), name)


def _repeats_temperature(result: Result, name: str) -> bool:
    head, _, last = name.rpartition("hottest")
    other = f"{head}temperature"
    return not last and other in result.outputs and result.find_range(name) == result.find_range(other)
