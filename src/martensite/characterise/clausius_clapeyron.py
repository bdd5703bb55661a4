"""Transformation temperatures over stress: Clausius–Clapeyron slopes, zero-stress temperatures.

Temperatures are measured and stresses are set, so temperature is fitted against stress:

    T_i = T_0 + b σ_i,    C = 1/b

for each of A_s, A_f, M_s, M_f and the half-way temperatures by itself, and for each direction with
one slope common to its start and its finish,

    A_s,i = A_s + b_A σ_i,    A_f,i = A_f + b_A σ_i;    M_s, M_f and b_M alike.

The common slope is that of the middles (A_s,i + A_f,i)/2, which is the least-squares solution of
both lines together; start and finish at zero stress are half the mean width below and above the
middle there. Errors of start and finish at one stress may go together, as those of one steep line
do: middles and widths have errors of their own, which are added as independent ones, with the
degrees of freedom of Welch and Satterthwaite. Errors at different stresses are taken as
independent: n - 2 points to spare for a slope, so that with two stresses intervals are unbounded.
The interval of C is that of b, inverted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.confidence import EVERYTHING, LEVEL, Interval
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.polynomial_regression import LinearFit, fit_powers
from martensite.characterise.tangent_points import TangentPoints


@dataclass(frozen=True)
class Direction:
    """One direction of the transformation over stress."""

    names: tuple[str, str]
    """Names of its start and finish temperature."""
    start: MeasuredValue
    """At zero stress, along the common slope [K]."""
    finish: MeasuredValue
    """At zero stress, along the common slope [K]."""
    shift: MeasuredValue
    """Common slope b of temperature against stress [K/Pa]."""
    own: dict[str, LinearFit]
    """Start, finish and half-way temperature, each over stress with a slope of its own."""
    widening: float
    """Probability of widths that change so much with stress were the slopes equal; NaN without a
    point to spare."""

    @property
    def slope(self) -> float:
        """Clausius–Clapeyron slope C = 1/b [Pa/K]; negative if the temperatures fall."""
        return 1.0 / self.shift.value if self.shift.value else math.inf

    def slope_interval(self, level: float = LEVEL) -> Interval:
        """Confidence interval of C [Pa/K]; unbounded if b may be zero."""
        return invert_interval(self.shift.interval(level))

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """All numbers by name, for JSON."""
        own = {
            name: {
                "zero_stress": fit.coefficient(0).to_dict(level),
                "slope": 1.0 / fit.values[1] if fit.values[1] else None,
                "slope_interval": list(invert_interval(fit.interval(1, level))),
            }
            for name, fit in self.own.items()
        }
        return {
            self.names[0]: self.start.to_dict(level),
            self.names[1]: self.finish.to_dict(level),
            "slope": self.slope,
            "slope_interval": list(self.slope_interval(level)),
            "separately": own,
            "widening_p_value": self.widening,
        }


def fit_direction(levels: Sequence[TangentPoints], names: tuple[str, str], half: str) -> Direction:
    """Fit the temperatures of one direction over stress.

    Args:
        levels: cycles at two or more different stresses.
        names: the start and the finish temperature, as `TangentPoints` calls them.
        half: the half-way temperature.
    """
    stresses = [points.stress for points in levels]
    columns = {name: [getattr(p, name) for p in levels] for name in (*names, half)}
    own = {name: fit_powers(stresses, column, (0, 1)) for name, column in columns.items()}
    pairs = list(zip(*(columns[name] for name in names), strict=True))
    widths = [b - a for a, b in pairs]
    middle = fit_powers(stresses, [0.5 * (a + b) for a, b in pairs], (0, 1))
    width = fit_powers(stresses, widths, (0,)).coefficient(0)
    start, finish = (_add_width(middle.coefficient(0), width, sign) for sign in (-0.5, 0.5))
    widening = fit_powers(stresses, widths, (0, 1)).p_value(1)
    return Direction(names, start, finish, middle.coefficient(1), own, widening)


def _add_width(middle: MeasuredValue, width: MeasuredValue, sign: float) -> MeasuredValue:
    """middle + sign width, whose errors are independent."""
    value = middle.value + sign * width.value
    parts = (middle.error**2, middle.freedom), ((sign * width.error) ** 2, width.freedom)
    total = sum(square for square, _ in parts)
    if not total > 0.0:  # no scatter, or none that is known
        return MeasuredValue(value, math.sqrt(total), middle.freedom)
    freedom = total**2 / sum(square**2 / spare for square, spare in parts)
    return MeasuredValue(value, math.sqrt(total), freedom)


def invert_interval(interval: Interval) -> Interval:
    """Interval of 1/b from that of b; unbounded if b may be zero."""
    low, high = interval
    if low <= 0.0 <= high:
        return EVERYTHING
    return 1.0 / high, 1.0 / low
