"""Running test of the innovations of a filter.

With the innovation ν of a reading and its predicted variance S, z = ν/√S is white, of mean 0 and variance 1 if the
model holds. Running means over a window τ, α = 1 - exp(-T/τ),

    m ← m + α (z - m),     q ← q + α (z² - q)

m then has the variance 1/n, n = (2 - α)/α, and n q is about chi-square distributed with n degrees of freedom, so that
q^⅓ has about the mean 1 - 2/(9n) and the variance 2/(9n) (Wilson and Hilferty, 1931). The squares of both over their
variances are chi-square distributed with one degree of freedom; the larger one over a bound is the `misfit`. A wrong
model affects m long before q. z is limited to ±5, so that a single outlier does not decide. Only values of q above
the mean count.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 5.4 (time-average tests), with exponential weights.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.control.observers.covariance import UnknownReading
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import find_largest

MOST_DEVIATIONS = 5.0
"""Limit of a normalised innovation."""


class RunningTest(NamedTuple):
    """Running means of the innovations of one reading."""

    mean: Scalar = 0.0
    square: Scalar = 1.0

    def add(self, xp: Namespace, innovation: UnknownReading, weight: Scalar) -> "RunningTest":
        """Return the test with another innovation and its predicted variance."""
        z = xp.clip(innovation.value / xp.sqrt(innovation.variance), -MOST_DEVIATIONS, MOST_DEVIATIONS)
        gain = weight * innovation.is_used
        return RunningTest(self.mean + gain * (z - self.mean), self.square + gain * (z * z - self.square))

    def statistic(self, xp: Namespace, weight: Scalar) -> Scalar:
        """Return the larger of both chi-squares."""
        count = (2.0 - weight) / weight
        variance = 2.0 / (9.0 * count)
        more = xp.maximum(xp.power(self.square, 1.0 / 3.0) - 1.0 + variance, 0.0)
        return xp.maximum(count * self.mean * self.mean, more * more / variance)


def find_misfit(xp: Namespace, tests: Sequence[RunningTest], weight: Scalar, bound: Scalar) -> Scalar:
    """Return the largest statistic of all readings over its bound; above 1 the model does not hold."""
    return find_largest(xp, [one.statistic(xp, weight) for one in tests]) / bound
