"""Free numbers: what may move, between which bounds, on which scale. One grammar for all searches.

    A_s                                  between bounds chosen from its declaration
    A_s=40..90 degC                      with bounds; either may be left out
    A_s=40..90 degC@60 degC              with a start
    element.diameter=0.05..0.5 mm log    on a scale: linear, log, or whole numbers
    A_f-A_s=2..60 degC                   in a fit: how far A_f lies above A_s, which may be free itself

A search runs over shares u from 0 to 1 of the range, one per free number:

    linear        p = low + u (high - low)
    logarithmic   p = low (high/low)^u        both bounds of one sign

Bounds that are not asked for are a box around the start inside what is declared: 50 K to both
sides of a temperature, the fifth to the fivefold of what has a sign, all that is declared where
this is finite and holds a zero. The scale is logarithmic where both bounds are positive and a
factor of four apart, but for temperatures.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, overload

from martensite.base import units
from martensite.base.errors import ParameterError, UnitError
from martensite.base.formats import write_quantity
from martensite.base.parameters import Leaf, find_paths

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from martensite.simulate.waveform_levels import Level

BOX_TEMPERATURE = 50.0
"""Half the width of a box of temperatures [K]."""
BOX_FACTOR = 5.0
"""Box of a number of one sign: from the start over this factor to the start times it."""
LOG_RATIO = 4.0
"""Ratio of bounds from which a positive number is searched on its logarithm."""
BOUND_SHARE = 1e-3
"""Part of a range from a bound that counts as being there."""
_FREE = re.compile(r"^\s*([^=@\s]+)\s*(?:=\s*([^@]*?))?\s*(?:@\s*(.+?))?(?:\s+(linear|log|whole))?\s*$")
_RANGE = re.compile(r"^\s*(.*?)\s*\.\.\s*(.*?)\s*(?::\s*(\d+))?(?:\s+(linear|log|whole))?\s*$")
_NUMBER = re.compile(r"^[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class Target:
    """A number that a search or a sweep can move."""

    name: str
    """Path in the scenario, for `--set`."""
    path: str
    """Path in the system, or in the waveform."""
    unit: str
    """SI unit."""
    value: float
    """In the scenario [SI]."""
    doc: str = ""
    drive: str | None = None
    """Drive of the waveform that has it; None for a parameter of the system."""
    bounds: tuple[float, float] = (-math.inf, math.inf)
    """Bounds of its declaration [SI]."""
    allowed: str = "finite"
    """Bounds in words."""
    level: Level | None = None
    """The level of a waveform that it is."""

    @classmethod
    def from_leaf(cls, leaf: Leaf, name: str | None = None) -> Target:
        """Return a parameter of a system, under its path in the scenario."""
        declared = leaf.declared
        return cls(
            leaf.path if name is None else name,
            leaf.path,
            declared.unit,
            float(leaf.value),
            declared.doc,
            bounds=declared.bounds,
            allowed=declared.allowed(),
        )


@dataclass(frozen=True)
class SearchRange:
    """A number that is asked to be free, by its path or an ending of it; None is chosen."""

    name: str
    low: float | None = None
    """Lower bound [SI]."""
    high: float | None = None
    start: float | None = None
    """Start value [SI]; None for the value in the scenario."""
    scale: str | None = None
    """linear, log or whole."""
    spread: float = 0.0
    """Standard deviation about the centre that several have in common: [SI], or a share of it; 0 for none."""
    relative: bool = False
    """True if the spread is a fraction."""
    by: str = ""
    """Kind of group of records that have separate values; every record if empty."""


@dataclass(frozen=True)
class FreeNumber:
    """A number to be found."""

    name: str
    """Name as requested, unique in a problem; for several that move together their common part."""
    path: str
    """Path, or ending of the paths of all parameters that take its value."""
    unit: str
    """SI unit."""
    start: float
    low: float
    high: float
    logarithmic: bool = False
    whole: bool = False
    record: str | None = None
    """The one experiment, or group of them, that has it for itself; None if it is common to all."""
    doc: str = ""
    targets: tuple[Target, ...] = ()
    """Parameters that take its value."""
    spread: float = 0.0
    """Standard deviation about the centre that several have in common: [SI], or a share of it; 0 for none."""
    relative: bool = False
    """True if the spread is a fraction."""
    base: str = ""
    """Path of the number from which this one is counted, so that order holds by construction; empty for none."""

    @overload
    def value(self, share: float) -> float: ...
    @overload
    def value(self, share: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def value(self, share: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
        """Return the number [SI] at a share of its range."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** share
        return self.low + share * (self.high - self.low)

    def slope(self, share: float) -> float:
        """d(value)/d(share) [SI]."""
        if self.logarithmic:
            return self.value(share) * math.log(self.high / self.low)
        return self.high - self.low

    def share(self, value: float) -> float:
        """Return the inverse of `value`, limited to [0, 1]."""
        within = min(max(value, self.low), self.high)
        if self.logarithmic:
            return math.log(within / self.low) / math.log(self.high / self.low)
        return (within - self.low) / (self.high - self.low)

    @property
    def width(self) -> float:
        """Return the range in units of the number, or in powers of e on a logarithmic scale."""
        if self.logarithmic:
            return abs(math.log(self.high / self.low))
        return self.high - self.low

    def bound(self, share: float) -> str | None:
        """`lower` or `upper` where a share is at a bound."""
        if share <= BOUND_SHARE:
            return "lower"
        return "upper" if share >= 1.0 - BOUND_SHARE else None

    def moves(self, path: str) -> bool:
        """Return whether a parameter of this path takes the value."""
        return path == self.path or path.endswith("." + self.path)


