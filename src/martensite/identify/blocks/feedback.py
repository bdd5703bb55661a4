"""Nonlinear feedback: a linear system whose input is reduced by a static function of its output.

    z = B(q) u - h φ(r, δ),   y = G(q) z,   r = (y₋ - c)/h,   δ = (y₋ - y₋₋)/(h s)

G is a cascade of sections with unit gain (`operators.sections`), φ a polynomial in the last output and, with `past` =
2, in its last change: r is a stiffness, terms with δ are a varying damping or capacity. φ has no terms of degree 0 and
1, which G has. Blocks in series cannot give a resonance that moves with the amplitude, or latent heat.

The input enters as B(q) u = u + Σ_k β_k ∇^k u/s^k, ∇u = u - u₋, which spans all numerators of this length; without
feed-through u is the last sample. c and h are middle and half width of the range of the input; s = √d₂ of the last
section (p for first order) is its frequency times the sample time. In a fitted model r and δ are limited to 1.5 times
their size in the records, and φ to 1.5 to the power of its degree (`fence_in`), so that it is bounded.

Sources: the structure of Paduart et al. 2010 with one nonlinearity in feedback; the oscillator of the benchmark
"Silverbox" (Wigren & Schoukens 2013) has second order and degree 3.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Self

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, AbstractRanged, Column, Numbers
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar

BEYOND = 1.5
"""Range of growth of the terms, over the largest output and change in the records."""
LEAST = 1e-3
"""Least limit, over half the range of the input."""
WIDE = 1e300
"""Limit without an effect."""
NEWTON = 25


@BLOCKS.register("feedback")
class Feedback(AbstractRanged):
    """A stable linear part with nonlinear feedback, which is bounded only after `fence_in`.

    The static gain is 1 where φ = 0. A fit rejects numbers with which a record overflows.
    """

    short = "fb"
    shape = ("order", "degree", "past")
    fixed = ("low", "high", "fence_output", "fence_change", "fence_fed")
    bounded = False
    fenced = True

    order: Number = param("1", "number of poles of the linear part", low=1.0, high=8.0, default=2.0)
    degree: Number = param("1", "highest degree of what is fed back", low=2.0, high=9.0, default=3.0)
    past: Number = param("1", "past outputs that are fed back: 1 or 2", low=1.0, high=2.0, default=2.0)
    fence_output: Number = param("1", "limit of r in what is fed back", above=0.0, default=WIDE)
    fence_change: Number = param("1", "limit of δ in what is fed back", above=0.0, default=WIDE)
    fence_fed: Number = param("1", "limit of φ as a whole", above=0.0, default=WIDE)
    feedthrough: str = option("whether the input acts within the sample", "yes", "no", default="yes")

    def powers(self) -> list[tuple[int, int]]:
        """Return the powers (of r, of δ) of the terms of φ."""
        changes = range(int(self.degree) + 1 if self.past > 1.5 else 1)
        total = range(2, int(self.degree) + 1)
        return [(n - j, j) for n in total for j in changes if j <= n]

    def numbers(self) -> tuple[str, ...]:
        beta = (f"beta{k + 1}" for k in range(self._zeros))
        return (*sections.name_sections(int(self.order)), *beta, *(f"c{i}{j}" for i, j in self.powers()))

    @property
    def _zeros(self) -> int:
        return int(self.order) - (self.feedthrough == "no")

    @property
    def _earlier(self) -> bool:
        """Return whether the output two samples ago is a separate state."""
        return self.past > 1.5 and int(self.order) == 1

    def states(self) -> int:
        return 2 * int(self.order) + self._earlier

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        order, u = int(self.order), x[0]
        coefficients = theta[order + self._zeros :]
        terms = [(i, c) for (i, j), c in zip(self.powers(), coefficients, strict=True) if j == 0]
        root = xp.detach(u)
        detached = [(i, xp.detach(c)) for i, c in terms]
        for _ in range(NEWTON):
            root = root + self._step_towards(xp, detached, root, xp.detach(u), self.half)
        y = xp.implicit_root(root, root + self._step_towards(xp, terms, root, u, 1e300))
        r = (root - self.middle) / self.half
        y = xp.where(xp.abs(r) < self.fence_output, y, u - self.half * self._sum_terms(xp, theta, r, 0.0))
        return [u] * order + sections.rest_cascade(order, y) + [y] * self._earlier

    def _step_towards(self, xp: Namespace, fed: list[tuple[int, Scalar]], y: Scalar, u: Scalar, most: Scalar) -> Scalar:
        """Return Newton's step towards y + h φ(r, 0) = u, limited to `most`."""
        r = (y - self.middle) / self.half
        value, slope = y - u, 1.0
        for power, c in fed:
            value = value + self.half * c * _raise_power(r, power)
            slope = slope + c * power * _raise_power(r, power - 1)
        steep = xp.where(slope > 0.1, slope, xp.where(slope < -0.1, slope, 0.1))
        return xp.clip(-value / xp.detach(steep), -most, most)

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        order = int(self.order)
        size = self._size(floats, list(map(float, theta[:order])), dt)
        place = order if order == 1 else 2 * order - 2
        r = (states[:, place] - self.middle) / self.half
        change = states[:, place] - states[:, -1] if order == 1 else states[:, place + 1]
        d = change / (size * self.half) if self.past > 1.5 else np.zeros(len(r))
        terms = zip(self.powers(), theta[order + self._zeros :], strict=True)
        fed = sum(c * r**i * d**j for (i, j), c in terms)
        output, moved, whole = (max(float(np.max(np.abs(one))), LEAST) for one in (r, d, fed))
        return self.with_parts(
            fence_output=BEYOND * output, fence_change=BEYOND * moved, fence_fed=BEYOND**self.degree * whole
        )

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        order, half = int(self.order), self.half
        poles, zeros = list(theta[:order]), theta[order : order + self._zeros]
        past, section_states = list(state[:order]), list(state[order : 2 * order])
        size = self._size(xp, poles, dt)
        before = section_states[0] if order == 1 else section_states[-2]
        change = section_states[0] - state[-1] if order == 1 else section_states[-1]
        fed = self._sum_terms(xp, theta, (before - self.middle) / half, change / (half * size))
        z = _shape_inputs([x[0], *past] if self.feedthrough == "yes" else past, zeros, size) - half * fed
        cascade = sections.step_cascade(xp, order, poles, section_states, z, dt)
        after = [x[0], *past[:-1], *cascade.state, *([before] * self._earlier)]
        return (cascade.signals[0],), after

    def _sum_terms(self, xp: Namespace, theta: Column, r: Scalar, d: Scalar) -> Scalar:
        """Return φ within its limits."""
        r = xp.clip(r, -self.fence_output, self.fence_output)
        d = xp.clip(d, -self.fence_change, self.fence_change)
        fed: Scalar = 0.0
        for (i, j), c in zip(self.powers(), theta[int(self.order) + self._zeros :], strict=True):
            fed = fed + c * _raise_power(r, i) * _raise_power(d, j)
        return xp.clip(fed, -self.fence_fed, self.fence_fed)

    def _size(self, xp: Namespace, poles: list[Scalar], dt: Scalar) -> Scalar:
        """Return the change per sample over the amplitude, at the frequency of the last section."""
        if int(self.order) == 1:
            return sections.first_order(xp, poles[0], dt)
        return xp.sqrt(sections.second_order(xp, poles[-2], poles[-1], dt).d2)

    def start(self) -> Numbers:
        theta = np.zeros(len(self.numbers()))
        theta[int(self.order) % 2 + 1 : int(self.order) : 2] = np.log(1.2)
        return theta

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = rng.uniform(-0.1, 0.1, len(self.numbers()))
        theta[: int(self.order)] = sections.draw_numbers(int(self.order), rng, duration, dt)
        return theta

    def twin(self) -> AbstractBlock:
        delay = self.feedthrough == "no"
        return TransferFunction(nb=self._zeros + 1, nf=self.order, nk=int(delay))

    def as_linear(self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> tuple[Feedback, Numbers]:
        suits = isinstance(linear, TransferFunction)
        return self, self.like(linear, theta, dt) if suits else self.start()

    def like(self, linear: TransferFunction, theta: Numbers, dt: float) -> Numbers:
        """Return the free numbers of a transfer function of the same order, without feedback, for a sample time [s].

        Raises:
            ParameterError: its order, delay or numerator does not fit.
        """
        order, delay = int(self.order), int(self.feedthrough == "no")
        if int(linear.nf) != order or int(linear.nk) != delay or linear.nb > self._zeros + 1:
            raise ParameterError(
                f"`{self.text()}` can begin as `oe({self._zeros + 1},{order},{delay})`, not as `{linear.text()}`."
            )
        denominator = np.poly(sections.find_poles(order, theta[:order], dt)).real
        response = _respond_to_impulse(linear, theta, dt, order + 1)
        numerator = np.convolve(response, denominator)[delay : order + 1]
        size = self._size(floats, list(map(float, theta[:order])), dt)
        numbers = np.zeros(len(self.numbers()))
        numbers[:order] = theta[:order]
        numbers[order : order + self._zeros] = _in_differences(numerator, size)
        return numbers

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        order = int(self.order)
        rest = zip(self.numbers()[order:], theta[order:], strict=True)
        poles = sections.show_numbers(self.numbers()[:order], theta[:order])
        return [*poles, *((name, float(value), "1") for name, value in rest)]


def _respond_to_impulse(linear: TransferFunction, theta: Numbers, dt: float, count: int) -> Numbers:
    state, outputs = [0.0] * linear.states(), np.zeros(count)
    for k in range(count):
        (outputs[k],), after = linear.step(floats, list(map(float, theta)), state, (float(k == 0),), dt)
        state = list(after)
    return outputs


def _in_differences(numerator: Numbers, size: float) -> Numbers:
    """Return the β_k of a numerator in powers of q^-1 = 1 - ∇."""
    powers = np.zeros(len(numerator))
    for coefficient in numerator[::-1]:  # Horner, times 1 - ∇ each
        powers[1:] -= powers[:-1].copy()
        powers[0] += coefficient
    return powers[1:] * size ** np.arange(1, len(numerator)) / powers[0]


def _raise_power(x: Scalar, count: int) -> Scalar:
    power: Scalar = 1.0
    for _ in range(count):
        power = power * x
    return power


def _shape_inputs(inputs: list[Scalar], weights: Column, size: Scalar) -> Scalar:
    """Return the newest input plus its weighted differences."""
    total, differences, scale = inputs[0], list(inputs), 1.0
    for weight in weights:
        differences = [a - b for a, b in pairwise(differences)]
        scale = scale * size
        total = total + weight * differences[0] / scale
    return total
