"""Values with standard errors, error propagation, and column checks of all tests.

An estimate from few points has an uncertain standard error. Its interval is value ± t(level, ν) error with ν degrees of
freedom. For y = f(x₁, x₂, …) of independent estimates

    error(y)² = Σ ¼ [f(x_k + error_k) - f(x_k - error_k)]²

to first order, with the least of their degrees of freedom, which is conservative.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.confidence import EVERYTHING, LEVEL, Interval, student_quantile
from martensite.base.errors import DataError


def check_columns(test: str, rows: str, fewest: int, **columns: Sequence[float]) -> None:
    """Raise `DataError` unless columns have equal length, finite values, and at least `fewest` `rows` for a `test`."""
    lengths = [len(numbers) for numbers in columns.values()]
    names = " and ".join(columns).replace("_", " ")
    if len(set(lengths)) > 1:
        listed = " and ".join(map(str, lengths))
        raise DataError(f"The {names} of {test} must have equal lengths, but have {listed}.")
    if lengths[0] < fewest:
        raise DataError(f"A fit of {test} needs at least {fewest} {rows}, but has {lengths[0]}.")
    if not all(math.isfinite(number) for column in columns.values() for number in column):
        raise DataError(f"The {names} of {test} must be finite, but are not all.")


@dataclass(frozen=True)
class MeasuredValue:
    """Value, its standard error in the same unit, and its degrees of freedom."""

    value: float
    error: float = 0.0
    """Standard error; 0 for a given value, NaN without degrees of freedom."""
    freedom: float = math.inf
    """Degrees of freedom; infinite for a given value."""

    def interval(self, level: float = LEVEL) -> Interval:
        """Return the confidence interval; a point for a given value, unbounded without degrees of freedom."""
        if self.error == 0.0:
            return self.value, self.value
        if self.freedom < 1 or math.isnan(self.error):
            return EVERYTHING
        half = student_quantile(level, int(self.freedom)) * self.error
        return self.value - half, self.value + half

    def scaled(self, factor: float, offset: float = 0.0) -> MeasuredValue:
        """Return the value in another unit: offset + factor · value, with its error."""
        return MeasuredValue(offset + factor * self.value, abs(factor) * self.error, self.freedom)

    def write(self) -> str:
        """Return the value with half its interval."""
        low, high = self.interval()
        half = 0.5 * (high - low)
        if half == 0.0:
            return f"{self.value:.6g}"
        return f"{self.value:.6g} ± {half:.2g}" if math.isfinite(half) else f"{self.value:.6g} ± unknown"

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        return {"value": self.value, "standard_error": self.error, "interval": list(self.interval(level))}


def propagate_errors(function: Callable[..., float], *inputs: MeasuredValue) -> MeasuredValue:
    """Return a function of independent estimates, with its standard error to first order.

    Estimates without effect on the function do not count.
    """
    values = [one.value for one in inputs]
    square, freedom = 0.0, math.inf
    for place, one in enumerate(inputs):
        if one.error == 0.0:
            continue
        above, below = (
            function(*values[:place], one.value + sign * one.error, *values[place + 1 :]) for sign in (1.0, -1.0)
        )
        if above != below:
            square += 0.25 * (above - below) ** 2
            freedom = min(freedom, one.freedom)
    return MeasuredValue(function(*values), math.sqrt(square), freedom)
