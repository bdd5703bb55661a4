"""Natural cubic spline on even knots, with linear ends.

    y = offset + Σ_k c_k N((r - r_k)/h),    N(t) = ((2 - |t|)₊³ - 4 (1 - |t|)₊³)/6

r is the input on the scale of its range, h the distance of the knots, N a cubic B-spline. The two coefficients beyond
the ends follow from zero curvature there. Coefficients of a line are its values at the knots; the first is the offset.

Source: de Boor 1978.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar


def evaluate_bell(xp: Namespace, t: Scalar) -> Scalar:
    """Return N(t), 2/3 at 0 and 0 beyond ±2."""
    away = xp.abs(t)
    wide, narrow = xp.maximum(2.0 - away, 0.0), xp.maximum(1.0 - away, 0.0)
    return (wide * wide * wide - 4.0 * narrow * narrow * narrow) / 6.0


@BLOCKS.register("spline")
class Spline(AbstractCurve):
    """A smooth curve, linear in its free numbers."""

    short = "spline"
    shape = ("knots",)
    cites = ("deboor1978",)

    knots: Number = param("1", "number of knots", low=2.0, high=200.0, default=10.0, typical=4.0)

    def heights(self) -> tuple[str, ...]:
        return tuple(f"c{k}" for k in range(2, int(self.knots) + 1))

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        values = [0.0, *heights]
        all_ = [2.0 * values[0] - values[1], *values, 2.0 * values[-1] - values[-2]]
        gaps = len(values) - 1
        inside = xp.clip(r, -1.0, 1.0)
        place = 0.5 * gaps * (inside + 1.0)
        total: Scalar = 0.0
        for k, coefficient in enumerate(all_):
            total = total + coefficient * evaluate_bell(xp, place - (k - 1.0))
        slope = xp.where(r < 0.0, values[1] - values[0], values[-1] - values[-2])
        return total + 0.5 * gaps * slope * (r - inside)

    def line(self, slope: float, offset: float) -> Numbers:
        values = slope * self.half * np.linspace(0.0, 2.0, int(self.knots))[1:]
        return self.join_numbers(offset + slope * self.low, values)

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        count = len(self.heights())
        theta[self.first :] += rng.normal(0.0, 0.1, count) * abs(theta[-1])
        return theta

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return self.describe_knots(theta, np.linspace(self.low, self.high, int(self.knots)))
