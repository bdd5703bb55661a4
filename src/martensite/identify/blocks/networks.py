"""Networks of one layer: a line, and units of one shape at many places, on the scale r.

    c(r) = L r + Σ_i a_i g(q_i)

Localised units have q = exp(log_b) (r - centre); their start spreads them over the range. Units
are limited to |q| ≤ 40, where the shapes in use have long reached what they tend to.

Sigmoid network: y = offset + L r + Σ_i a_i / (1 + exp(-b_i (r - c_i))), log b_i free.

r is the input on the scale of its range, -1 to 1. Beyond its units it goes on as a line. Units
start evenly over the range, each as wide as its share, with height 0.

Neural network of one hidden layer: y = offset + L r + Σ_i a_i tanh(w_i r + v_i).

r is the input on the scale of its range, -1 to 1. Weights may have either sign. Units start with
their steepest points spread evenly over the range and with height 0.

Wavelet network: y = offset + L r + Σ_i a_i ψ(b_i (r - c_i)), ψ(q) = (1 - q²) exp(-q²/2).

r is the input on the scale of its range, -1 to 1. Beyond its units it goes on as a line. Units
start on a dyadic frame, levels of 1, 2, 4, … of them, each half as wide as those before, with
height 0; what does not fill a level is spread evenly over it.

Source: Zhang and Benveniste 1992.
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
    """1/(1 + exp(-q)) and its slope; an exponential is what compilers can vectorise."""
    away = xp.exp(-q)
    share = 1.0 / (1.0 + away)
    return share, away * share * share


class AbstractNetwork(AbstractCurve):
    """A line and units, each of a height and two numbers of place."""

    shape = ("units",)

    units: Number = param("1", "number of units", low=1.0, high=1000.0, default=10.0, typical=2.0)

    @abstractmethod
    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """g(q) and its slope, which must be 0 at the limit of |q|."""

    def argument(self, xp: Namespace, first: Scalar, second: Scalar, r: Scalar) -> Scalar:
        """q of a unit from its two numbers: its steepness and its centre."""
        return xp.exp(xp.clip(first, -STEEPEST, STEEPEST)) * (r - second)

    @abstractmethod
    def frame(self) -> tuple[Numbers, Numbers]:
        """Return the two numbers of all units to start with: log b and centres."""

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Return random weights and offsets around the frame."""
        first, second = self.frame()
        gap = 2.0 / len(first)
        return first + rng.normal(0.0, 0.3, len(first)), second + gap * rng.normal(0.0, 0.5, len(second))

    def heights(self) -> tuple[str, ...]:
        """Rise of the line over half the range, heights of the units."""
        return ("rise", *(f"height{i}" for i in self._each))

    def places(self) -> tuple[str, ...]:
        """Return the steepness and centre of every unit."""
        return (*(f"log_b{i}" for i in self._each), *(f"centre{i}" for i in self._each))

    @property
    def _each(self) -> range:
        return range(1, int(self.units) + 1)

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Return the line and units."""
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
        """Return the line alone, its units idle in their frame."""
        level = (offset + slope * self.middle,)[: self.first]
        idle = np.zeros(int(self.units))
        return np.concatenate([level, [slope * self.half], idle, *self.frame()])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return the units around their frame, of heights about a fifth of the rise."""
        made = self.start()
        count = int(self.units)
        units = self.first + 1
        made[units : units + count] = rng.normal(0.0, 0.2, count) * made[self.first]
        made[units + count :] = np.concatenate(self.spread(rng))
        return made


@BLOCKS.register("sigmoid-network")
class SigmoidNetwork(AbstractNetwork):
    """A line and steps of free height, width and place: smooth, of any shape."""

    short = "sigmoid"

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """Return the logistic function."""
        return compute_logistic(xp, q)

    def frame(self) -> tuple[Numbers, Numbers]:
        """b = 1.5 (n + 1) / range, centres in the middle of n equal shares."""
        count = int(self.units)
        steep = np.full(count, np.log(0.75 * (count + 1)))
        return steep, (2.0 * np.arange(count) + 1.0) / count - 1.0

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Return the centres anywhere in the range."""
        steep, centres = self.frame()
        return steep + rng.normal(0.0, 0.3, len(steep)), rng.uniform(-1.0, 1.0, len(centres))


@BLOCKS.register("tanh-network")
class TanhNetwork(AbstractNetwork):
    """A line and hyperbolic tangents of weights and biases."""

    short = "tanh"

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """Return the hyperbolic tangent, from an exponential."""
        share, slope = compute_logistic(xp, 2.0 * q)
        return 2.0 * share - 1.0, 4.0 * slope

    def argument(self, xp: Namespace, first: Scalar, second: Scalar, r: Scalar) -> Scalar:
        """Return the weight and bias."""
        return first * r + second

    def places(self) -> tuple[str, ...]:
        """Return the weights, then biases."""
        units = range(1, int(self.units) + 1)
        return (*(f"weight{i}" for i in units), *(f"bias{i}" for i in units))

    def frame(self) -> tuple[Numbers, Numbers]:
        """Return weights and offsets of evenly spaced units, with a steepness that grows with their number."""
        count = int(self.units)
        weights = np.full(count, 0.5 * (count + 1.0))
        return weights, -weights * ((2.0 * np.arange(count) + 1.0) / count - 1.0)

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Return the weights of the size of those of the frame, their steepest points in the range."""
        weights = self.frame()[0] * rng.normal(0.0, 1.0, int(self.units))
        return weights, -weights * rng.uniform(-1.0, 1.0, len(weights))


@BLOCKS.register("wavelet-network")
class WaveletNetwork(AbstractNetwork):
    """A line and ripples of free height, width and place, coarse and fine."""

    short = "wavelet"
    cites = ("zhang1992",)

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """Return the second derivative of a bell, upside down."""
        square = q * q
        bell = xp.exp(-0.5 * square)
        return (1.0 - square) * bell, (square - 3.0) * q * bell

    def frame(self) -> tuple[Numbers, Numbers]:
        """b = 2.5 · 2^l / range at the 2^l places of level l."""
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