def find_targets(name: str, known: Iterable[Target]) -> list[Target]:
    """Return the numbers of a path in system or scenario, or else all whose paths it ends."""
    targets = list(known)
    names = {*find_paths(name, [one.name for one in targets])}
    paths = {*find_paths(name, [one.path for one in targets])}
    if name in names or name in paths:
        names, paths = names & {name}, paths & {name}
    return [one for one in targets if one.name in names or one.path in paths]


def parse_free(text: str) -> tuple[str, str | None, str | None, str | None]:
    """Parse name, bounds, start and scale of a free parameter, as texts.

    Raises:
        ParameterError: the text is not a free parameter.
    """
    match = _FREE.match(text)
    if match is None or ".." in match[1]:
        raise ParameterError(
            f"`{text}` is no free number; write `NAME`, `NAME=LOW..HIGH UNIT`, or "
            "`NAME=LOW..HIGH UNIT@START UNIT`, such as `element.diameter=0.05..0.5 mm`."
        )
    name, bounds, start, scale = match.groups()
    return name, bounds, start, scale


def read_free(text: str, unit: str, read: Callable[[str], float]) -> SearchRange:
    """Read a free parameter in an SI unit from its text, as written above; `read` converts a quantity to a number [SI].

    Raises:
        ParameterError: the text is not a free parameter.
        UnitError: a bound or the start is not a quantity in the unit of the parameter.
    """
    name, bounds, start, scale = parse_free(text)
    try:
        low, high, _, _ = (None,) * 4 if bounds is None else parse_range(bounds, unit, read)
        return SearchRange(name, low, high, None if start is None else read(start), scale)
    except UnitError as error:
        raise UnitError(f"Free number `{name}`: {error}") from None


def parse_range(
    text: str, unit: str, read: Callable[[str], float]
) -> tuple[float | None, float | None, int | None, str | None]:
    """Parse bounds, count and scale of a range such as `20..200 W/m^2/K:5 log`.

    A unit behind the second bound holds for both.

    Raises:
        UnitError: the text is not a range, or a bound is not a quantity in the unit.
    """
    match = _RANGE.match(text)
    if match is None or not (match[1] or match[2]):
        shown = "" if unit == "1" else f" {units.choose_readable_unit(unit)}"
        raise UnitError(f"`{text}` is no range; write for example `1..2{shown}`.")
    low, high, count, scale = match.groups()
    behind = _NUMBER.match(high)
    if behind and is_bare(low):
        low = f"{low} {high[behind.end() :]}".strip()
    ends = [read(end) if end else None for end in (low, high)]
    return ends[0], ends[1], int(count) if count else None, scale


def is_bare(text: str) -> bool:
    """Return whether a text is a number without a unit."""
    match = _NUMBER.match(text)
    return match is not None and match.end() == len(text)


def build_free(wanted: SearchRange, targets: Sequence[Target], name: str, record: str | None = None) -> FreeNumber:
    """Return a free number with its bounds and scale; the first target gives start, unit and what is allowed.

    Raises:
        ParameterError: there are no bounds, or they are none.
    """
    first = targets[0]
    start = first.value if wanted.start is None else wanted.start
    low, high = choose_bounds(wanted, first, [start])
    least, most = first.bounds
    ends = " and ".join(write_quantity(end, first.unit) for end in (low, high))
    if not (low < high and least <= low and high <= most):
        raise ParameterError(
            f"Bounds of the free number `{wanted.name}` must rise and lie within what is allowed "
            f"({first.allowed}), but are {ends}."
        )
    if wanted.scale == "log" and not low * high > 0.0:
        raise ParameterError(
            f"Bounds of the free number `{wanted.name}` on a logarithmic scale must be on one side "
            f"of 0, but are {ends}."
        )
    wide = low > 0.0 and high / low >= LOG_RATIO and first.unit != "K"
    return FreeNumber(
        name,
        wanted.name,
        first.unit,
        start,
        low,
        high,
        wanted.scale == "log" or (wanted.scale != "linear" and wide),
        wanted.scale == "whole",
        record,
        first.doc,
        tuple(targets),
    )


def choose_bounds(
    wanted: SearchRange, target: Target, starts: Sequence[float], factor: float = BOX_FACTOR
) -> tuple[float, float]:
    """Return bounds as asked for, and a box around starts [SI] where they are not; the last of these gives the sign.

    Raises:
        ParameterError: all starts are 0, and the declaration sets no bounds.
    """
    low, high = wanted.low, wanted.high
    if low is None or high is None:
        box = _choose_box(wanted.name, target, starts, factor)
        low, high = box[0] if low is None else low, box[1] if high is None else high
    return low, high


def _choose_box(name: str, target: Target, starts: Sequence[float], factor: float) -> tuple[float, float]:
    least, most = target.bounds
    known = [start for start in starts if math.isfinite(start)]
    if target.unit == "K" and known:
        return max(min(known) - BOX_TEMPERATURE, least), min(max(known) + BOX_TEMPERATURE, most)
    sizes = [start for start in known if start != 0.0]
    if sizes:
        ends = [e for one in sizes if one * sizes[-1] > 0.0 for e in (one / factor, one * factor)]
        return max(min(ends), least), min(max(ends), most)
    if not (math.isfinite(least) and math.isfinite(most)):
        raise ParameterError(
            f"The free number `{name}` is {starts[0]:g} and its declaration sets no bounds; "
            f"write them, such as `{name}=low..high`."
        )
    return least, most
