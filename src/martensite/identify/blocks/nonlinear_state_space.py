"""Fixed point of a map: Newton's method in a loop, with the derivatives of the root.

Polynomial nonlinear state space: a stable linear system with nonlinear terms in every state.

    s⁺ = A s + B (u + h E φ),   y = y₀ + C s + h F φ,   φ = monomials of degree 2 … d

A, B, C are the matrices of the linear block (`state_space`), so that without nonlinear terms this is the best linear
approximation. The monomials are of the states before the sample and of the input, on the scale of the range of the
input, (v - c)/(h g) and Δ/(h g √d₂), u as (u - c)/h, and limited: to 1.5 times the reach during a search, then each
state to where it was in the records (`fence_in`). What is fed back is then bounded by the records; outside of their
range only the linear system acts. c and h are middle and half width of the range of the input; g is the reach of the
states beyond it, for example of a resonance. Use this general block if the location of the nonlinearity is unknown. It
has many parameters, so keep order and degree low.

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
"""Steps of Newton's method."""
Map = Callable[[Namespace, Column, Column], Column]
"""The next state, from the state and what the map depends on besides."""


def fixed_point(xp: Namespace, held: Map, start: Column, given: Column) -> list[Scalar]:
    """Return the fixed point s = held(xp, s, given) that Newton's method reaches from `start`.

    Derivatives are of the root with respect to `given`, not of the iteration.
    """
    fixed = [xp.detach(value) for value in given]

    def turn(*state: Scalar) -> Column:
        step = _compute_newton_step(xp, held, state, fixed, fixed)
        return [s - d for s, d in zip(state, step, strict=True)]

    root = xp.repeat(NEWTON_STEPS, turn, *(xp.detach(s) for s in start))
    root = [xp.detach(s) for s in root]
    newton = _compute_newton_step(xp, held, root, fixed, given)
    return [xp.implicit_root(s, s - d) for s, d in zip(root, newton, strict=True)]


def _compute_newton_step(xp: Namespace, held: Map, state: Column, fixed: Column, given: Column) -> list[Scalar]:
    """Return Newton's step with the matrix at `fixed` and the residual at `given`."""

    def away(xp: Namespace, s: Column) -> Column:
        return [a - b for a, b in zip(s, held(xp, s, fixed), strict=True)]

    _, matrix = compute_jacobian(xp, away, list(state))
    residual = [a - b for a, b in zip(state, held(xp, state, given), strict=True)]
    return solve_linear(matrix, [residual])[0]


