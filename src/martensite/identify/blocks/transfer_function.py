"""Linear system of orders (nb, nf, nk): the output-error block, with a static gain of 1.

    y = B(q)/F(q) w,   B = b_1 q^-nk + … + b_nb q^-(nk+nb-1),   F = 1 + f_1 q^-1 + … + f_nf q^-nf

The poles are sections in series (`operators.sections`); the numerator is a weighted sum of their signals: the first nb
signals, from the last section back, span the numerators of nb coefficients; beyond nf, samples of the input follow. The
delay of nk samples comes first. Static blocks around it have free gains.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.operators import sections
from martensite.kernels.namespace import Namespace, Scalar

RIGHT = 0.2
"""Fraction of random zeros in the right half plane."""


@BLOCKS.register("transfer-function")
class TransferFunction(AbstractBlock):
    """One input, one output; stable for any free numbers."""

    short = "oe"
    shape = ("nb", "nf", "nk")
    linear = True

    nb: Number = param("1", "number of numerator coefficients (zeros + 1)", low=1.0, default=1.0, typical=3.0)
    nf: Number = param("1", "number of poles", low=0.0, default=1.0, typical=3.0)
    nk: Number = param("1", "delay in samples", low=0.0, default=1.0)

    def numbers(self) -> tuple[str, ...]:
        return (*sections.name_sections(int(self.nf)), *(f"weight{k}" for k in range(2, int(self.nb) + 1)))

    def states(self) -> int:
        return int(self.nk) + int(self.nf) + self._taps

    @property
    def _taps(self) -> int:
        return max(int(self.nb) - int(self.nf) - 1, 0)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        w = x[0]
        return [w] * int(self.nk) + sections.rest_cascade(int(self.nf), w) + [w] * self._taps

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        nk, nf = int(self.nk), int(self.nf)
        line = [x[0], *state[:nk]]
        w, poles, past = line[-1], list(theta[:nf]), list(state[nk + nf :])
        cascade = sections.step_cascade(xp, nf, poles, list(state[nk : nk + nf]), w, dt)
        signals = [*cascade.signals, w, *past][: int(self.nb)]
        gains = [*cascade.unit_gain, True, *(True for _ in past)][: int(self.nb)]
        y, rest = 0.0, 1.0
        for weight, signal, gain in zip(theta[nf:], signals[1:], gains[1:], strict=True):
            y = y + weight * signal
            rest = rest - weight if gain else rest
        return (y + rest * signals[0],), (*line[:-1], *cascade.state, *[w, *past][: self._taps])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        nf, nb = int(self.nf), int(self.nb)
        theta = rng.uniform(-0.3, 1.3, len(self.numbers()))
        theta[:nf] = sections.draw_numbers(nf, rng, duration, dt)
        count = min(nb - 1, nf)
        if count:
            leads = np.exp(rng.uniform(*sections.find_time_range(duration, dt), count))
            leads *= np.where(rng.random(count) < RIGHT, -1.0, 1.0)
            theta[nf : nf + count] = sections.compute_weights(nf, theta[:nf], leads)
        return theta

    def twin(self) -> AbstractBlock:
        return self

    def start(self) -> Numbers:
        nf = int(self.nf)
        theta = np.zeros(len(self.numbers()))
        theta[nf % 2 + 1 : nf : 2] = np.log(1.2)
        return theta

    def poles(self, theta: Numbers, dt: float) -> Numbers:
        """Return the poles z of the sections."""
        return sections.find_poles(int(self.nf), theta, dt)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return sections.show_numbers(self.numbers(), theta)
