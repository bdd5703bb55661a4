"""Confidence of a filter, from its spread and a test of its innovations.

    c = 1/(1 + (s_ξ/s_0)⁴)  ·  clip((z_1 - max z)/(z_1 - z_0), 0, 1)

The first factor compares the spread of the martensite fraction with s_0: it falls where d ln R/dξ is near 0, with
unknown resistivities, and after a long time without readings. The second factor tests the normalised innovations ν_k
over an exponential window of n samples, a = 1/n, v = a/(2 - a):

    bias       z = |m(ν)|/√v          mean of ν: 0 for a consistent filter
    size       z = |m(ν² - 1)|/√2v    mean NIS: 1
    whiteness  z = |m(ν_k ν_k-1)|/√v  neighbours: uncorrelated

Each z is a standard normal number for a consistent filter. A mean NIS alone does not detect a wrong wire, since the
gain bends the estimate until the readings fit; until then, innovations have one sign.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 5.4, with exponential windows.
"""

from typing import NamedTuple

from martensite.base.parameters import Number, Parametrised, param
from martensite.kernels.namespace import Namespace, Scalar


class TrustState(NamedTuple):
    """Running means."""

    bias: Scalar = 0.0
    size: Scalar = 0.0
    pairs: Scalar = 0.0
    last: Scalar = 0.0


class Trust(Parametrised):
    """Parameters of the confidence."""

    window: Number = param("s", "time constant of the means", above=0.0, default=2.0)
    fraction: Number = param("1", "spread s_0 of ξ at a confidence of 0.5", above=0.0, default=0.05)
    quiet: Number = param("1", "z_0, largest test value without an effect", low=0.0, default=4.0)
    loud: Number = param("1", "z_1, test value at a confidence of 0", above=0.0, default=7.0)

    def advance(self, xp: Namespace, before: TrustState, innovation: Scalar, fresh: Scalar, dt: Scalar) -> TrustState:
        """Return the means with another normalised innovation, if its reading is fresh."""
        weight = fresh * self._share(dt)
        # An outlier must not act for many windows.
        limited = xp.clip(innovation, -10.0, 10.0)
        return TrustState(
            before.bias + weight * (limited - before.bias),
            before.size + weight * (limited * limited - 1.0 - before.size),
            before.pairs + weight * (limited * before.last - before.pairs),
            xp.where(fresh > 0.5, limited, before.last),
        )

    def confidence(self, xp: Namespace, now: TrustState, spread: Scalar, dt: Scalar) -> Scalar:
        """Return the confidence between 0 and 1, from the standard deviation of the martensite fraction."""
        ratio = spread / self.fraction
        return self.test_innovations(xp, now, dt) / (1.0 + ratio * ratio * ratio * ratio)

    def test_innovations(self, xp: Namespace, now: TrustState, dt: Scalar) -> Scalar:
        """Return 1 if the innovations pass the test, 0 if they fail, and values in between."""
        weight = self._share(dt)
        unit = xp.sqrt(weight / (2.0 - weight))
        worst = xp.maximum(xp.abs(now.bias), xp.maximum(xp.abs(now.size) / 2.0**0.5, xp.abs(now.pairs))) / unit
        return xp.clip((self.loud - worst) / (self.loud - self.quiet), 0.0, 1.0)

    def _share(self, dt: Scalar) -> Scalar:
        return dt / (self.window + dt)
