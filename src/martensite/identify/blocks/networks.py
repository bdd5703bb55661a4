"""Networks of one layer: a line, and units of one shape at many places, on the scaled input r.

    y = offset + L r + Σ_i a_i g(q_i),    |q| ≤ 40

    sigmoid    g = 1/(1 + exp(-q)),             q = b_i (r - c_i), log b_i free; c_i spread evenly
    tanh       g = tanh(q),                     q = w_i r + v_i; steepest points spread evenly
    wavelet    g = (1 - q²) exp(-q²/2),         q = b_i (r - c_i); levels of 1, 2, 4, … units, each half as wide

r is the input on the scale of its range, -1 to 1; beyond its units a network is a line. Units start with height 0.

Source of wavelets: Zhang and Benveniste 1992.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar

FARTHEST = 40.0
"""Limit of |q|."""
STEEPEST = 9.0
"""Limit of |log b|."""


def compute_logistic(xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
    """Return 1/(1 + exp(-q)) and its slope; compilers vectorise an exponential."""
    decay = xp.exp(-q)
    value = 1.0 / (1.0 + decay)
    return value, decay * value * value


class AbstractNetwork(AbstractCurve):
    """A line and units with a height and two numbers of position each."""

    shape = ("units",)

    units: Number = param("1", "number of units", low=1.0, high=1000.0, default=10.0, typical=2.0)

    @abstractmethod
    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """Return g(q) and its slope, which must be 0 at the limit of |q|."""

    def argument(self, xp: Namespace, first: Scalar, second: Scalar, r: Scalar) -> Scalar:
        """Return q of a unit from its two numbers, by default steepness and centre."""
        return xp.exp(xp.clip(first, -STEEPEST, STEEPEST)) * (r - second)

    @abstractmethod
    def frame(self) -> tuple[Numbers, Numbers]:
        """Return the initial two numbers of all units, by default log b and centres."""

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Return random values of these around the frame."""
        first, second = self.frame()
        gap = 2.0 / len(first)
        return first + rng.normal(0.0, 0.3, len(first)), second + gap * rng.normal(0.0, 0.5, len(second))

    def heights(self) -> tuple[str, ...]:
        return ("rise", *(f"height{i}" for i in self._each))

    def places(self) -> tuple[str, ...]:
        return (*(f"log_b{i}" for i in self._each), *(f"centre{i}" for i in self._each))

    @property
    def _each(self) -> range:
        return range(1, int(self.units) + 1)

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        count = len(heights) - 1
        total = heights[0] * r
        for height, first, second in zip(heights[1:], places[:count], places[count:], strict=True):
            total = total + height * self._unit(xp, self.argument(xp, first, second, r))
        return total

    def _unit(self, xp: Namespace, q: Scalar) -> Scalar:
        """Return g(q) with its analytic slope, so that each derivative is one more product."""
        here = xp.detach(q)
        value, slope = self.unit_shape(xp, xp.clip(here, -FARTHEST, FARTHEST))
        return xp.implicit_root(value, value + slope * (q - here))

    def line(self, slope: float, offset: float) -> Numbers:
        heights = np.zeros(int(self.units))
        return self.join_numbers(offset + slope * self.middle, [slope * self.half], heights, *self.frame())

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        count = int(self.units)
        units = self.first + 1
        theta[units : units + count] = rng.normal(0.0, 0.2, count) * theta[self.first]
        theta[units + count :] = np.concatenate(self.spread(rng))
        return theta


@BLOCKS.register("sigmoid-network")
class SigmoidNetwork(AbstractNetwork):
    """A line and smooth steps of free height, width and place."""

    short = "sigmoid"

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        return compute_logistic(xp, q)

    def frame(self) -> tuple[Numbers, Numbers]:
        count = int(self.units)
        steep = np.full(count, np.log(0.75 * (count + 1)))
        return steep, (2.0 * np.arange(count) + 1.0) / count - 1.0

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        steep, centres = self.frame()
        return steep + rng.normal(0.0, 0.3, len(steep)), rng.uniform(-1.0, 1.0, len(centres))


@BLOCKS.register("tanh-network")
class TanhNetwork(AbstractNetwork):
    """A line and hyperbolic tangents with weights and biases."""

    short = "tanh"

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        value, slope = compute_logistic(xp, 2.0 * q)
        return 2.0 * value - 1.0, 4.0 * slope

    def argument(self, xp: Namespace, first: Scalar, second: Scalar, r: Scalar) -> Scalar:
        return first * r + second

    def places(self) -> tuple[str, ...]:
        units = range(1, int(self.units) + 1)
        return (*(f"weight{i}" for i in units), *(f"bias{i}" for i in units))

    def frame(self) -> tuple[Numbers, Numbers]:
        count = int(self.units)
        weights = np.full(count, 0.5 * (count + 1.0))
        return weights, -weights * ((2.0 * np.arange(count) + 1.0) / count - 1.0)

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        weights = self.frame()[0] * rng.normal(0.0, 1.0, int(self.units))
        return weights, -weights * rng.uniform(-1.0, 1.0, len(weights))


@BLOCKS.register("wavelet-network")
class WaveletNetwork(AbstractNetwork):
    """A line and wavelets of free height, width and place."""

    short = "wavelet"
    cites = ("zhang1992",)

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        square = q * q
        bell = xp.exp(-0.5 * square)
        return (1.0 - square) * bell, (square - 3.0) * q * bell

    def frame(self) -> tuple[Numbers, Numbers]:
        steep: list[float] = []
        centres: list[float] = []
        level, left = 0, int(self.units)
        while left > 0:
            full = 2**level
            count = min(full, left)
            places = np.floor((np.arange(count) + 0.5) * full / count)
            centres += [*((2.0 * places + 1.0) / full - 1.0)]
            steep += [float(np.log(1.25 * full))] * count
            level, left = level + 1, left - count
        return np.array(steep), np.array(centres)
