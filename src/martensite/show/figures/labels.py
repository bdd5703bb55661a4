"""Axis labels: symbol and unit, and values in that unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.base.formats import choose_difference_unit, typeset_unit
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

FRACTIONS = ("martensite_fraction",)


@dataclass(frozen=True)
class QuantityAxis:
    """Display of one quantity."""

    name: str
    """Column of the result, or `time`."""
    long_name: str
    symbol: str
    unit: str
    """SI unit of the column."""
    display_unit: str
    """Displayed unit, in the spelling of `martensite.base.units`."""

    @property
    def label(self) -> str:
        """Return symbol and unit, such as T [°C]."""
        return f"{typeset_symbol(self.symbol)} [{typeset_unit(self.display_unit, '–')}]"

    @property
    def difference_unit(self) -> str:
        """Return the unit of a difference of two values, for text."""
        return "K" if self.display_unit == "degC" else typeset_unit(self.display_unit)

    def values(self, column: ArrayLike) -> Any:
        """Return a column in SI as an array in the displayed unit."""
        factor, offset = units.find_conversion(self.display_unit, self.unit)
        return (np.asarray(column, dtype=np.float64) - offset) / factor


TEMPERATURE = QuantityAxis("temperature", "temperature", "T", "K", "degC")
STRESS = QuantityAxis("stress", "stress", "σ", "Pa", "MPa")
STRAIN = QuantityAxis("strain", "strain", "ε", "1", "%")


def describe_axis(result: Result, name: str) -> QuantityAxis:
    """Return the display of a column of a result, or of `time`."""
    unit = result.unit(name)
    if name == "time":
        return QuantityAxis(name, "time", "t", unit, unit)
    _, long_name, symbol = result.outputs[name]
    return QuantityAxis(name, long_name, symbol, unit, units.of_column(name, unit))


def read_column(result: Result, name: str) -> Any:
    """Return a column of a result as an array in its displayed unit."""
    return describe_axis(result, name).values(result[name])


def typeset_symbol(symbol: str) -> str:
    """Return a symbol such as ξ_S as italic mathematics with its subscript; words are unchanged."""
    if " " in symbol:
        return symbol.replace("$", "")
    head, _, index = symbol.partition("_")
    return f"${head}_{{{index}}}$" if index else f"${head}$"


def choose_limits(name: str, *columns: Any) -> tuple[float, float]:
    """Return axis limits around all finite values, in the displayed unit; fractions span at least 0 to 1."""
    low, high = enclose_values(*columns)
    if name.rpartition(".")[-1] in FRACTIONS:
        return min(low, -0.06), max(high, 1.06)
    return low, high


def enclose_values(*columns: Any, least: float = 1e-3) -> tuple[float, float]:
    """Return limits around all finite values, with a minimum range for constants."""
    values = np.concatenate([np.ravel(c) for c in columns])
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    size = max(abs(low), abs(high))
    if high - low <= least * size or size == 0.0:
        room = 0.1 * size or 1.0
        return low - room, high + room
    room = 0.07 * (high - low)
    return low - room, high + room


def label_difference(unit: str) -> tuple[str, float]:
    """Return the typeset unit of a difference, and its size in the SI `unit`."""
    display_unit, size = choose_difference_unit(unit)
    return typeset_unit(display_unit, "1"), size


def label_ratio(above: str, below: str) -> tuple[str, float]:
    """Return the label and factor of one unit over another; `–` if they cancel."""
    (top, over), (bottom, under) = label_difference(above), label_difference(below)
    if top == bottom:
        return "–", 1.0
    return top if bottom == "1" else f"{top}/{bottom}", over / under
