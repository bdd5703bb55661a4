"""Linear state-space system of several inputs and outputs, stable for any value of its parameters.

    s⁺ = A s + B u(t - nk),   y = y₀ + C s (+ D u if nk = 0)

A is a series of sections (`operators.sections`); B feeds every state, and C sums the signals of all sections. The sum
Σ r_i b_i of the columns of B, with fixed weights r_i = 1/i, enters the first section alone: that removes the freedom to
transform the state, and for one input leaves B without free numbers. As the sections respond within the sample, C s
with nk = 1 is the strictly proper system of this order; nk = 0 with D adds feed-through.

It spans every stable system of the order whose A has one Jordan block per pole, no single pole at 0 or on the negative
real axis, and whose states are all reached by Σ r_i u_i; other systems are limits of these. Gains are free: next to
static blocks with a free gain, only the product of the gains is identifiable.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.operators import sections
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("state-space")
class StateSpace(AbstractBlock):
    """Several inputs and outputs with common poles."""

    short = "ss"
    shape = ("order", "ins", "outs", "nk")
    linear = True

    order: Number = param("1", "number of poles", low=1.0, default=2.0, typical=3.0)
    ins: Number = param("1", "number of inputs", low=1.0, default=1.0, typical=2.0)
    outs: Number = param("1", "number of outputs", low=1.0, default=1.0, typical=2.0)
    nk: Number = param("1", "delay in samples; 0 adds feed-through", low=0.0, default=1.0)
    offset: str = option("free outputs at zero input; `no`: they are 0", "yes", "no", default="no")

    @property
    def inputs(self) -> int:
        return int(self.ins)

    @property
    def outputs(self) -> int:
        return int(self.outs)

    def numbers(self) -> tuple[str, ...]:
        n, m, p = int(self.order), self.inputs, self.outputs
        b = [f"b{k}_{i}" for k in range(1, n + 1) for i in range(1, m)]
        c = [f"c{j}_{k}" for j in range(1, p + 1) for k in range(1, n + 1)]
        d = [f"d{j}_{i}" for j in range(1, p + 1) for i in range(1, m + 1)]
        free = [f"offset{j}" for j in range(1, p + 1)] if self.offset == "yes" else []
        return (*sections.name_sections(n), *b, *c, *(d if self.nk < 1.0 else ()), *free)

    def states(self) -> int:
        return int(self.nk) * self.inputs + int(self.order)

    def poles(self, theta: Numbers, dt: float) -> Numbers:
        """Return the poles z of the sections."""
        return sections.find_poles(int(self.order), theta, dt)

    def _entering(self, theta: Column, u: Column) -> list[Scalar]:
        n, m = int(self.order), self.inputs
        inputs: list[Scalar] = []
        for k in range(n):
            row = theta[n + k * (m - 1) : n + (k + 1) * (m - 1)]
            total, last = 0.0, 1.0 if k == 0 else 0.0
            for i, b in enumerate(row):
                total = total + b * u[i]
                last = last - b / (i + 1.0)
            inputs.append(total + m * last * u[m - 1])
        return inputs

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        n = int(self.order)
        if self.inputs == 1:
            return [x[0]] * int(self.nk) + sections.rest_cascade(n, x[0])
        states = sections.fed_resting(xp, n, list(theta[:n]), self._entering(theta, x), dt)
        return [*list(x) * int(self.nk), *states]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        n, m, nk = int(self.order), self.inputs, int(self.nk)
        line = [*x, *state[: nk * m]]
        u = line[nk * m :]
        fed = self._entering(theta, u)
        more = fed[1:] if m > 1 else ()
        cascade = sections.step_cascade(xp, n, list(theta[:n]), list(state[nk * m :]), fed[0], dt, more)
        y = self._sum_outputs(theta, [*cascade.signals, *(u if nk == 0 else ())])
        return y, (*line[: nk * m], *cascade.state)

    def _sum_outputs(self, theta: Column, signals: Column) -> list[Scalar]:
        """Return y₀ + C s + D u."""
        n, m, p = int(self.order), self.inputs, self.outputs
        first = n + n * (m - 1)
        y: list[Scalar] = list(theta[len(theta) - p :]) if self.offset == "yes" else [0.0] * p
        for j in range(p):
            c = theta[first + j * n : first + (j + 1) * n]
            d = theta[first + p * n + j * m : first + p * n + (j + 1) * m]
            for weight, signal in zip([*c, *(d if len(signals) > n else ())], signals, strict=True):
                y[j] = y[j] + weight * signal
        return y

    def twin(self) -> AbstractBlock:
        return self

    def start(self) -> Numbers:
        n, m, p = int(self.order), self.inputs, self.outputs
        theta = np.zeros(len(self.numbers()))
        theta[n % 2 + 1 : n : 2] = np.log(1.2)
        theta[n : n + m - 1] = 1.0 / sum(1.0 / i for i in range(1, m + 1))
        theta[n + n * (m - 1) : n + n * (m - 1) + p * n : n] = 1.0
        return theta

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        n = int(self.order)
        theta = rng.uniform(-1.0, 1.0, len(self.numbers()))
        theta[:n] = sections.draw_numbers(n, rng, duration, dt)
        return theta

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return sections.show_numbers(self.numbers(), theta)
