"""Texts of names, amounts and changes in everyday units."""

from __future__ import annotations

import math
from collections.abc import Sequence

from martensite.base.formats import choose_difference_unit
from martensite.base.units import choose_readable_unit, from_si


def format_number(value: float, digits: int = 4) -> str:
    """Return a number with the given digits, without an exponent if it is readable."""
    return f"{float(f'{value:.{digits}g}'):g}"


def format_quantity(value: float, unit: str) -> str:
    """Return a value given in the SI `unit`: `47.5 degC`."""
    spelling = choose_readable_unit(unit)
    return _append_unit(from_si(value, spelling, unit), spelling)


def format_change(amount: float, unit: str, digits: int = 4) -> str:
    """Return a difference given in the SI `unit`: `5 K`, if the value itself is in degC."""
    spelling, factor = choose_difference_unit(unit)
    return _append_unit(amount / factor, spelling, digits)


def format_quotient(above: str, below: str) -> str:
    """Return the unit of a ratio: `K/MPa`, `MPa/(MPa/K)`; empty for two plain numbers."""
    if above == below or below == "1":
        return "" if above in ("1", below) else above
    return f"{above}/({below})" if "/" in below else f"{above}/{below}"


def list_names(names: Sequence[str]) -> str:
    """Return the names in backquotes: "`a`, `b` and `c`"."""
    return join_phrases([f"`{name}`" for name in names])


def join_phrases(phrases: Sequence[str]) -> str:
    """Return the phrases as a list: "this, that and the other"."""
    if len(phrases) < 2:
        return "".join(phrases)
    return f"{', '.join(phrases[:-1])} and {phrases[-1]}"


def round_below(value: float) -> float:
    """Return the largest of …, 0.1, 0.2, 0.5, 1, 2, 5, 10, … that is not above a positive value."""
    decade = 10.0 ** math.floor(math.log10(value))
    return max((m * decade for m in (1.0, 2.0, 5.0) if m * decade <= value), default=decade)


def _append_unit(value: float, spelling: str, digits: int = 4) -> str:
    return format_number(value, digits) + (f" {spelling}" if spelling != "1" else "")
