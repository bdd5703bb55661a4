"""How far the residuals of neighbouring samples are alike, and how many count as independent.

    ρ_k = Σ r_t r_{t+k} / Σ r_t²,    τ = -1 + 2 Σ_m (ρ_{2m} + ρ_{2m+1}),    n_eff = n/τ

The sum runs over the first pairs m = 0, 1, … that are all positive (the initial positive
sequence: Geyer (1992), Statistical Science 7), since the tail of an estimated ρ is only noise.
The mean is not taken off: what the model misses everywhere alike is an error like any other,
and the most strongly correlated one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError

Vector: TypeAlias = NDArray[np.float64]


def compute_autocorrelation(residuals: Any, lengths: Sequence[int] | None = None) -> Vector:
    """ρ_0 = 1, ρ_1, … up to the longest lag, from one or several records in a row.

    Args:
        residuals: (samples,), equally spaced in time within each record.
        lengths: samples of each record; products across their ends do not count.

    Returns:
        (longest record,); zeros, without the 1, if there is no residual at all.

    Raises:
        DataError: the residuals are none or not finite, or not as many as `lengths` say.
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
    """Number of independent samples with as much to say; at most the number of samples.

    Args:
        residuals: (samples,), equally spaced in time within each record.
        lengths: samples of each record.

    Raises:
        DataError: the residuals are none or not finite, or not as many as `lengths` say.
    """
    rho = compute_autocorrelation(residuals, lengths)
    count = len(residuals)
    even = rho[: 2 * (len(rho) // 2)].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(even <= 0.0)
    first = int(ends[0]) if len(ends) else len(even)
    time = -1.0 + 2.0 * float(np.sum(even[:first]))
    return min(count / max(time, 1.0), float(count))


def require_residuals(residuals: Any) -> Vector:
    """The residuals as an array, scaled to at most 1 so that no square over- or underflows.

    Raises:
        DataError: they are none, or not finite.
    """
    errors = np.asarray(residuals, np.float64)
    if errors.ndim != 1 or not len(errors):
        raise DataError(f"Residuals must be a row of numbers, but have the shape {errors.shape}.")
    if not np.isfinite(errors).all():
        raise DataError("Residuals must be finite, but are not all; a run has failed.")
    largest = float(np.max(np.abs(errors)))
    return errors / largest if largest > 0.0 else errors
