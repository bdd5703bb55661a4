"""Trust in a filter: by its own spread, and by a test of its readings against their predictions.

    c = 1/(1 + (s_ξ/s_0)⁴)  ·  clip((z_1 - max z)/(z_1 - z_0), 0, 1)

The first factor is the spread of the martensite fraction against what it shall be known to, s_0: where d ln R/dξ is
near 0, at unknown resistivities, and where the model has long been alone, it falls. The second one tests innovations
ν_k, divided by their standard deviations, over a sliding window with n samples (exponentially faded, a = 1/n):

    bias       z = |m(ν)|/√v          mean of ν: 0 for a consistent filter
    size       z = |m(ν² - 1)|/√2v    NIS: 1
    whiteness  z = |m(ν_k ν_k-1)|/√v  neighbours: uncorrelated          v = a/(2 - a)

each a standard normal number in the mean over a consistent filter. A mean NIS alone stays quiet on a wrong wire, since
the gain bends the estimate until the readings fit; on the way there, innovations have one sign.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 5.4, with windows that fade.
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
    """The innovation before, normalised."""


class Trust(Parametrised):
    """Parameters of the confidence."""

    window: Number = param("s", "time constant of the means", above=0.0, default=2.0)
    fraction: Number = param("1", "spread s_0 of ξ at which it is a half", above=0.0, default=0.05)
    quiet: Number = param("1", "z_0, up to which a test says nothing", low=0.0, default=4.0)
    loud: Number = param("1", "z_1, from which on nothing is left", above=0.0, default=7.0)

    def advance(self, xp: Namespace, before: TrustState, innovation: Scalar, fresh: Scalar, dt: Scalar) -> TrustState:
        """Return the means with another normalised innovation, if its reading is fresh."""
        share = fresh * self._share(dt)
        # An innovation far beyond any noise shall not ring on for many windows.
        limited = xp.clip(innovation, -10.0, 10.0)
        return TrustState(
            before.bias + share * (limited - before.bias),
            before.size + share * (limited * limited - 1.0 - before.size),
            before.pairs + share * (limited * before.last - before.pairs),
            xp.where(fresh > 0.5, limited, before.last),
        )

    def confidence(self, xp: Namespace, now: TrustState, spread: Scalar, dt: Scalar) -> Scalar:
        """Between 0 and 1, with the standard deviation of the martensite fraction."""
        share = self._share(dt)
        unit = xp.sqrt(share / (2.0 - share))
        worst = xp.maximum(xp.abs(now.bias), xp.maximum(xp.abs(now.size) / 2.0**0.5, xp.abs(now.pairs))) / unit
        passed = xp.clip((self.loud - worst) / (self.loud - self.quiet), 0.0, 1.0)
        ratio = spread / self.fraction
        return passed / (1.0 + ratio * ratio * ratio * ratio)

    def _share(self, dt: Scalar) -> Scalar:
        return dt / (self.window + dt)
