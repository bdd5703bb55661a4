"""Columns of a log that are compared, and the noise of what is measured, as text.

position=laser*0.5           the output `position` is half the column `laser`
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, ParameterError, UnitError, UnknownNameError
from martensite.fit.free_parameters import read_difference, split_list

_COLUMN = re.compile(r"^\s*([^=*]+?)\s*(?:=\s*([^*]+?)\s*(?:\*\s*(.+?)\s*)?)?$")


@dataclass(frozen=True)
class ComparedColumn:
    """An output that is to be compared with a column."""

    output: str
    column: str
    factor: float = 1.0
    """From the column in SI to the output in SI."""


def read_noise(
    noise: Mapping[str, str | float], systems: Sequence[AbstractSystem]
) -> dict[str, float]:
    """Standard deviations of measured outputs in SI; numbers are in SI already.

    Raises:
        InputError: an output is unknown, or an amount is not above 0.
    """
    known = systems[0].outputs()
    found: dict[str, float] = {}
    for name, given in noise.items():
        if name not in known:
            raise UnknownNameError("output", name, known)
        try:
            amount = float(given)
        except ValueError:
            amount = _read_noise(str(given), name, known[name].unit)
        if not amount > 0.0:
            raise ParameterError(f"The noise of `{name}` must be above 0, but is {given}.")
        found[name] = amount
    return found


def _read_noise(text: str, name: str, unit: str) -> float:
    try:
        return read_difference(text, unit)
    except UnitError as error:
        raise UnitError(f"Noise of `{name}`: {error}") from None


def read_columns(columns: str | Sequence[str] | Mapping[str, str] | None) -> list[ComparedColumn]:
    """Outputs and the columns they are compared with; empty where none are named.

    Raises:
        InputError: an entry cannot be read.
    """
    if columns is None:
        return []
    if isinstance(columns, Mapping):
        columns = [f"{output}={column}" for output, column in columns.items()]
    found = [_read_column(text) for text in split_list(columns)]
    names = [one.output for one in found]
    double = next((name for name in names if names.count(name) > 1), None)
    if double is not None:
        raise InputError(f"Output `{double}` is compared with two columns; name one.")
    return found


def _read_column(text: str) -> ComparedColumn:
    found = _COLUMN.match(text)
    if found is not None:
        try:
            return ComparedColumn(found[1], found[2] or found[1], float(found[3] or 1.0))
        except ValueError:
            pass
    raise ParameterError(
        f"`{text}` is not a column to compare; write `OUTPUT`, `OUTPUT=COLUMN`, or "
        "`OUTPUT=COLUMN*FACTOR`."
    )
