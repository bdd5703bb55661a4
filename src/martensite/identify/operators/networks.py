"""Networks of one layer: a line, and units of one shape at many places, on the scale r.

    c(r) = L r + Σ_i a_i g(q_i)

Localised units have q = exp(log_b) (r - centre); their start spreads them over the range. Units
are limited to |q| ≤ 40, where the shapes in use have long reached what they tend to.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from martensite.base.parameters import param
from martensite.identify.blocks.base import Column, Numbers
from martensite.identify.operators.counts import check_whole
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar

FARTHEST = 40.0
"""Limit of |q|."""
STEEPEST = 9.0
"""Limit of |log b|."""


def compute_logistic(xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
    """1/(1 + exp(-q)) and its slope; an exponential is what compilers can vectorise."""
    away = xp.exp(-q)
    share = 1.0 / (1.0 + away)
    return share, away * share * share


class AbstractNetwork(AbstractCurve):
    """A line and units, each of a height and two numbers of place."""

    shape = ("units",)

    units: float = param("1", "number of units", low=1.0, high=1000.0, default=10.0, typical=2.0)

    def check(self) -> None:
        """Units are whole."""
        check_whole(self)

    @abstractmethod
    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """g(q) and its slope, which must be 0 at the limit of |q|."""

    def argument(self, xp: Namespace, first: Scalar, second: Scalar, r: Scalar) -> Scalar:
        """q of a unit from its two numbers: its steepness and its centre."""
        return xp.exp(xp.clip(first, -STEEPEST, STEEPEST)) * (r - second)

    @abstractmethod
    def frame(self) -> tuple[Numbers, Numbers]:
        """The two numbers of all units to start with: log b and centres."""

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """The same at random: around the frame."""
        first, second = self.frame()
        gap = 2.0 / len(first)
        return first + rng.normal(0.0, 0.3, len(first)), second + gap * rng.normal(0.0, 0.5, len(second))

    def heights(self) -> tuple[str, ...]:
        """Rise of the line over half the range, heights of the units."""
        return ("rise", *(f"height{i}" for i in self._each))

    def places(self) -> tuple[str, ...]:
        """Steepness and centre of every unit."""
        return (*(f"log_b{i}" for i in self._each), *(f"centre{i}" for i in self._each))

    @property
    def _each(self) -> range:
        return range(1, int(self.units) + 1)

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Line and units."""
        count = len(heights) - 1
        total = heights[0] * r
        for height, first, second in zip(heights[1:], places[:count], places[count:], strict=True):
            total = total + height * self._unit(xp, self.argument(xp, first, second, r))
        return total

    def _unit(self, xp: Namespace, q: Scalar) -> Scalar:
        """g(q) with its slope as written, so that each derivative is one product more."""
        here = xp.detach(q)
        value, slope = self.unit_shape(xp, xp.clip(here, -FARTHEST, FARTHEST))
        return xp.implicit_root(value, value + slope * (q - here))

    def line(self, slope: float, offset: float) -> Numbers:
        """The line alone, its units idle in their frame."""
        level = (offset + slope * self.middle,)[: self.first]
        idle = np.zeros(int(self.units))
        return np.concatenate([level, [slope * self.half], idle, *self.frame()])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Units around their frame, of heights about a fifth of the rise."""
        made = self.start()
        count = int(self.units)
        units = self.first + 1
        made[units : units + count] = rng.normal(0.0, 0.2, count) * made[self.first]
        made[units + count :] = np.concatenate(self.spread(rng))
        return made
