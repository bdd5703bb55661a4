"""Axes of a sweep: what is varied, and over which numbers.

    diameter=0.1..0.5 mm:9          nine numbers from 0.1 mm to 0.5 mm; without `:9`, a range
    cooling.h=20..200 W/m^2/K:5 log spread evenly on a logarithmic scale
    A_s=68, 70, 72 degC             these numbers
    length=250 mm +- 2 %            a normal distribution of this mean and standard deviation

An axis has levels, which a grid takes, and quantiles, through which a sample of the unit interval
becomes one of the axis.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base import units
from martensite.base.errors import ParameterError, UnitError
from martensite.scenario.targets import find_one
from martensite.search.free_numbers import Target, is_bare, parse_range
from martensite.signals.sampling.sampled import Numbers

MOST_LEVELS = 10_000_000
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NORMAL = re.compile(rf"^(.*?)\s*(?:\+-|\+/-|±)\s*({_NUMBER})\s*(.*)$")


@dataclass(frozen=True)
class SweepAxis:
    """One varied number: a range, some levels, or a normal distribution; numbers in SI."""

    target: Target
    kind: str
    """range, levels or normal."""
    numbers: tuple[float, ...]
    """Both ends, all levels, or mean and standard deviation."""
    count: int | None = None
    """Number of levels of a range on a grid."""
    log: bool = False

    def levels(self) -> Numbers:
        """Return the numbers of a grid.

        Raises:
            ParameterError: the axis has none.
        """
        if self.kind == "levels":
            return np.array(self.numbers)
        if self.kind == "normal" or self.count is None:
            raise ParameterError(
                f"Axis `{self.target.name}` has no levels for a grid; write how many, such as "
                "`:9` behind its range, or choose another `--sample`."
            )
        return self._spread(np.linspace(0.0, 1.0, self.count))

    def quantile(self, share: Numbers) -> Numbers:
        """Return the numbers below which shares in (0, 1) of the axis lie."""
        if self.kind == "levels":
            places = np.minimum((share * len(self.numbers)).astype(int), len(self.numbers) - 1)
            return np.array(self.numbers)[places]
        if self.kind == "normal":
            from scipy.special import ndtri

            mean, deviation = self.numbers
            return mean + deviation * np.asarray(ndtri(share))
        return self._spread(share)

    def _spread(self, share: Numbers) -> Numbers:
        """Return the numbers of a range: exactly its ends at 0 and 1."""
        low, high = self.numbers
        found = low * np.exp(share * math.log(high / low)) if self.log else low + share * (high - low)
        return np.where(share >= 1.0, high, found)

    def extremes(self) -> tuple[float, ...]:
        """Return the numbers that must be allowed; none of a distribution without ends."""
        return () if self.kind == "normal" else self.numbers

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "name": self.target.name,
            "unit": self.target.unit,
            "kind": self.kind,
            "numbers": list(self.numbers),
            "count": self.count,
            "log": self.log,
        }


def parse_axis(words: str, targets: Mapping[str, Target]) -> SweepAxis:
    """Read one `--over`.

    Args:
        words: `NAME=NUMBERS`; the name may be a unique ending of one.
        targets: what can be varied, by name.

    Raises:
        ParameterError: the words are no axis, or nothing of that name can be varied.
        UnitError: a number has no unit, or a wrong one.
    """
    name, equals, numbers = words.partition("=")
    if not equals:
        raise ParameterError(
            f"`{words}` is no axis; write for example `diameter=0.1..0.5 mm:9`, "
            "`A_s=68, 70 degC` or `length=250 mm +- 2 %`."
        )
    target = find_one(name.strip(), targets)
    try:
        read = _read_axis_range if ".." in numbers else _read_levels
        return read(numbers.strip(), target)
    except UnitError as error:
        raise UnitError(f"Axis `{target.name}`: {error}") from None


def _read_axis_range(words: str, target: Target) -> SweepAxis:
    low, high, count, scale = parse_range(words, target.unit, lambda end: _parse_number(end, target))
    if low is None or high is None or scale == "whole":
        raise UnitError(f"`{words}` is no range with two ends, such as `1..2:9 log`.")
    if not low < high:
        raise ParameterError(f"Axis `{target.name}` must rise, but is `{words}`.")
    if scale == "log" and low <= 0.0:
        raise ParameterError(f"A logarithmic axis must be above 0, but `{words}` is not.")
    if count is not None and not 2 <= count <= MOST_LEVELS:
        raise ParameterError(f"Axis `{target.name}` must have 2 levels or more, not {count}.")
    return SweepAxis(target, "range", (low, high), count, scale == "log")


def _read_levels(words: str, target: Target) -> SweepAxis:
    match = _NORMAL.match(words)
    if match is not None:
        return _read_normal(match[1], float(match[2]), match[3].strip(), target)
    *first, last = (piece.strip() for piece in words.split(","))
    unit = re.sub(rf"^{_NUMBER}\s*", "", last)
    every = [f"{piece} {unit}" if is_bare(piece) else piece for piece in (*first, last)]
    return SweepAxis(target, "levels", tuple(_parse_number(piece, target) for piece in every))


def _read_normal(mean: str, deviation: float, unit: str, target: Target) -> SweepAxis:
    """Return a distribution around a mean; the scenario's number if none is given."""
    if unit and unit != "%" and is_bare(mean):
        mean = f"{mean} {unit}"
    middle = _parse_number(mean, target) if mean else target.value
    if unit == "%":
        if target.unit == "K":
            raise ParameterError(f"A share of `{target.name}` means nothing; write `+- 2 K`.")
        wide = abs(middle) * deviation / 100.0
    else:
        factor, _ = units.find_conversion(unit or "1", target.unit)
        wide = factor * deviation
    if not wide > 0.0:
        raise ParameterError(f"The deviation of `{target.name}` must be above 0, but is {wide:g}.")
    return SweepAxis(target, "normal", (middle, wide))


def _parse_number(words: str, target: Target) -> float:
    return units.parse_quantity(words, target.unit)
