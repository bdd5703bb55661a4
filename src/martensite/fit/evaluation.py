"""Runs of a fit compared with measurements: residuals, derivatives, and a correction for noisy drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class FittedRecord:
    """Experiment with given parameters."""

    model: Any
    """(rows, outputs) in SI, offsets included."""
    residuals: Any
    """(rows, outputs), scaled and weighted; NaN for missing samples."""
    jacobian: Any
    """(rows, outputs, free): d(residual)/du; None if not requested."""


@dataclass(frozen=True)
class Evaluation:
    """Whole problem with given parameters."""

    fitted_records: tuple[FittedRecord, ...]
    """One record per experiment."""
    residuals: Any
    """(n,): used residuals, in the order of experiments and outputs."""
    jacobian: Any
    """(n, free), or None."""

    @property
    def cost(self) -> float:
        """Return the mean of the squared residuals."""
        return float(np.mean(self.residuals**2))


@dataclass(frozen=True)
class InputCorrection:
    """Correction for noise in the followed columns of an experiment; see `input_noise`."""

    inputs: Mapping[str, Any]
    """Drive -> estimated rows of its column, which replace the logged rows."""
    shift: Any
    """(used residuals,): first-order effect of this replacement."""
    parts: tuple[tuple[Any, Any, Any], ...]
    """Indices of residuals, directions (indices, k) of increased scatter, and their weight reductions."""

    def whiten(self, rows: Any) -> Any:
        """Return the residuals (n,), or derivatives (n, free), with equal scatter."""
        white_rows = rows.copy()
        for places, directions, less in self.parts:
            white_rows[places] -= directions @ (less * (directions.T @ rows[places]).T).T
        return white_rows
