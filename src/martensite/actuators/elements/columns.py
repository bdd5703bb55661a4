"""States of elements of many cells or fibres: one column per quantity."""

from __future__ import annotations

from typing import Any, NamedTuple

from martensite.actuators.elements.network import Column
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import choose_tuple

LARGE = 1e300
"""Bound that represents infinity."""


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
    """From each cell to the ambient, besides its surface."""


class StepStart(NamedTuple):
    """Columns at the start of a step."""

    temperature: Column
    martensite: Column
    oriented: Column
    capacity: Column
    """[J/K]"""
    diagonal: Column
    """Heat capacity plus increase of losses [J/K]."""
    right: Column
    """Diagonal · T less the heat loss [J]."""
    latent: Column
    """[J]"""
    long: Column
    """Elongation [m]."""
    elastic: Column
    """Compliance [m/N]."""


class SweepGuess(NamedTuple):
    """Columns that a sweep passes to the next, with derivatives of each cell."""

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
    """Latent heat absorbed per kelvin [J/K]."""
    gives: Column
    """Latent heat released per newton [J/N]."""
    crossing: Column


class HeatBalanceColumns(NamedTuple):
    """Linear part of the heat balance of a step."""

    diagonal: Column
    right: Column
    """Includes Joule heat."""
    links: Column


class Point(NamedTuple):
    """Elongation [m] and temperature [K] common to all fibres."""

    elongation: Scalar
    temperature: Scalar


class SectionHeat(NamedTuple):
    """Final temperature without transformation [K], and per heat [K/J].

    Heat by changes of resistance is per martensite [J/m³] and per elongation [J/m].
    """

    base: Scalar
    share: Scalar
    by_martensite: Scalar
    by_elongation: Scalar
    ripple: Scalar


class Bracket(NamedTuple):
    """Bracket of a root, and the last mismatch inside."""

    low: Scalar = -LARGE
    high: Scalar = LARGE
    last: Scalar = LARGE

    def narrow(self, xp: Namespace, at: Scalar, up: Flag, bound: Scalar) -> Bracket:
        """Return the bracket above or below a value, limited by a bound."""
        low, high = xp.where(up, at, bound), xp.where(up, bound, at)
        return Bracket(xp.maximum(self.low, low), xp.minimum(self.high, high), self.last)

    def limit(self, xp: Namespace, wanted: Scalar, off: Scalar) -> Scalar:
        """Return the wanted value, or the middle if it is outside or `off` exceeds half of the last mismatch."""
        good = xp.both(xp.both(self.low < wanted, wanted < self.high), off <= 0.5 * self.last)
        closed = xp.both(self.low > -LARGE, self.high < LARGE)
        return xp.where(xp.either(good, xp.negate(closed)), wanted, 0.5 * self.low + 0.5 * self.high)

    def choose(self, xp: Namespace, flag: Flag, other: Bracket) -> Bracket:
        """Return `other` where the flag holds."""
        return choose_tuple(xp, flag, other, self)


class Turn(NamedTuple):
    """One iteration of a solve: smallest and last correction, and whether only some fibres transform.

    Also the brackets of elongation and temperature, and the mismatch of fibres that were moved alone.
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
    """Solve with one choice of processes, as columns."""

    going: Scalar
    first: Scalar
    point: Point
    crossing: Scalar
    stress: tuple[Scalar, ...]
    martensite: tuple[Scalar, ...]
    oriented: tuple[Scalar, ...]
    moves: tuple[tuple[Scalar, ...], ...]
