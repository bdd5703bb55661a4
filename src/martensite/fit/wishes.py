"""What a fit is asked for, as text: free parameters with bounds, noise, columns to compare.

A_s                          free, between bounds chosen from its declaration
A_s=40..90 degC              with bounds; either may be left out
A_s=40..90 degC@60 degC      with a start
position=laser*0.5           the output `position` is half the column `laser`
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.errors import InputError, ParameterError, UnitError, UnknownNameError
from martensite.fit.free import Wish, free_parameters
from martensite.fit.nuisance import DELAY, OFFSET

_WISH = re.compile(r"^\s*([^=@\s]+)\s*(?:=\s*([^@]*?)\s*)?(?:@\s*(.+?)\s*)?$")
_COLUMN = re.compile(r"^\s*([^=*]+?)\s*(?:=\s*([^*]+?)\s*(?:\*\s*(.+?)\s*)?)?$")
_AMOUNT = re.compile(r"^\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")
_NUMBER = re.compile(r"^[+-]?[\d.]+(?:[eE][+-]?\d+)?$")
DOTS = ".."


@dataclass(frozen=True)
class Compared:
    """An output that is to be compared with a column."""

    output: str
    column: str
    factor: float = 1.0
    """From the column in SI to the output in SI."""


def split_list(texts: str | Sequence[str]) -> list[str]:
    """Entries of a list that may be written with commas."""
    given = [texts] if isinstance(texts, str) else texts
    return [part.strip() for text in given for part in text.split(",") if part.strip()]


def read_wishes(
    texts: Iterable[str | Wish], systems: Sequence[AbstractSystem], own: bool = False
) -> list[Wish]:
    """Free parameters as asked for.

    Args:
        texts: one per parameter, see above.
        systems: those that have the parameters.
        own: whether every record has them for itself, so that offsets and delays may be asked for.

    Raises:
        InputError: a text cannot be read, or names no parameter.
    """
    return [
        text if isinstance(text, Wish) else _read_wish(text, systems, own)
        for text in ([texts] if isinstance(texts, (str, Wish)) else texts)
    ]


def _read_wish(text: str, systems: Sequence[AbstractSystem], own: bool) -> Wish:
    found = _WISH.match(text)
    if found is None:
        raise ParameterError(
            f"`{text}` is not a free parameter; write `NAME`, `NAME=LOW..HIGH UNIT`, or "
            "`NAME=LOW..HIGH UNIT@START UNIT`."
        )
    name, bounds, start = found.groups()
    if not own and (name == DELAY or name.partition(".")[0] == OFFSET):
        raise ParameterError(
            f"`{name}` belongs to a record, not to the system: ask for it under `each` (--each)."
        )
    if bounds is None and start is None:
        return Wish(name)
    unit, apart = _unit(name, systems)
    try:
        low, high = _bounds(bounds, unit, apart) if bounds is not None else (None, None)
        return Wish(name, low, high, None if start is None else _amount(start, unit, apart))
    except UnitError as error:
        raise UnitError(f"Free parameter `{name}`: {error}") from None


def _unit(name: str, systems: Sequence[AbstractSystem]) -> tuple[str, bool]:
    """SI unit of a free parameter, and whether its values are differences."""
    if name == DELAY:
        return "s", True
    head, _, output = name.partition(".")
    if head == OFFSET:
        known = systems[0].outputs()
        if output not in known:
            raise (
                UnknownNameError("output", output, known)
                if output
                else ParameterError(
                    "Bounds of `offset` need the output they are for, such as "
                    "`offset.strain=-0.1..0.1 %`."
                )
            )
        return known[output].unit, True
    return free_parameters([Wish(name)], systems)[0].unit, False


def _bounds(text: str, unit: str, apart: bool) -> tuple[float | None, float | None]:
    low, dots, high = (part.strip() for part in text.partition(DOTS))
    shown = "" if unit == "1" else f" {units.choose_readable_unit(unit)}"
    if not dots or not (low or high):
        raise UnitError(f"`{text}` is no range; write for example `1{DOTS}2{shown}`.")
    if _NUMBER.match(low) and (spelt := _AMOUNT.match(high)):
        low = f"{low} {spelt[2]}"
    return tuple(None if not end else _amount(end, unit, apart) for end in (low, high))  # type: ignore[return-value]


def _amount(text: str, unit: str, apart: bool) -> float:
    return read_difference(text, unit) if apart else units.parse_quantity(text, unit)


def read_difference(text: str, unit: str) -> float:
    """A difference in the SI `unit`, such as 0.5 K for `0.5 degC`.

    Raises:
        UnitError: the text is no number with a unit that fits.
    """
    zero = re.sub(_AMOUNT, lambda found: f"0 {found[2]}", text)
    return units.parse_quantity(text, unit) - units.parse_quantity(zero, unit)


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
            amount = _noise(str(given), name, known[name].unit)
        if not amount > 0.0:
            raise ParameterError(f"The noise of `{name}` must be above 0, but is {given}.")
        found[name] = amount
    return found


def _noise(text: str, name: str, unit: str) -> float:
    try:
        return read_difference(text, unit)
    except UnitError as error:
        raise UnitError(f"Noise of `{name}`: {error}") from None


def read_columns(columns: str | Sequence[str] | Mapping[str, str] | None) -> list[Compared]:
    """Outputs and the columns they are compared with; empty where none are named.

    Raises:
        InputError: an entry cannot be read.
    """
    if columns is None:
        return []
    if isinstance(columns, Mapping):
        columns = [f"{output}={column}" for output, column in columns.items()]
    found = [_column(text) for text in split_list(columns)]
    names = [one.output for one in found]
    double = next((name for name in names if names.count(name) > 1), None)
    if double is not None:
        raise InputError(f"Output `{double}` is compared with two columns; name one.")
    return found


def _column(text: str) -> Compared:
    found = _COLUMN.match(text)
    if found is not None:
        try:
            return Compared(found[1], found[2] or found[1], float(found[3] or 1.0))
        except ValueError:
            pass
    raise ParameterError(
        f"`{text}` is not a column to compare; write `OUTPUT`, `OUTPUT=COLUMN`, or "
        "`OUTPUT=COLUMN*FACTOR`."
    )
