"""The result of a fit: numbers, and everything that says how far to trust them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from martensite.fit.compared_outputs import list_compared
from martensite.fit.experiment import Experiment
from martensite.fit.losses import estimate_scale, find_loss
from martensite.fit.problem import Evaluation, Problem
from martensite.scenario.scenario import Scenario
from martensite.search.identifiability import Identifiability, assess_identifiability
from martensite.search.model_score import Score
from martensite.search.uncertainty import Uncertainty, estimate_uncertainty
from martensite.search.whiteness import FEWEST, Whiteness, assess_whiteness


@dataclass(frozen=True)
class HeldOutRecord:
    """A record that was kept back, and what the fit predicts for it."""

    experiment: Experiment
    model: Any
    """(rows, outputs) in SI."""
    numbers: dict[str, float]
    """What the record has for itself [SI], such as the zero of its sensor; fitted to it."""


@dataclass(frozen=True)
class Fit:
    """Fitted parameters."""

    problem: Problem
    """With the records that the search saw."""
    values: tuple[float, ...]
    """Of the free parameters, as shares of their ranges."""
    evaluation: Evaluation
    """Residuals and Jacobian there."""
    method: str
    loss: str
    reason: str
    """Why the search ended: converged, stalled, cap, interrupted, …"""
    simulations: int
    """Runs of single experiments that the search took."""
    jacobians: int
    """Runs of single experiments with derivatives in all directions."""
    seconds: float
    history: tuple[tuple[int, float], ...]
    """(runs, cost) at each improvement."""
    kept: tuple[HeldOutRecord, ...] = ()
    """Records that the search did not see."""
    scenario: Scenario | None = None
    """That of the first log, as it was before the fit, of a fit to logs."""
    notes: tuple[str, ...] = ()
    """What was noticed in the logs before the search."""
    cautions: tuple[str, ...] = ()
    """What halving the steps changes at its end, if that is noticeable."""

    @property
    def numbers(self) -> dict[str, float]:
        """The free parameters in SI."""
        return self.problem.numbers(self.values)

    def __getitem__(self, name: str) -> float:
        """A fitted number in SI."""
        return self.numbers[name]

    @property
    def cost(self) -> float:
        """Mean of the squared residuals, as shares of noise or range."""
        return self.evaluation.cost

    def system(self, record: int = 0) -> Any:
        """The system of an experiment with the fitted numbers."""
        return self.problem.system(record, self.values)

    def at_bound(self) -> list[str]:
        """Parameters that ended on a bound of their search."""
        pairs = zip(self.problem.names, self.values, strict=True)
        return [name for name, u in pairs if not 1e-6 < u < 1.0 - 1e-6]

    @cached_property
    def scores(self) -> tuple[Score, ...]:
        """Errors per record and output, those of held-out rows apart."""
        return tuple(score for one in list_compared(self) for score in one.score())

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """Errors and correlations of the parameters, from the Jacobian at the optimum."""
        weights = self.weights
        return estimate_uncertainty(
            weights * self.evaluation.residuals,
            weights[:, None] * self.evaluation.jacobian,
            self.problem.names,
            values=list(self.numbers.values()),
            scales=self._scales,
            lengths=self.problem.lengths,
        )

    @property
    def weights(self) -> Any:
        """(n,): roots of the weights that the loss gives to the squared residuals."""
        residuals = self.evaluation.residuals
        if self.loss == "linear":
            return np.ones_like(residuals)
        return np.sqrt(find_loss(self.loss).weights(residuals, estimate_scale(residuals)))

    @cached_property
    def identifiability(self) -> Identifiability:
        """Which combinations of the parameters the data leave open."""
        noise = self.uncertainty.noise
        return assess_identifiability(
            self.evaluation.jacobian,
            self.problem.names,
            values=list(self.numbers.values()),
            scales=self._scales,
            units=[free.unit for free in self.problem.free],
            noise=noise if noise > 0.0 else 1.0,
        )

    @cached_property
    def whiteness(self) -> tuple[Whiteness, ...]:
        """Whether the residuals of every record and output look like noise."""
        return tuple(
            assess_whiteness(one.residuals[one.used], f"{one.record}, {one.output}")
            for one in list_compared(self)
            if one.used.sum() >= FEWEST
        )

    @property
    def _scales(self) -> list[float]:
        pairs = zip(self.problem.free, self.values, strict=True)
        return [free.slope(u) for free, u in pairs]
