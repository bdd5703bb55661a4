"""Free numbers of a design: where they are, between which bounds, on which scale, whole or not.

A search runs over numbers z from 0 to 1, one per free number:

    linear        p = low + z (high - low)
    logarithmic   p = low (high/low)^z

Written as text: `element.diameter=0.05..0.5 mm`, with `linear`, `log` or `whole` behind it where
the scale shall not be chosen. By default the scale is logarithmic where both bounds are positive
and a factor of four apart, but for temperatures; whole is what the system refuses to be anything
between.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.errors import ParameterError, UnitError, suggest_name
from martensite.simulate.steered import PEAK, Level, Steering

TIMES = 5.0
"""Box of a number without bounds: start / TIMES to start * TIMES."""
DECADES = 4.0
"""Ratio of bounds from which a positive number is searched on its logarithm."""
NEAR = 1e-4
"""Part of a range from a bound that counts as being there."""
_FREE = re.compile(
    r"^\s*([^=\s]+)\s*(?:=\s*(\S.*?)\s*\.\.\s*(\S.*?))?(?:\s+(linear|log|whole))?\s*$"
)
_BARE = re.compile(r"^[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$")


@dataclass(frozen=True)
class Choice:
    """A number that could be free."""

    path: str
    """In the system; `drive.peak` or `drive.waveform.high` for a level of a waveform."""
    written: str
    """In the scenario."""
    unit: str
    """SI"""
    value: float
    bounds: tuple[float, float]
    """What its declaration allows."""
    allowed: str
    """The same in words."""
    level: Level | None = None


@dataclass(frozen=True)
class Free:
    """A number to be found."""

    name: str
    """As the scenario calls it; of several that move together what they have in common."""
    choices: tuple[Choice, ...]
    low: float
    high: float
    logarithmic: bool = False
    whole: bool = False

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.choices[0].unit

    @property
    def start(self) -> float:
        """Where it is in the scenario."""
        return self.choices[0].value

    def value(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """The number [SI] at shares z of its range."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** z
        return self.low + z * (self.high - self.low)

    def slope(self, z: float) -> float:
        """d(value)/dz [SI]."""
        if self.logarithmic:
            return float(self.value(np.array(z))) * math.log(self.high / self.low)
        return self.high - self.low

    def place(self, value: float) -> float:
        """The inverse of `value`, limited to [0, 1]."""
        within = min(max(value, self.low), self.high)
        if self.logarithmic:
            return math.log(within / self.low) / math.log(self.high / self.low)
        return (within - self.low) / (self.high - self.low)

    def bound(self, z: float) -> str | None:
        """`lower` or `upper` where z is at a bound."""
        return "lower" if z <= NEAR else "upper" if z >= 1.0 - NEAR else None


def choices(steering: Steering, written: Mapping[str, str] | None = None) -> list[Choice]:
    """All numbers of a system and levels of its waveforms.

    Args:
        steering: the system and its waveforms.
        written: path in the system -> path in the scenario, where they differ.
    """
    spelled, found = written or {}, list[Choice]()
    for leaf in steering.system.leaves():
        declared = leaf.declared
        found.append(Choice(
            leaf.path, spelled.get(leaf.path, leaf.path), declared.unit, float(leaf.value),
            declared.bounds, declared.allowed(),
        ))  # fmt: skip
    names = {drive.name: drive.unit for drive in steering.system.drives()}
    for level in steering.available():
        path = level_path(level.drive, level.name)
        found.append(Choice(
            path, spelled.get(path, path), names[level.drive], level.value,
            (-math.inf, math.inf), "finite", level,
        ))  # fmt: skip
    return found


def level_path(drive: str, name: str) -> str:
    """What a level of the waveform of a drive is called here."""
    return f"{drive}.{PEAK}" if name == PEAK else f"{drive}.waveform.{name}"


