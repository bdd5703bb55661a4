"""Linear system of orders (nb, nf, nk): the output-error block, with unit gain at rest.

    y = B(q)/F(q) w,   B = b_1 q^-nk + … + b_nb q^-(nk+nb-1),   F = 1 + f_1 q^-1 + … + f_nf q^-nf

The poles are sections in series (`operators.sections`), the numerator is a weighted sum of their
signals: the first nb of them, from the last section back, span exactly the numerators of nb
coefficients; beyond nf, samples of the input itself follow. The delay of nk samples comes first.
The gain at rest is 1, because the static blocks around it have free gains.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.operators import sections
from martensite.kernels.namespace import Namespace, Scalar

RIGHT = 0.2
"""Share of drawn zeros in the right half plane."""


@BLOCKS.register("transfer-function")
class TransferFunction(AbstractBlock):
    """One input, one output; stable whatever its free numbers are."""

    short = "oe"
    shape = ("nb", "nf", "nk")
    linear = True

    nb: Number = param("1", "number of numerator coefficients (zeros + 1)", low=1.0, default=1.0, typical=3.0)
    nf: Number = param("1", "number of poles", low=0.0, default=1.0, typical=3.0)
    nk: Number = param("1", "delay in samples", low=0.0, default=1.0)

    def numbers(self) -> tuple[str, ...]:
        """Return the poles, then weights of all signals but the one that carries the gain."""
        return (*sections.name_sections(int(self.nf)), *(f"weight{k}" for k in range(2, int(self.nb) + 1)))

    def states(self) -> int:
        """Delayed inputs, sections, and inputs of the numerator beyond nf."""
        return int(self.nk) + int(self.nf) + self._taps

    @property
    def _taps(self) -> int:
        return max(int(self.nb) - int(self.nf) - 1, 0)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return everything has followed the input."""
        w = x[0]
        return [w] * int(self.nk) + sections.rest_cascade(int(self.nf), w) + [w] * self._taps

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Delay, sections, weighted sum."""
        nk, nf = int(self.nk), int(self.nf)
        line = [x[0], *state[:nk]]
        w, poles, past = line[-1], list(theta[:nf]), list(state[nk + nf :])
        made = sections.step_cascade(xp, nf, poles, list(state[nk : nk + nf]), w, dt)
        signals = [*made.signals, w, *past][: int(self.nb)]
        gains = [*made.unit_gain, True, *(True for _ in past)][: int(self.nb)]
        y, rest = 0.0, 1.0
        for weight, signal, gain in zip(theta[nf:], signals[1:], gains[1:], strict=True):
            y = y + weight * signal
            rest = rest - weight if gain else rest
        return (y + rest * signals[0],), (*line[:-1], *made.state, *[w, *past][: self._taps])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return the time constants spread over a thousandth to a quarter of the record, of zeros as well.

        One zero in five is to the right, where the output first moves the wrong way.
        """
        nf, nb = int(self.nf), int(self.nb)
        made = rng.uniform(-0.3, 1.3, len(self.numbers()))
        made[:nf] = sections.draw_numbers(nf, rng, duration, dt)
        count = min(nb - 1, nf)
        if count:
            leads = np.exp(rng.uniform(*sections.find_time_range(duration, dt), count))
            leads *= np.where(rng.random(count) < RIGHT, -1.0, 1.0)
            made[nf : nf + count] = sections.compute_weights(nf, made[:nf], leads)
        return made

    def twin(self) -> AbstractBlock:
        """Itself."""
        return self

    def start(self) -> Numbers:
        """Return the poles about one second apart in scale, and no zeros that matter."""
        nf = int(self.nf)
        made = np.zeros(len(self.numbers()))
        made[nf % 2 + 1 : nf : 2] = np.log(1.2)
        return made

    def poles(self, theta: Numbers, dt: float) -> Numbers:
        """Return the poles z of the sections."""
        return sections.find_poles(int(self.nf), theta, dt)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the time constants, frequencies, damping ratios and weights."""
        return sections.show_numbers(self.numbers(), theta)
