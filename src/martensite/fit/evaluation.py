"""Runs of a fit compared with what was measured: residuals, derivatives, and a correction for noisy drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class FittedRecord:
    """One experiment at some parameters."""

    model: Any
    """(rows, outputs) in SI, offsets included."""
    residuals: Any
    """(rows, outputs), scaled and weighted; NaN where nothing was measured."""
    jacobian: Any
    """(rows, outputs, free): d(residual)/du; None if it was not asked for."""


@dataclass(frozen=True)
class Evaluation:
    """The whole problem at some parameters."""

    fitted: tuple[FittedRecord, ...]
    """One per experiment."""
    residuals: Any
    """(n,): those that count, one output of one experiment after the other."""
    jacobian: Any
    """(n, free), or None."""

    @property
    def cost(self) -> float:
        """Return the mean of the squared residuals."""
        return float(np.mean(self.residuals**2))


@dataclass(frozen=True)
class InputCorrection:
    """Correction for noise in the columns that an experiment follows; see `input_noise`."""

    inputs: Mapping[str, Any]
    """Drive -> estimated rows of its column, in place of those logged."""
    shift: Any
    """(used residuals,): what the difference of both does, to first order."""
    parts: tuple[tuple[Any, Any, Any], ...]
    """Places of residuals, directions (places, k) in which they scatter more, and how much less each counts."""

    def whiten(self, rows: Any) -> Any:
        """Return the residuals (n,), or derivatives (n, free), such that all scatter alike."""
        found = rows.copy()
        for places, directions, less in self.parts:
            found[places] -= directions @ (less * (directions.T @ rows[places]).T).T
        return found
