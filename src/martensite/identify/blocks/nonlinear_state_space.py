"""Polynomial nonlinear state space: a stable linear system with nonlinear terms in every state.

    s⁺ = A s + B (u + h E φ),   y = y₀ + C s + h F φ,   φ = monomials of degree 2 … d

A, B, C are the matrices of the block `state_space`, so that without nonlinear terms this is the best linear
approximation. The monomials are of the present states and the input, scaled to (v - c)/(h g), Δ/(h g √d₂) and
(u - c)/h, and limited: to 1.5 times the reach during a search, then each state to its range in the records
(`fence_in`). The feedback is then bounded; outside the range of the records only the linear system acts. c and h are
middle and half width of the range of the input; g is the reach of the states beyond it, for example at a resonance.

Use this block if the location of the nonlinearity is unknown. It has many parameters, so keep order and degree low.

Source: Paduart et al. 2010.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Self

import numpy as np

from martensite.actuators.mechanics.elimination import solve_linear
from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, AbstractRanged, Column, Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar

NEWTON_STEPS = 30
Map = Callable[[Namespace, Column, Column], Column]


def fixed_point(xp: Namespace, point_map: Map, start: Column, given: Column) -> list[Scalar]:
    """Return the fixed point s = point_map(xp, s, given) by Newton's method, with derivatives by `given`."""
    fixed = [xp.detach(value) for value in given]

    def turn(*state: Scalar) -> Column:
        step = _compute_newton_step(xp, point_map, state, fixed, fixed)
        return [s - d for s, d in zip(state, step, strict=True)]

    root = xp.repeat(NEWTON_STEPS, turn, *(xp.detach(s) for s in start))
    root = [xp.detach(s) for s in root]
    newton = _compute_newton_step(xp, point_map, root, fixed, given)
    return [xp.implicit_root(s, s - d) for s, d in zip(root, newton, strict=True)]


def _compute_newton_step(xp: Namespace, point_map: Map, state: Column, fixed: Column, given: Column) -> list[Scalar]:
    """Return Newton's step with the matrix at `fixed` and the residual at `given`."""

    def away(xp: Namespace, s: Column) -> Column:
        return [a - b for a, b in zip(s, point_map(xp, s, fixed), strict=True)]

    _, matrix = compute_jacobian(xp, away, list(state))
    residual = [a - b for a, b in zip(state, point_map(xp, state, given), strict=True)]
    return solve_linear(matrix, [residual])[0]


FARTHEST = 1.5
"""Limit of the factors of a monomial, in half widths of the range of the input or the reach of the states."""
USUAL = 3.0
"""Prior standard deviation of nonlinear terms, weak, for terms that the records do not determine."""
RANGE_FACTOR = 1.05
"""Limit of a state in monomials over its maximum in the records."""
LEAST_REACH = 1e-3
"""Least reach of the states."""