FARTHEST = 1.5
"""Limit of what enters a monomial, in half widths of the range of the input or of the reach of the states."""
USUAL = 3.0
"""Size of usual nonlinear terms; the weak pull to 0 tames those that records do not tell."""
RANGE_FACTOR = 1.05
"""Range of the states that counts, over the largest state of the records."""
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
    offset: str = option("whether the outputs at zero input are free; else they are 0", "yes", "no", default="yes")
    input_terms: str = option("whether the input enters the monomials beside the states", "yes", "no", default="yes")
    output_terms: str = option("whether monomials enter the outputs as well", "yes", "no", default="yes")
    reach: Number = param("1", "range of the states over that of the input", above=0.0, default=1.0)

    fence1: Number = param("1", "limit of the first state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence2: Number = param("1", "limit of the second state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence3: Number = param("1", "limit of the third state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence4: Number = param("1", "limit of the fourth state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence5: Number = param("1", "limit of the fifth state in monomials, over its reach", above=0.0, default=FARTHEST)
    fence6: Number = param("1", "limit of the sixth state in monomials, over its reach", above=0.0, default=FARTHEST)

    def monomials(self) -> list[tuple[int, ...]]:
        """Return the variables that each is a product of: states from 0 on, then the input."""
        count = int(self.order) + (self.input_terms == "yes")
        degrees = range(2, int(self.degree) + 1)
        return [m for d in degrees for m in combinations_with_replacement(range(count), d)]

    def numbers(self) -> tuple[str, ...]:
        """Return the names of the parameters of the linear system, then E state by state and F output by output."""
        words = ["".join(map(str, m)) for m in self.monomials()]
        e = tuple(f"e{k}_{w}" for k in range(1, int(self.order) + 1) for w in words)
        outs = range(1, self.outputs + 1) if self.output_terms == "yes" else ()
        return (*super().numbers(), *e, *(f"f{j}_{w}" for j in outs for w in words))

    @property
    def _linear(self) -> int:
        """Return the number of parameters of the linear system."""
        return len(super().numbers())

    def _products(self, xp: Namespace, poles: Column, held: Column, u: Scalar, dt: Scalar) -> list[Scalar]:
        """h φ."""
        states = zip(self._scale_states(xp, poles, held, dt), self.given()[3:], strict=False)
        limited = [xp.clip(r, -fence, fence) for r, fence in states]
        limited.append(xp.clip((u - self.middle) / self.half, -FARTHEST, FARTHEST))
        return [self.half * _multiply_values(limited, monomial) for monomial in self.monomials()]

    def _scale_states(self, xp: Namespace, poles: Column, held: Column, dt: Scalar) -> list[Scalar]:
        """Return the states on the scale of their reach: 1 is the largest of the linear system at the fit."""
        wide = self.half * self.reach
        scaled: list[Scalar] = []
        for k, value in enumerate(held):
            away = k - int(self.order) % 2
            if away > 0 and away % 2:  # the change in a section of second order
                d2 = sections.second_order(xp, poles[k - 1], poles[k], dt).d2
                scaled.append(value / (wide * xp.sqrt(d2)))
            else:
                scaled.append((value - self.middle) / wide)
        return scaled

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        """Return every state limited to the largest that it had, and a little more."""
        poles = [float(p) for p in theta[: int(self.order)]]
        held = self._scale_states(floats, poles, list(states[:, int(self.nk) :].T), dt)
        largest = [RANGE_FACTOR * float(np.max(np.abs(one))) for one in held]
        return self.with_parts(
            **{f"fence{k}": min(max(one, LEAST_REACH), FARTHEST) for k, one in enumerate(largest, 1)}
        )

    def _feed_states(self, theta: Column, u: Scalar, products: Column) -> list[Scalar]:
        """B u + h E φ: what enters every state."""
        n, count = int(self.order), len(products)
        fed: list[Scalar] = [u, *(0.0 for _ in range(n - 1))]
        for k in range(n):
            own = theta[self._linear + k * count : self._linear + (k + 1) * count]
            for weight, product in zip(own, products, strict=True):
                fed[k] = fed[k] + weight * product
        return fed

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return the state that a constant input holds, found from that of the linear system."""
        n = int(self.order)

        def held(xp: Namespace, state: Column, given: Column) -> Column:
            u, own = given[0], given[1:]
            products = self._products(xp, own[:n], state, u, dt)
            return sections.fed_resting(xp, n, list(own[:n]), self._feed_states(own, u, products), dt)

        found = fixed_point(xp, held, sections.rest_cascade(n, x[0]), [x[0], *theta])
        return [x[0]] * int(self.nk) + found

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Delay, monomials, sections, sums."""
        n, p, nk = int(self.order), self.outputs, int(self.nk)
        line = [x[0], *state[:nk]]
        u, held = line[nk], state[nk:]
        products = self._products(xp, theta[:n], held, u, dt)
        fed = self._feed_states(theta, u, products)
        made = sections.step_cascade(xp, n, list(theta[:n]), list(held), fed[0], dt, fed[1:])
        y = self._sum_outputs(theta[: self._linear], [*made.signals, *([u] if nk == 0 else [])])
        if self.output_terms == "yes":
            last = theta[len(theta) - p * len(products) :]
            for place, weight in enumerate(last):
                j, i = divmod(place, len(products))
                y[j] = y[j] + weight * products[i]
        return y, (*line[:nk], *made.state)

    def twin(self) -> AbstractBlock:
        """Return the linear system."""
        return StateSpace(order=self.order, outs=self.outs, nk=self.nk, offset=self.offset)

    def as_linear(
        self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float
    ) -> tuple[NonlinearStateSpace, Numbers]:
        """Return the linear system, with the reach that its states have under an input."""
        made = np.zeros(len(self.numbers()))
        made[: self._linear] = theta
        return self.with_parts(reach=self._largest_departure(theta, x[:, 0], dt)), made

    def _largest_departure(self, theta: Numbers, x: Numbers, dt: float) -> float:
        """Return the greatest departure of a state from the middle of the input, in half widths of that."""
        n = int(self.order)
        poles, state = [float(p) for p in theta[:n]], sections.rest_cascade(n, float(x[0]))
        half, middle = self.half, self.middle
        most = 0.0
        for u in map(float, x):
            made = sections.step_cascade(floats, n, poles, state, u, dt)
            state = made.state
            pairs = zip(made.signals, made.unit_gain, strict=True)
            most = max(most, *(abs(v - middle * gain) for v, gain in pairs))
        return max(most / half, LEAST_REACH)

    def start(self) -> Numbers:
        """Return the linear system."""
        made = np.zeros(len(self.numbers()))
        made[: self._linear] = super().start()[: self._linear]
        return made

    def priors(self) -> tuple[Numbers, Numbers]:
        """Return the nonlinear terms are not huge; nothing is expected of the linear system."""
        weights = np.zeros(len(self.numbers()))
        weights[self._linear :] = 1.0 / USUAL
        return np.zeros(len(weights)), weights

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return a random linear system with small nonlinear terms."""
        made = super().sample_parameters(rng, duration, dt)
        made[self._linear :] *= 0.02
        return made


def _multiply_values(values: Column, places: tuple[int, ...]) -> Scalar:
    product: Scalar = 1.0
    for i in places:
        product = product * values[i]
    return product
