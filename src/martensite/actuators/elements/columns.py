"""What an element of many cells keeps, one column per quantity."""

from typing import Any, NamedTuple

from martensite.actuators.elements.network import Column
from martensite.kernels.namespace import Scalar


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
