"""Arrays: the kernel operations over NumPy, one array element per variant.

The trigonometry of cosine kinetics is a polynomial on the clipped interval, which makes a batch about twice as fast as
the sine of the library.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from martensite.kernels import floats
from martensite.kernels.floats import expand_power
from martensite.kernels.polynomials import ERFCX, ERFCX_CENTRE, QUARTER_SINE


class ArrayNamespace:
    """The operations over the module `np`, which is NumPy."""

    def __init__(self, np: Any) -> None:
        self.level = 0
        self.np = np
        self.where = np.where
        self.both = np.logical_and
        self.either = np.logical_or
        self.negate = np.logical_not
        self.abs = np.abs
        self.sin, self.cos, self.tanh = np.sin, np.cos, np.tanh
        self.detach, self.eps = floats.detach, floats.eps
        self.each, self.scan, self.repeat = floats.each, floats.scan, floats.repeat
        self.implicit_root = floats.implicit_root

    def iterate(self, most: int, body: Any, *state: Any) -> Sequence[Any]:
        """Return the state after iterations of a body; elements with a first variable not above 0 stay constant."""
        now: Sequence[Any] = state
        for _ in range(most):
            going = now[0] > 0.0
            if not self.np.any(going):
                break
            now = [self.np.where(going, a, b) for a, b in zip(body(*now), now, strict=True)]
        return now

    def minimum(self, a: Any, b: Any) -> Any:
        """Return the smaller of two; as on floats, `b` if they cannot be compared."""
        return self.np.where(a < b, a, b)

    def maximum(self, a: Any, b: Any) -> Any:
        """Return the larger of two; as on floats, `b` if they cannot be compared."""
        return self.np.where(a > b, a, b)

    def clip(self, x: Any, low: Any, high: Any) -> Any:
        """Return `x` limited to [low, high]."""
        return self.minimum(self.maximum(x, low), high)

    def sqrt(self, x: Any) -> Any:
        """Return the square root; 0 (with derivative 0) for negative arguments."""
        positive = x > 0.0
        return self.np.where(positive, self.np.sqrt(self.np.where(positive, x, 1.0)), 0.0)

    def exp(self, x: Any) -> Any:
        """Return the exponential; the argument is limited to 700."""
        return self.np.exp(self.minimum(x, 700.0))

    def log(self, x: Any) -> Any:
        """Return the natural logarithm; the argument is at least 1e-300."""
        return self.np.log(self.maximum(x, 1e-300))

    def power(self, base: Any, exponent: Any) -> Any:
        """Return `base` to the `exponent`; 0 (with derivatives 0) for a base of 0 or below."""
        if isinstance(exponent, int):
            return expand_power(base, exponent)
        positive = base > 0.0
        safe = self.np.where(positive, base, 1.0)
        fits = exponent * self.np.log(safe) < 700.0
        value = self.np.power(safe, self.np.where(fits, exponent, 0.0))
        return self.np.where(positive, self.np.where(fits, value, floats.LARGEST), 0.0)

    def nearest(self, x: Any) -> Any:
        """Return the nearest whole number, the even number of two; differentiation takes it as `x`."""
        return x + self.detach(self.np.rint(x) - x)

    def quarter_sine(self, x: Any) -> Any:
        """Return sin(πx/2) for 0 ≤ x ≤ 1 by Horner's rule."""
        return evaluate_horner(QUARTER_SINE, x * x) * x

    def erfcx(self, x: Any) -> Any:
        """Return exp(x²) erfc(x) for x ≥ 0 by Horner's rule."""
        t = (x - ERFCX_CENTRE) / (x + ERFCX_CENTRE)
        return evaluate_horner(ERFCX, t) / (1.0 + 2.0 * x)


def evaluate_horner(coefficients: Sequence[float], x: Any) -> Any:
    """Return a polynomial with the coefficients of ascending powers."""
    total: Any = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total
