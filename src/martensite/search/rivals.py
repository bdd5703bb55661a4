"""Criterion by which a model predicts an output, for fits and for black-box models.

The held-out error must be clearly below the error of every baseline, and most of the variation must be explained:

    error < BETTER · least error of a rival,    1 - error/spread ≥ EXPLAINED

A model that explains at least USABLE of the variation can be used, even if a rival predicts the held-out data as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

BETTER = 0.8
"""Error over the least error of a rival below which a model is better."""
EXPLAINED = 0.75
"""Least explained fraction of the variation, 1 - error/standard deviation."""
USABLE = 0.8
"""Least explained fraction of the variation of a model that can be used although a rival is as good: 96 % of the
variance."""
PREDICTS, RIVALLED, FAILS = "predicts", "is usable, but a rival predicts as well or better", "does not predict"
"""Verdicts on a prediction."""


@dataclass(frozen=True)
class Prediction:
    """Held-out error of a model with the errors of its baselines, in one unit."""

    rms: float
    """Root-mean-square error without parameters fitted to held-out data."""
    spread: float
    """Standard deviation of the measured values."""
    rivals: Mapping[str, float]
    """Baseline -> its root-mean-square error."""

    @property
    def fit_percent(self) -> float:
        """Return 100 % for a perfect prediction, and 0 % for an error as large as the variation."""
        return 100.0 * (1.0 - self.rms / self.spread) if self.spread > 0.0 else math.nan

    @property
    def best_rival(self) -> str:
        """Return the baseline with the least error; empty without baselines."""
        return min(self.rivals, key=self.rivals.__getitem__, default="")

    @property
    def beats_rivals(self) -> bool:
        """Return whether the error is clearly below the error of every baseline."""
        return all(self.rms < BETTER * error for error in self.rivals.values())

    @property
    def verdict(self) -> str:
        """Return `PREDICTS`, `RIVALLED` or `FAILS`."""
        if self.predicts:
            return PREDICTS
        return RIVALLED if self.fit_percent >= 100.0 * USABLE else FAILS

    @property
    def predicts(self) -> bool:
        """Return whether the model predicts this output."""
        return self.beats_rivals and self.fit_percent >= 100.0 * EXPLAINED
