"""How well a model reproduces a record."""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import Numbers


def fit_percent(measured: Numbers, computed: Numbers, skip: int = 0) -> Numbers:
    """NRMSE fit 100 (1 - |y - ŷ|/|y - mean y|) [%] of every output, over what is known."""
    y, error = measured[skip:], (measured - computed)[skip:]
    away = np.sqrt(np.nansum((y - np.nanmean(y, axis=0)) ** 2, axis=0))
    return 100.0 * (1.0 - np.sqrt(np.nansum(error**2, axis=0)) / away)


def compute_rms(measured: Numbers, computed: Numbers, skip: int = 0) -> Numbers:
    """Root mean square of the error of every output."""
    return np.sqrt(np.nanmean((measured - computed)[skip:] ** 2, axis=0))
