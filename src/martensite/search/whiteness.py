"""Whiteness test of residuals, for structure that a better model could explain.

For white residuals of n samples, a fraction `level` of the autocorrelations ρ_k lies within ±z/√n, where z is the
quantile of the normal distribution, and

    Q = n (n + 2) Σ_{k=1..L} ρ_k²/(n - k)

is distributed as χ² with L degrees of freedom (Ljung and Box (1978), Biometrika 65). The autocorrelation ρ_k at lag k
and the number n_eff of independent samples are

    ρ_k = Σ r_t r_{t+k} / Σ r_t²,    τ = -1 + 2 Σ_m (ρ_{2m} + ρ_{2m+1}),    n_eff = n/τ

The sum covers the first pairs m = 0, 1, … that are all positive (the initial positive sequence: Geyer (1992),
Statistical Science 7), since the tail of an estimated ρ is noise. The mean is not subtracted: a constant error of the
model is also an error, with the strongest correlation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from statistics import NormalDist
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.confidence import LEVEL
from martensite.base.errors import DataError, ParameterError
from martensite.search.quantity_text import format_number

Vector: TypeAlias = NDArray[np.float64]
LEAST_SAMPLES = 10
"""Least number of samples for the test."""
LAGS = 20
"""Number of lags tested, for a record of at least five times this length."""


@dataclass(frozen=True)
class Whiteness:
    """Autocorrelation of the residuals of one record, and the test on it."""

    record: str
    autocorrelation: tuple[float, ...]
    """ρ_1 … ρ_L."""
    band: float
    """Half width of the band that contains a fraction `level` of ρ_k for white residuals."""
    statistic: float
    """Q of Ljung and Box."""
    p_value: float
    """Probability of at least this Q for white residuals."""
    samples: int
    level: float

    @property
    def white(self) -> bool:
        """Return whether the residuals pass the test at its level."""
        return self.p_value >= 1.0 - self.level

    @property
    def memory(self) -> int | None:
        """Return the first lag with an autocorrelation within the band; None if beyond the last lag."""
        lags = enumerate(self.autocorrelation, 1)
        return next((k for k, rho in lags if abs(rho) <= self.band), None)

    @property
    def sentence(self) -> str:
        """Return the verdict with its values."""
        outside = sum(abs(rho) > self.band for rho in self.autocorrelation)
        test = "p < 0.0001" if self.p_value < 1e-4 else f"p = {self.p_value:.2g}"
        counted = f"{outside} of {len(self.autocorrelation)} autocorrelations outside"
        numbers = f"(Ljung–Box {test}; {counted} ±{format_number(self.band, 2)})"
        if self.white:
            return f"`{self.record}`: residuals are white {numbers}; nothing is left to explain."
        first = format_number(self.autocorrelation[0], 2)
        lasting = f"past lag {len(self.autocorrelation)}"
        if self.memory is not None:
            lasting = f"until lag {self.memory}"
        return (
            f"`{self.record}`: residuals are not white {numbers}: {first} from one sample to the "
            f"next, felt {lasting}; the model misses something, or the noise has a memory, and "
            "intervals for independent samples are too narrow."
        )

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name and the verdict, for JSON."""
        return asdict(self) | {"white": self.white, "sentence": self.sentence}


def assess_whiteness(
    residuals: Any, record: str = "record", *, lags: int | None = None, level: float = LEVEL
) -> Whiteness:
    """Test the residuals (samples,) of one record, equally spaced in time.

    The default number L of lags is 20, or a fifth of a shorter record. The level applies to the band and to the test.

    Raises:
        DataError: there are fewer than 10 residuals, or they are not finite.
        ParameterError: the number of lags is invalid, or the level is not between 0 and 1.
    """
    count = len(residuals)
    if count < LEAST_SAMPLES:
        raise DataError(f"Whiteness takes at least {LEAST_SAMPLES} residuals, but there are {count}.")
    most = min(LAGS, count // 5) if lags is None else lags
    if not 1 <= most < count:
        raise ParameterError(f"Argument `lags` must be 1 to {count - 1}, but is {most}.")
    if not 0.0 < level < 1.0:
        raise ParameterError(f"Argument `level` must be between 0 and 1, but is {level:g}.")
    rho = [float(one) for one in compute_autocorrelation(residuals)[1 : most + 1]]
    weighted = sum(r * r / (count - k) for k, r in enumerate(rho, 1))
    statistic = count * (count + 2) * weighted
    chi2: Any = import_module("scipy.stats").chi2
    return Whiteness(
        record,
        tuple(rho),
        NormalDist().inv_cdf(0.5 + 0.5 * level) / math.sqrt(count),
        statistic,
        float(chi2.sf(statistic, most)),
        count,
        level,
    )


def compute_autocorrelation(residuals: Any, lengths: Sequence[int] | None = None) -> Vector:
    """Compute ρ_0 = 1, ρ_1, … up to the longest lag, from one or several consecutive records.

    Args:
        residuals: (samples,), equally spaced in time within each record.
        lengths: samples of each record. Products across their ends do not count.

    Returns:
        (longest record,); zeros, without the 1, if all residuals are 0.

    Raises:
        DataError: the residuals are empty, not finite, or inconsistent with `lengths`.
    """
    errors = require_residuals(residuals)
    parts = [len(errors)] if lengths is None else list(lengths)
    if sum(parts) != len(errors) or min(parts, default=0) < 1:
        raise DataError(f"There are {len(errors)} residuals, but records of {parts} samples.")
    total = np.zeros(max(parts))
    for piece in np.split(errors, np.cumsum(parts)[:-1]):
        padded = np.fft.rfft(piece, 2 * len(piece))
        total[: len(piece)] += np.fft.irfft(np.abs(padded) ** 2, 2 * len(piece))[: len(piece)]
    return total / total[0] if total[0] > 0.0 else np.zeros(max(parts))


def count_effective_samples(residuals: Any, lengths: Sequence[int] | None = None) -> float:
    """Return the effective number of independent samples, at most all samples; see `compute_autocorrelation`.

    Raises:
        DataError: the residuals are empty, not finite, or inconsistent with `lengths`.
    """
    rho = compute_autocorrelation(residuals, lengths)
    count = len(residuals)
    even = rho[: 2 * (len(rho) // 2)].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(even <= 0.0)
    first = int(ends[0]) if len(ends) else len(even)
    time = -1.0 + 2.0 * float(np.sum(even[:first]))
    return min(count / max(time, 1.0), float(count))


def require_residuals(residuals: Any) -> Vector:
    """Return the residuals as an array, scaled to at most 1 against overflow and underflow of squares.

    Raises:
        DataError: the residuals are empty or not finite.
    """
    errors = np.asarray(residuals, np.float64)
    if errors.ndim != 1 or not len(errors):
        raise DataError(f"Residuals must have one dimension, but have the shape {errors.shape}.")
    if not np.isfinite(errors).all():
        raise DataError("Some residuals are not finite: a run has failed.")
    largest = float(np.max(np.abs(errors)))
    return errors / largest if largest > 0.0 else errors
