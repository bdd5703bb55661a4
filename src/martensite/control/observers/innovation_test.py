r"""Do innovations look like those of a filter whose model holds? A test that goes along.

With ν the innovation of a reading and S its variance as the filter claims it, z = ν/√S is white, of mean 0 and variance
1. Running means over a window τ, α = 1 - exp(-T/τ),

    m ← m + α (z - m),     q ← q + α (z² - q)

m then has the variance 1/n, n = (2 - α)/α, and n q is about chi-square distributed with n degrees of freedom, so that
(Wilson and Hilferty, 1931) q^⅓ has about the mean 1 - 2/(9n) and the variance 2/(9n). The squares of both over their
variances are chi-square distributed with one degree of freedom; the larger one, over a bound, is the `misfit`. A wrong
model shows in m long before it shows in q. z is cut off at ±5, so that one absurd reading alone decides nothing. Of q
only values above the mean count.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 5.4 (time-average tests), with exponential weights.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.control.observers.covariance import UnknownReading
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import find_largest

MOST_DEVIATIONS = 5.0
"""Deviations beyond which an innovation counts no more."""


class RunningTest(NamedTuple):
    """Running means of the innovations of one reading."""

    mean: Scalar = 0.0
    square: Scalar = 1.0

    def add(self, xp: Namespace, found: UnknownReading, share: Scalar) -> "RunningTest":
        """With another innovation and the variance claimed of it, whose weight is a share."""
        z = xp.clip(found.value / xp.sqrt(found.variance), -MOST_DEVIATIONS, MOST_DEVIATIONS)
        weight = share * found.used
        return RunningTest(self.mean + weight * (z - self.mean), self.square + weight * (z * z - self.square))

    def statistic(self, xp: Namespace, share: Scalar) -> Scalar:
        """Return the larger one of both chi-squares."""
        count = (2.0 - share) / share
        variance = 2.0 / (9.0 * count)
        more = xp.maximum(xp.power(self.square, 1.0 / 3.0) - 1.0 + variance, 0.0)
        return xp.maximum(count * self.mean * self.mean, more * more / variance)


def find_misfit(xp: Namespace, tests: Sequence[RunningTest], share: Scalar, bound: Scalar) -> Scalar:
    """Return the largest statistic of all readings over its bound: above 1 the model does not hold."""
    return find_largest(xp, [one.statistic(xp, share) for one in tests]) / bound
