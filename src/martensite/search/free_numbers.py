"""Free parameters with bounds and scale (texts: `martensite.search.free_text`).

A search runs over fractions u from 0 to 1 of the range, one per free parameter:

    linear        p = low + u (high - low)
    logarithmic   p = low (high/low)^u        both bounds of one sign

Default bounds are a box around the start within the declared bounds: ±50 K for a temperature, and one fifth to five
times the start for a value with a sign. Finite declared bounds that contain zero are used in full. The scale is
logarithmic if both bounds are positive and their ratio is at least 4, except for temperatures.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, overload

from martensite.base import units
from martensite.base.errors import ParameterError, UnitError, suggest_name
from martensite.base.formats import write_quantity
from martensite.base.parameters import Leaf, find_paths
from martensite.search.free_text import FreeText, parse_free

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from martensite.simulate.waveform_levels import Level

BOX_TEMPERATURE = 50.0
"""Half the width of a box of temperatures [K]."""
BOX_FACTOR = 5.0
"""Factor of the box of a value with a sign: from the start divided by this factor to the start times this factor."""
LOG_RATIO = 4.0
"""Ratio of bounds from which a positive parameter has a logarithmic scale."""
BOUND_SHARE = 1e-3
"""Fraction of a range within which a value counts as at its bound."""
LISTS = "`martensite params SCENARIO` lists all"
"""Location of the list of all parameter names, for messages."""
_AMOUNT = re.compile(r"^\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")


@dataclass(frozen=True)
class Target:
    """Parameter that a search or a sweep can move."""

    name: str
    """Path in the scenario, for `--set`."""
    path: str
    """Path in the system, or in the waveform."""
    unit: str
    """SI unit."""
    value: float
    """Value in the scenario [SI]."""
    doc: str = ""
    drive: str | None = None
    """Drive of the waveform with this parameter; None for a parameter of the system."""
    bounds: tuple[float, float] = (-math.inf, math.inf)
    """Declared bounds [SI]."""
    allowed: str = "finite"
    """Bounds in words."""
    level: Level | None = None
    """Level of a waveform."""

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
            allowed=declared.describe_range(),
        )


@dataclass(frozen=True)
class SearchRange:
    """Request for a free parameter, by its path or an ending of it."""

    name: str
    low: float | None = None
    """Lower bound [SI]."""
    high: float | None = None
    start: float | None = None
    """Start, or centre of a spread [SI]; None for the value in the scenario."""
    scale: str | None = None
    """linear, log or whole."""
    spread: float = 0.0
    """Standard deviation about the centre [SI], or a fraction of it; 0 for none."""
    relative: bool = False
    """True if the spread is a fraction."""
    by: str = ""
    """Kind of group of records that have separate values; every record if empty."""
    choices: tuple[float, ...] = ()
    """Levels of a sweep [SI]; empty for a range."""
    count: int | None = None
    """Number of levels of a range in a sweep."""

    @classmethod
    def read(cls, text: FreeText | str, unit: str, convert: Callable[[str], float] | None = None) -> SearchRange:
        """Read a request from its text.

        Args:
            text: as in `martensite.search.free_text`. A text that is not parsed yet must be a range.
            unit: SI unit of the parameter.
            convert: conversion of a quantity to a value [SI], by default a quantity of the unit.

        Raises:
            ParameterError: the text is malformed, or a spread is not above 0.
            UnitError: a value is not a quantity of the unit.
        """
        words = parse_free(text) if isinstance(text, str) else text
        convert = convert or (lambda quantity: units.parse_quantity(quantity, unit))
        search_range = cls(words.name, scale=words.scale, by=words.by, count=words.count)
        try:
            if words.start is not None:
                search_range = replace(search_range, start=convert(words.start))
            if words.form == "spread":
                return _read_spread(search_range, words, unit, convert)
            values = [None if one is None else convert(one) for one in words.values]
        except UnitError as error:
            raise UnitError(f"Free parameter `{words.name}`: {error}") from None
        if words.form == "levels":
            return replace(search_range, choices=tuple(one for one in values if one is not None))
        return replace(search_range, low=values[0], high=values[1]) if values else search_range

    @property
    def ends(self) -> tuple[float, float]:
        """Return both bounds [SI]; NaN for a missing bound."""
        return math.nan if self.low is None else self.low, math.nan if self.high is None else self.high

    def write(self, unit: str) -> str:
        """Return the text of a range in an SI unit, which `read` can parse."""
        spelling = "" if unit == "1" else f" {'K' if unit == units.DEGREES else unit}"
        low, high = ("" if end is None else f"{end:.10g}" for end in (self.low, self.high))
        ends = f"={low}..{high}{spelling}" if high else f"={low}{spelling}.." if low else ""
        text = self.name + ends
        text += "" if self.start is None else f"@{self.start:.10g}{spelling}"
        return text + (f" {self.scale}" if self.scale else "")


def _read_spread(search_range: SearchRange, words: FreeText, unit: str, convert: Callable[[str], float]) -> SearchRange:
    centre, spread = words.values
    size = str(spread)
    relative = size.endswith("%")
    if relative and unit == "K":
        raise ParameterError(f"The spread of the temperature `{words.name}` must be a difference, such as `± 2 K`.")
    deviation = units.parse_quantity(size, "1") if relative else read_difference(size, unit)
    if not deviation > 0.0:
        raise ParameterError(f"The spread of `{words.name}` must be above 0, but is {size}.")
    return replace(
        search_range, start=convert(centre) if centre else search_range.start, spread=deviation, relative=relative
    )


def read_difference(text: str, unit: str) -> float:
    """Return a difference in the SI `unit`, such as 0.5 K for `0.5 degC`.

    Raises:
        UnitError: the text is not a quantity with a suitable unit.
    """
    zero = _AMOUNT.sub(lambda amount: f"0 {amount[2]}", text)
    return units.parse_quantity(text, unit) - units.parse_quantity(zero, unit)


@dataclass(frozen=True)
class FreeNumber:
    """Parameter that a search, a fit or a sweep moves."""

    name: str
    """Name as requested, unique in a problem; the common part of several names that move together."""
    path: str
    """Path, or ending of the paths, of all targets."""
    unit: str
    """SI unit."""
    start: float
    low: float
    high: float
    logarithmic: bool = False
    whole: bool = False
    record: str | None = None
    """Experiment or group with a separate value; None for a common parameter."""
    doc: str = ""
    targets: tuple[Target, ...] = ()
    """Parameters that take this value."""
    spread: float = 0.0
    """Standard deviation about the common centre: [SI], or a fraction of it; 0 for no spread."""
    relative: bool = False
    """True if the spread is a fraction."""
    base: str = ""
    """Path of the parameter from which this difference is counted; empty for a plain parameter."""
    choices: tuple[float, ...] = ()
    """Levels of a sweep [SI]; empty for a range."""
    count: int | None = None
    """Number of levels of a range on a grid."""

    @property
    def target(self) -> Target:
        """Return the first parameter that takes the value."""
        return self.targets[0]

    @overload
    def value(self, share: float) -> float: ...
    @overload
    def value(self, share: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def value(self, share: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
        """Return the value [SI] at a fraction of the range."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** share
        return self.low + share * (self.high - self.low)

    def slope(self, share: float) -> float:
        """Compute d(value)/d(fraction) [SI]."""
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
        """Return the width of the range in SI, or in powers of e on a logarithmic scale."""
        if self.logarithmic:
            return abs(math.log(self.high / self.low))
        return self.high - self.low

    def bound(self, share: float) -> str | None:
        """Return `lower` or `upper` if a fraction is at a bound."""
        if share <= BOUND_SHARE:
            return "lower"
        return "upper" if share >= 1.0 - BOUND_SHARE else None

    def levels(self) -> NDArray[np.float64]:
        """Return the values [SI] on a grid.

        Raises:
            ParameterError: there are no values.
        """
        import numpy as np

        if self.choices:
            return np.array(self.choices)
        if self.spread or self.count is None:
            raise ParameterError(
                f"Axis `{self.name}` has no levels for a grid; append a count to its range, such as `:9`, or "
                "choose another `--sample`."
            )
        return self.quantile(np.linspace(0.0, 1.0, self.count))

    def quantile(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the quantiles [SI] of fractions of a sample, exactly the bounds at 0 and 1."""
        import numpy as np

        if self.choices:
            return np.array(self.choices)[np.minimum((share * len(self.choices)).astype(int), len(self.choices) - 1)]
        if self.spread:
            from scipy.special import ndtri

            return self.start + self.spread * np.asarray(ndtri(share))
        return np.where(share >= 1.0, self.high, self.value(share))

    def extremes(self) -> tuple[float, ...]:
        """Return the extreme values of an axis; empty for an unbounded distribution."""
        return self.choices or (() if self.spread else (self.low, self.high))

    def moves(self, path: str) -> bool:
        """Return whether a parameter of this path takes the value."""
        return path == self.path or path.endswith("." + self.path)


def find_targets(name: str, all_targets: Iterable[Target]) -> list[Target]:
    """Return the parameters at a path in system or scenario, or otherwise all with this ending."""
    targets = list(all_targets)
    names = {*find_paths(name, [one.name for one in targets])}
    paths = {*find_paths(name, [one.path for one in targets])}
    if name in names or name in paths:
        names, paths = names & {name}, paths & {name}
    return [one for one in targets if one.name in names or one.path in paths]


def find_alike(name: str, all_targets: Sequence[Target], several: bool = True) -> list[Target]:
    """Return the parameters at a path or an ending of paths.

    Args:
        name: path, or ending of paths.
        all_targets: available parameters.
        several: True to accept several parameters of the same unit and value.

    Raises:
        ParameterError: there is no match, or several that differ.
    """
    targets = find_targets(name, all_targets)
    if not targets:
        raise make_missing_error(name, all_targets)
    if len(targets) > 1 and not (several and len({(one.unit, one.value) for one in targets}) == 1):
        raise ParameterError(f"`{name}` is ambiguous: {', '.join(one.name for one in targets)}.")
    return targets


def make_missing_error(name: str, all_targets: Iterable[Target]) -> ParameterError:
    """Return the error for an unknown parameter, with the nearest valid names."""
    names = [one.name for one in all_targets]
    endings = {one.rpartition(".")[2] for one in names} if "." not in name else {*names}
    return ParameterError(f"There is no parameter `{name}`. {suggest_name(name, endings, LISTS)}")


def build_free(wanted: SearchRange, targets: Sequence[Target], name: str, record: str | None = None) -> FreeNumber:
    """Return a free parameter with bounds and scale; the first target gives start, unit and declared bounds.

    Raises:
        ParameterError: there are no bounds, or they are invalid.
    """
    first = targets[0]
    start = first.value if wanted.start is None else wanted.start
    low, high = choose_bounds(wanted, first, [start])
    least, most = first.bounds
    ends = " and ".join(write_quantity(end, first.unit) for end in (low, high))
    if not (low < high and least <= low and high <= most):
        raise ParameterError(
            f"Bounds of the free parameter `{wanted.name}` must rise and lie within what is allowed "
            f"({first.allowed}), but are {ends}."
        )
    if wanted.scale == "log" and not low * high > 0.0:
        raise ParameterError(
            f"Bounds of the free parameter `{wanted.name}` on a logarithmic scale must be on one side "
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
    """Return the requested bounds, or a box around starts [SI] if not requested; the last start gives the sign.

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
    finite_starts = [start for start in starts if math.isfinite(start)]
    if target.unit == "K" and finite_starts:
        return max(min(finite_starts) - BOX_TEMPERATURE, least), min(max(finite_starts) + BOX_TEMPERATURE, most)
    sizes = [start for start in finite_starts if start != 0.0]
    if sizes:
        ends = [e for one in sizes if one * sizes[-1] > 0.0 for e in (one / factor, one * factor)]
        return max(min(ends), least), min(max(ends), most)
    if not (math.isfinite(least) and math.isfinite(most)):
        raise ParameterError(
            f"The free parameter `{name}` is {starts[0]:g} and its declaration sets no bounds; "
            f"write them, such as `{name}=low..high`."
        )
    return least, most
