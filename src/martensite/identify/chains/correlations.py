"""Correlation of residuals with inputs: the unexplained part of a model.

For residuals ε and a signal w, both without their means,

    r(τ) = Σ_t ε_{t+τ} w_t / √(Σ ε² Σ w²),    var r(τ) ≈ Σ_k ρ_ε(k) ρ_w(k)/n

if ε does not depend on w (Bartlett; Ljung (1999), System Identification, section 16.6). The sum over all lags of both
estimated autocorrelations makes the band valid for coloured inputs and residuals. Neighbouring lags are strongly
correlated, so the number of lags outside the band proves nothing. The test uses the largest lag, with the level
divided among the lags.

At lags τ > 0 residuals follow the signal: the model lacks some of its effect. At lags τ < 0 they lead it: a controller
made the input from the output.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import Numbers
from martensite.search.quantity_text import format_number
from martensite.search.whiteness import compute_autocorrelation

LAGS = 25
"""Number of tested lags on either side."""
LEVELS = (0.95, 0.99)
"""Confidence levels of the displayed bands."""
LEVEL = 0.99
"""Confidence level of the verdict for all lags."""


@dataclass(frozen=True)
class CrossCorrelation:
    """Correlation of the residuals of one output with one signal."""

    output: str
    signal: str
    """Name of the signal, such as `u` or `u²`."""
    lags: tuple[int, ...]
    values: tuple[float, ...]
    deviation: float
    """Standard deviation of every value without a correlation."""
    interval: float
    """Sample time [s]."""
    level: float = LEVEL

    def band(self, level: float) -> float:
        """Return the half width of the band of one value for a probability."""
        return NormalDist().inv_cdf(0.5 + 0.5 * level) * self.deviation

    @property
    def limit(self) -> float:
        """Return the half width of the band of all values on one side for the level of the verdict."""
        side = max(sum(lag >= 0 for lag in self.lags), 1)
        return self.band(1.0 - (1.0 - self.level) / side)

    @property
    def following(self) -> tuple[int, float]:
        """Return lag and value of the largest correlation at lags from 0 on."""
        return self._largest([i for i, lag in enumerate(self.lags) if lag >= 0])

    @property
    def leading(self) -> tuple[int, float]:
        """Return lag and value of the largest correlation at negative lags."""
        return self._largest([i for i, lag in enumerate(self.lags) if lag < 0])

    @property
    def explained(self) -> bool:
        """Return whether the residuals that follow the signal are uncorrelated."""
        return abs(self.following[1]) <= self.limit

    @property
    def sentence(self) -> str:
        """Return the verdict with its numbers."""
        lag, value = self.following
        pair = f"residuals of `{self.output}` and {self.signal}"
        size = f"{format_number(value, 2)} after {format_number(lag * self.interval, 3)} s"
        within = f"±{format_number(self.limit, 2)} of chance"
        if self.explained:
            return f"The {pair} are not correlated (at most {size}, within {within})."
        square = "bend of a static block" if "²" in self.signal else "dynamics"
        return (
            f"The {pair} are correlated ({size}, beyond {within}): the model lacks some of its "
            f"effect; try another order, delay or {square}."
        )

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name and the verdict, for JSON."""
        return asdict(self) | {"limit": self.limit, "explained": self.explained, "sentence": self.sentence}

    def _largest(self, places: Sequence[int]) -> tuple[int, float]:
        if not places:
            return 0, 0.0
        top = max(places, key=lambda i: abs(self.values[i]))
        return self.lags[top], self.values[top]


def correlate_residuals(
    residuals: Any,
    signal: Any,
    interval: float,
    *,
    output: str = "y",
    name: str = "u",
    lags: Sequence[int] | None = None,
    level: float = LEVEL,
) -> CrossCorrelation | None:
    """Correlate the residuals of one output with a signal; None if either is constant.

    Args:
        residuals: shape (samples,), NaN where unknown.
        signal: shape (samples,).
        interval: sample time [s].
        output: name of the output.
        name: name of the signal.
        lags: lags in samples; default: `spread_lags`.
        level: confidence level of the verdict.

    Raises:
        DataError: the lengths differ, or a lag is beyond the record.
    """
    e, w = np.asarray(residuals, dtype=float), np.asarray(signal, dtype=float)
    if e.shape != w.shape or e.ndim != 1:
        raise DataError(f"Residuals and signal must be equally many, not {e.shape}, {w.shape}.")
    finite_rows = np.isfinite(e)
    count = int(finite_rows.sum())
    if count < 2:
        return None
    e = np.where(finite_rows, e - e[finite_rows].mean(), 0.0)
    w = np.where(finite_rows, w - w[finite_rows].mean(), 0.0)
    size = math.sqrt(float(e @ e) * float(w @ w))
    if size == 0.0:
        return None
    rho_e, rho_w = compute_autocorrelation(e), compute_autocorrelation(w)
    chosen = spread_lags(rho_e, rho_w) if lags is None else list(lags)
    if any(abs(lag) >= len(e) for lag in chosen):
        raise DataError(f"A lag of {max(map(abs, chosen))} is beyond {len(e)} samples.")
    variance = max(1.0 + 2.0 * float(rho_e[1:] @ rho_w[1:]), 0.0) / count
    values = [float(_sum_shifted(e, w, lag)) / size for lag in chosen]
    return CrossCorrelation(
        output, name, tuple(chosen), tuple(values), math.sqrt(max(variance, 1.0 / count**2)), interval, level
    )


def spread_lags(*autocorrelations: Numbers) -> list[int]:
    """Return equally spaced lags from -L to L, over four correlation times."""
    memory = max(_find_memory(rho) for rho in autocorrelations)
    most = len(autocorrelations[0]) // 5
    step = max(1, min(4 * memory, most) // LAGS)
    return [step * k for k in range(-LAGS, LAGS + 1) if abs(step * k) <= max(most, 1)]


def _find_memory(rho: Numbers) -> int:
    """Return the first lag at which an autocorrelation has fallen to 1/e."""
    below = np.flatnonzero(rho < math.exp(-1.0))
    return int(below[0]) if len(below) else len(rho)


def _sum_shifted(e: Numbers, w: Numbers, lag: int) -> float:
    return float(e[lag:] @ w[: len(w) - lag]) if lag >= 0 else float(e[:lag] @ w[-lag:])
