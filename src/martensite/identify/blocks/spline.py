"""Natural cubic spline on even knots: smooth to the second derivative, lines beyond the range.

    y = offset + Σ_k c_k N((r - r_k)/h),    N(t) = ((2 - |t|)₊³ - 4 (1 - |t|)₊³)/6

r is the input on the scale of its range, h the distance of the knots, N the bell of a cubic
spline. The two coefficients beyond the ends follow from a curvature of zero there. Coefficients
of a straight line are its values at the knots; the first is the offset.

Source: de Boor 1978.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar


def evaluate_bell(xp: Namespace, t: Scalar) -> Scalar:
    """N(t), 2/3 at 0 and 0 beyond ±2."""
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
        """Return the coefficients but the first, relative to it."""
        return tuple(f"c{k}" for k in range(2, int(self.knots) + 1))

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Return the bells within the range, and the slope at its end beyond."""
        own = [0.0, *heights]
        all_ = [2.0 * own[0] - own[1], *own, 2.0 * own[-1] - own[-2]]
        gaps = len(own) - 1
        inside = xp.clip(r, -1.0, 1.0)
        place = 0.5 * gaps * (inside + 1.0)
        total: Scalar = 0.0
        for k, coefficient in enumerate(all_):
            total = total + coefficient * evaluate_bell(xp, place - (k - 1.0))
        slope = xp.where(r < 0.0, own[1] - own[0], own[-1] - own[-2])
        return total + 0.5 * gaps * slope * (r - inside)

    def line(self, slope: float, offset: float) -> Numbers:
        """Return every line."""
        level = (offset + slope * self.low,)[: self.first]
        values = slope * self.half * np.linspace(0.0, 2.0, int(self.knots))[1:]
        return np.concatenate([level, values])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return the coefficients off the line by about a tenth of its rise."""
        made = self.start()
        count = len(self.heights())
        made[self.first :] += rng.normal(0.0, 0.1, count) * abs(made[-1])
        return made

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the outputs at the knots."""
        numbers = [float(v) for v in theta]
        rows: list[tuple[str, float, str]] = []
        for i, knot in enumerate(np.linspace(self.low, self.high, int(self.knots)), start=1):
            rows.append((f"knot{i}", float(knot), "1"))
            rows.append((f"output{i}", float(self.value(floats, numbers, float(knot))), "1"))
        return rows
