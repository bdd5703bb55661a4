"""Differences and rates on axes: a readable unit without its zero."""

from __future__ import annotations

from martensite.base import units

_PRINTED = {"degC": "K", "ohm": "Ω"}


def difference(unit: str) -> tuple[str, float]:
    """The unit in which a difference is read, as it is printed, and its size in SI.

    Args:
        unit: in SI.
    """
    shown = units.choose_readable_unit(unit)
    return _PRINTED.get(shown, shown), units.find_conversion(shown, unit)[0]


def ratio(above: str, below: str) -> tuple[str, float]:
    """The same for one unit over another; `–` where they cancel."""
    (top, over), (bottom, under) = difference(above), difference(below)
    if top == bottom:
        return "–", 1.0
    return top if bottom == "1" else f"{top}/{bottom}", over / under