@BLOCKS.register("nonlinear-state-space")
class NonlinearStateSpace(AbstractRanged, StateSpace):
    """One input, any number of outputs; bounded for bounded inputs."""

    short = "nlss"
    shape = ("order", "degree", "outs", "nk")
    fixed = ("low", "high", "reach", "fence1", "fence2", "fence3", "fence4", "fence5", "fence6")
    linear = False
    fenced = True

    order: Number = param("1", "number of states", low=1.0, high=6.0, default=2.0)
    degree: Number = param("1", "highest degree of a monomial", low=2.0, high=5.0, default=3.0, typical=2.0)
    ins: Number = param("1", "number of inputs", low=1.0, high=1.0, default=1.0)
    offset: str = option("free outputs at zero input; `no`: they are 0", "yes", "no", default="yes")
    input_terms: str = option("input in the monomials", "yes", "no", default="yes")
    output_terms: str = option("monomials in the outputs", "yes", "no", default="yes")
    reach: Number = param("1", "range of the states over that of the input", above=0.0, default=1.0)

    fence1: Number = param("1", "limit of the first state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence2: Number = param("1", "limit of the second state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence3: Number = param("1", "limit of the third state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence4: Number = param("1", "limit of the fourth state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence5: Number = param("1", "limit of the fifth state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence6: Number = param("1", "limit of the sixth state in monomials, over its reach", above=0.0, default=FARTHEST)

    def monomials(self) -> list[tuple[int, ...]]:
        """Return the factors of every monomial: states from 0 on, then the input."""
        count = int(self.order) + (self.input_terms == "yes")
        degrees = range(2, int(self.degree) + 1)
        return [m for d in degrees for m in combinations_with_replacement(range(count), d)]

    def numbers(self) -> tuple[str, ...]:
        words = ["".join(map(str, m)) for m in self.monomials()]
        e = tuple(f"e{k}_{w}" for k in range(1, int(self.order) + 1) for w in words)
        outs = range(1, self.outputs + 1) if self.output_terms == "yes" else ()
        return (*super().numbers(), *e, *(f"f{j}_{w}" for j in outs for w in words))

    @property
    def _linear(self) -> int:
        return len(super().numbers())

    def _products(self, xp: Namespace, poles: Column, cascade_state: Column, u: Scalar, dt: Scalar) -> list[Scalar]:
        """Return h φ."""
        states = zip(self._scale_states(xp, poles, cascade_state, dt), self.fixed_values()[3:], strict=False)
        limited = [xp.clip(r, -fence, fence) for r, fence in states]
        limited.append(xp.clip((u - self.middle) / self.half, -FARTHEST, FARTHEST))
        return [self.half * _multiply_values(limited, monomial) for monomial in self.monomials()]

    def _scale_states(self, xp: Namespace, poles: Column, cascade_state: Column, dt: Scalar) -> list[Scalar]:
        """Return the states relative to their reach."""
        wide = self.half * self.reach
        scaled: list[Scalar] = []
        for k, value in enumerate(cascade_state):
            away = k - int(self.order) % 2
            if away > 0 and away % 2:  # the change in a section of second order
                d2 = sections.second_order(xp, poles[k - 1], poles[k], dt).d2
                scaled.append(value / (wide * xp.sqrt(d2)))
            else:
                scaled.append((value - self.middle) / wide)
        return scaled

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        poles = [float(p) for p in theta[: int(self.order)]]
        scaled_states = self._scale_states(floats, poles, list(states[:, int(self.nk) :].T), dt)
        largest = [RANGE_FACTOR * float(np.max(np.abs(one))) for one in scaled_states]
        return self.with_parts(
            **{f"fence{k}": min(max(one, LEAST_REACH), FARTHEST) for k, one in enumerate(largest, 1)}
        )

    def _feed_states(self, theta: Column, u: Scalar, products: Column) -> list[Scalar]:
        """Return B u + h E φ."""
        n, count = int(self.order), len(products)
        fed: list[Scalar] = [u, *(0.0 for _ in range(n - 1))]
        for k in range(n):
            weights = theta[self._linear + k * count : self._linear + (k + 1) * count]
            for weight, product in zip(weights, products, strict=True):
                fed[k] = fed[k] + weight * product
        return fed

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        n = int(self.order)

        def advance_resting(xp: Namespace, state: Column, given: Column) -> Column:
            u, numbers = given[0], given[1:]
            products = self._products(xp, numbers[:n], state, u, dt)
            return sections.fed_resting(xp, n, list(numbers[:n]), self._feed_states(numbers, u, products), dt)

        states = fixed_point(xp, advance_resting, sections.rest_cascade(n, x[0]), [x[0], *theta])
        return [x[0]] * int(self.nk) + states

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        n, p, nk = int(self.order), self.outputs, int(self.nk)
        line = [x[0], *state[:nk]]
        u, cascade_state = line[nk], state[nk:]
        products = self._products(xp, theta[:n], cascade_state, u, dt)
        fed = self._feed_states(theta, u, products)
        cascade = sections.step_cascade(xp, n, list(theta[:n]), list(cascade_state), fed[0], dt, fed[1:])
        y = self._sum_outputs(theta[: self._linear], [*cascade.signals, *([u] if nk == 0 else [])])
        if self.output_terms == "yes":
            last = theta[len(theta) - p * len(products) :]
            for place, weight in enumerate(last):
                j, i = divmod(place, len(products))
                y[j] = y[j] + weight * products[i]
        return y, (*line[:nk], *cascade.state)

    def twin(self) -> AbstractBlock:
        return StateSpace(order=self.order, outs=self.outs, nk=self.nk, offset=self.offset)

    def as_linear(
        self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float
    ) -> tuple[NonlinearStateSpace, Numbers]:
        parameters = np.zeros(len(self.numbers()))
        parameters[: self._linear] = theta
        return self.with_parts(reach=self._largest_departure(theta, x[:, 0], dt)), parameters

    def _largest_departure(self, theta: Numbers, x: Numbers, dt: float) -> float:
        """Return the largest departure of a state from the middle of the input, in half widths."""
        n = int(self.order)
        poles, state = [float(p) for p in theta[:n]], sections.rest_cascade(n, float(x[0]))
        half, middle = self.half, self.middle
        most = 0.0
        for u in map(float, x):
            cascade = sections.step_cascade(floats, n, poles, state, u, dt)
            state = cascade.state
            pairs = zip(cascade.signals, cascade.unit_gain, strict=True)
            most = max(most, *(abs(v - middle * gain) for v, gain in pairs))
        return max(most / half, LEAST_REACH)

    def start(self) -> Numbers:
        theta = np.zeros(len(self.numbers()))
        theta[: self._linear] = super().start()[: self._linear]
        return theta

    def priors(self) -> tuple[Numbers, Numbers]:
        weights = np.zeros(len(self.numbers()))
        weights[self._linear :] = 1.0 / USUAL
        return np.zeros(len(weights)), weights

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = super().sample_parameters(rng, duration, dt)
        theta[self._linear :] *= 0.02
        return theta


def _multiply_values(values: Column, places: tuple[int, ...]) -> Scalar:
    product: Scalar = 1.0
    for i in places:
        product = product * values[i]
    return product
