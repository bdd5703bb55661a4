"""State of elements of many cells, and of many fibres: one column per quantity."""

from __future__ import annotations

from typing import Any, NamedTuple

from martensite.actuators.elements.network import Column
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import choose_tuple

LARGE = 1e300
"""Bound that stands for infinity."""


class Cells(NamedTuple):
    """State of an element of many cells."""

    memories: tuple[Any, ...]
    """One memory of the law per cell."""
    force: Scalar
    """[N]"""


class Links(NamedTuple):
    """Conductances [W/K]."""

    between: Column
    """From each cell to the next."""
    outside: Column
    """From each cell to the surroundings, besides its surface."""


class StepStart(NamedTuple):
    """One column per quantity that a step starts from."""

    temperature: Column
    martensite: Column
    oriented: Column
    capacity: Column
    """[J/K]"""
    diagonal: Column
    """Heat capacity, more by what is lost as it warms [J/K]."""
    right: Column
    """Diagonal · T less the heat lost [J]."""
    latent: Column
    """[J]"""
    long: Column
    """Elongation [m]."""
    elastic: Column
    """Compliance [m/N]."""


class SweepGuess(NamedTuple):
    """One column per quantity that a sweep leaves to the next; slopes of the answer of a cell."""

    martensite: Column
    oriented: Column
    temperature: Column
    """[K]"""
    force: Column
    """[N]"""
    long: Column
    """Elongation [m]."""
    elastic: Column
    """Compliance at frozen fractions [m/N]."""
    soft: Column
    """Compliance at constant temperature [m/N]."""
    shrinks: Column
    """Elongation per temperature at constant force [m/K]."""
    warms: Column
    """Latent heat that a kelvin takes up [J/K]."""
    gives: Column
    """Latent heat that a newton sets free [J/N]."""
    crossing: Column


class HeatBalanceColumns(NamedTuple):
    """The linear part of the heat balance of a step."""

    diagonal: Column
    right: Column
    """With the heat of the current."""
    links: Column


class Point(NamedTuple):
    """Elongation and temperature that all fibres share [m, K]."""

    elongation: Scalar
    temperature: Scalar


class SectionHeat(NamedTuple):
    """Temperature at the end of a step if nothing transforms [K], and per heat [K/J].

    What another resistance takes up, by the martensite at its end [J/m³] and the elongation [J/m].
    """

    base: Scalar
    share: Scalar
    by_martensite: Scalar
    by_elongation: Scalar
    ripple: Scalar


class Bracket(NamedTuple):
    """Bracket of a root, and the mismatch at the last step inside."""

    low: Scalar = -LARGE
    high: Scalar = LARGE
    last: Scalar = LARGE

    def narrow(self, xp: Namespace, at: Scalar, up: Flag, bound: Scalar) -> Bracket:
        """By a number above or below which the root lies, but not beyond a bound."""
        low, high = xp.where(up, at, bound), xp.where(up, bound, at)
        return Bracket(xp.maximum(self.low, low), xp.minimum(self.high, high), self.last)

    def limit(self, xp: Namespace, wanted: Scalar, off: Scalar) -> Scalar:
        """Return the wanted value; the middle if that is outside, or `off` is above half of the last mismatch."""
        good = xp.both(xp.both(self.low < wanted, wanted < self.high), off <= 0.5 * self.last)
        closed = xp.both(self.low > -LARGE, self.high < LARGE)
        return xp.where(xp.either(good, xp.negate(closed)), wanted, 0.5 * self.low + 0.5 * self.high)

    def choose(self, xp: Namespace, flag: Flag, other: Bracket) -> Bracket:
        """Return another one where the flag holds."""
        return choose_tuple(xp, flag, other, self)


class Turn(NamedTuple):
    """A turn of a solve: the least and the last correction, and whether some fibres transform and others do not.

    Then the brackets of elongation and temperature, and how far off fibres were that were moved alone.
    """

    going: Scalar
    point: Point
    least: Scalar
    last: Scalar
    mixed: Scalar
    outer: Bracket
    middle: Bracket
    off: Scalar
    stress: tuple[Scalar, ...]
    low: tuple[Scalar, ...]
    high: tuple[Scalar, ...]
    martensite: tuple[Scalar, ...]
    oriented: tuple[Scalar, ...]


class Round(NamedTuple):
    """A solve with one choice of processes, which are columns of numbers."""

    going: Scalar
    first: Scalar
    point: Point
    crossing: Scalar
    stress: tuple[Scalar, ...]
    martensite: tuple[Scalar, ...]
    oriented: tuple[Scalar, ...]
    moves: tuple[tuple[Scalar, ...], ...]
