"""How far a slider goes: around the value, within the declared bounds.

Logarithmic where what is declared spans decades and is positive, else linear. A number that is 0,
or for which there is no limit, gives no scale of its own; ordinary sizes of its unit stand in.
"""

from __future__ import annotations

import math
import re

from martensite.app.forms.form_types import SliderRange
from martensite.base.parameters import Declared

SIZES = {
    "1": 1.0,
    "N": 5.0,
    "V": 5.0,
    "A": 1.0,
    "W": 1.0,
    "m": 0.01,
    "s": 10.0,
    "ohm": 5.0,
    "Pa": 1e8,
    "kg": 0.5,
    "Hz": 10.0,
    "rad": 1.0,
    "delta_degC": 20.0,
    "J/kg": 3e4,
    "N/m": 500.0,
    "m/s": 1.0,
    "N*m": 0.05,
    "N*m/rad": 0.05,
    "N*m*s/rad": 1e-4,
    "W/m^2/K": 100.0,
    "Pa/K": 1e6,
    "m/s^2": 20.0,
}
"""Unit -> what is ordinary of it, for numbers that are 0."""
KELVINS = 60.0
"""Temperatures go so far to either side [K]."""
DECADES = 100.0
"""A range whose ends have this ratio spans decades."""
LARGEST = 1e6
"""From here on a default that is the largest allowed value means that there is no limit."""
_COUNTS = re.compile(r"\bnumber of|how many|whole number|^spans\b|^steps of")


def is_whole(value: float, declared: Declared) -> bool:
    """Whether a number counts something, as its meaning says."""
    return declared.unit == "1" and value == int(value) and bool(_COUNTS.search(declared.doc))


def is_unlimited(value: float, declared: Declared) -> bool:
    """Whether a number says that there is no limit: infinite, or the largest by default."""
    largest = value == declared.high == declared.default and value >= LARGEST
    return not math.isfinite(value) or largest


def build_slider(value: float, declared: Declared) -> SliderRange | None:
    """Ends of a slider in SI, whether it is logarithmic and goes in whole numbers; None for none.

    There is none for a number that says that there is no limit.
    """
    if is_unlimited(value, declared):
        return None
    low, high, log = _choose_ends(value, declared)
    low, high = max(low, declared.low), min(high, declared.high)
    if declared.open_low and low <= declared.low:
        low = declared.low + (high - declared.low) / 200.0
    if not low < high:
        return None
    whole = is_whole(value, declared)
    if whole:
        low, high = math.ceil(low), math.floor(high)
    return {"low": min(low, value), "high": max(high, value), "log": log, "whole": whole}


def _choose_ends(value: float, declared: Declared) -> tuple[float, float, bool]:
    (low, high), unit = declared.bounds, declared.unit
    if unit == "K":
        return value - KELVINS, value + KELVINS, False
    if low < 0.0:
        return _choose_signed_ends(value, unit, low, high)
    if unit == "1" and high <= 1.0 and (not declared.open_low or value > high / 50.0):
        return low, high, False
    decades = declared.open_low if low == 0.0 else high >= DECADES * low
    if decades and value > 0.0:
        return value / 10.0, value * 10.0, True
    if math.isfinite(high) and high <= 20.0 * max(value, low):
        return low, high, False
    size = 3.0 * value if value > 0.0 else SIZES.get(unit, 1.0)
    return low, size, False


def _choose_signed_ends(value: float, unit: str, low: float, high: float) -> tuple[float, float, bool]:
    """Ends for a number that may be negative; a level is positive unless it is not."""
    if math.isfinite(low) and math.isfinite(high) and high - low <= 20.0 * abs(value):
        return low, high, False
    size = 3.0 * abs(value) if value else SIZES.get(unit, 1.0)
    if math.isinf(low) and value >= 0.0:
        return 0.0, size, False
    return -size, size, False