def found_choices(name: str, known: Sequence[Choice]) -> tuple[Choice, ...]:
    """The numbers that a path, or an ending of paths, names; several must be alike.

    Raises:
        ParameterError: there is none, or several that differ.
    """
    found = [c for c in known if name in (c.path, c.written)] or [
        c for c in known if c.path.endswith(f".{name}") or c.written.endswith(f".{name}")
    ]
    if not found:
        endings = {c.written for c in known} | {c.written.rpartition(".")[2] for c in known}
        raise ParameterError(f"There is no number `{name}`. {_nearest(name, endings)}")
    if len({(c.unit, c.value) for c in found}) > 1:
        listed = ", ".join(f"`{c.written}`" for c in found)
        raise ParameterError(f"`{name}` is ambiguous: {listed}.")
    return tuple(found)


def _nearest(name: str, endings: set[str]) -> str:
    """A suggestion, or where to find a list, which is long."""
    told = suggest_name(name, endings)
    if told.startswith("Valid"):
        return "`martensite params` lists those of every component."
    return told.partition(" Valid")[0]


def read_free(text: str, known: Sequence[Choice], system: AbstractSystem) -> Free:
    """A free number from a text such as `element.diameter=0.05..0.5 mm`.

    Raises:
        ParameterError: it is no such text, an unknown name, or bounds that are none.
        UnitError: a bound is no quantity in the unit of the number.
    """
    match = _FREE.match(text)
    if match is None:
        raise ParameterError(
            f"`{text}` is no free number; write its path, bounds and a unit, such as "
            "`element.diameter=0.05..0.5 mm`."
        )
    name, low, high, scale = match.groups()
    found = found_choices(name, known)
    ends = _box(name, found[0]) if low is None else _bounds(text, low, high, found[0])
    _check(text, ends, found[0])
    whole = scale == "whole" or (scale is None and _is_whole(system, found[0], ends))
    positive = ends[0] > 0.0 and ends[1] / ends[0] >= DECADES and found[0].unit != "K"
    if scale == "log" and not ends[0] > 0.0:
        raise ParameterError(f"`{text}`: bounds on a logarithmic scale must be above 0.")
    if whole and (ends[0] != round(ends[0]) or ends[1] != round(ends[1])):
        raise ParameterError(f"`{text}`: bounds of a whole number must be whole numbers.")
    written = found[0].written if len(found) == 1 else name
    return Free(written, found, *ends, scale == "log" or (scale != "linear" and positive), whole)


def _box(name: str, one: Choice) -> tuple[float, float]:
    """Bounds where none are asked for: around the number of the scenario."""
    if one.value == 0.0 or not math.isfinite(one.value) or one.unit == "K":
        raise ParameterError(
            f"The free number `{name}` needs bounds; write them, such as `{name}=low..high`."
        )
    ends = sorted((one.value / TIMES, one.value * TIMES))
    return max(ends[0], one.bounds[0]), min(ends[1], one.bounds[1])


def _bounds(text: str, low: str, high: str, one: Choice) -> tuple[float, float]:
    """Bounds as they are written; a unit behind the second holds for both."""
    try:
        top = units.parse_quantity(high, one.unit)
        if _BARE.match(low) and not _BARE.match(high):
            _, spelling = _split(high)
            return units.to_si(float(low), spelling, one.unit), top
        return units.parse_quantity(low, one.unit), top
    except UnitError as error:
        raise UnitError(f"Bounds of `{text}`: {error}") from None


def _split(quantity: str) -> tuple[str, str]:
    """Number and unit of a quantity."""
    match = re.match(r"^\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*)$", quantity)
    return (match[1], match[2]) if match else (quantity, "")


def _check(text: str, ends: tuple[float, float], one: Choice) -> None:
    low, high = ends
    if not (low < high and one.bounds[0] <= low and high <= one.bounds[1]):
        raise ParameterError(
            f"Bounds of `{text}` must rise and lie within what is allowed: {one.allowed}."
        )


def _is_whole(system: AbstractSystem, one: Choice, ends: tuple[float, float]) -> bool:
    """Whether the system takes whole numbers only."""
    if one.unit != "1" or one.level is not None or ends[1] < ends[0] + 1.0:
        return False
    whole = math.ceil(ends[0])
    return _takes(system, one.path, whole) and not _takes(system, one.path, whole + 0.5)


def _takes(system: AbstractSystem, path: str, value: float) -> bool:
    try:
        system.with_values({path: value})
    except ParameterError:
        return False
    return True
