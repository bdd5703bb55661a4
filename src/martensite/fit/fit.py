"""Result of a fit: parameters, their uncertainty, and the comparison by output."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from martensite.actuators.mechanisms.base import Output
from martensite.fit.column_noise import FollowedNoise
from martensite.fit.evaluation import Evaluation
from martensite.fit.experiment import Experiment
from martensite.fit.free_parameters import is_nuisance
from martensite.fit.losses import estimate_scale, find_loss
from martensite.fit.problem import Problem
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import FreeNumber
from martensite.search.identifiability import Identifiability, assess_identifiability
from martensite.search.model_score import Score, score_model
from martensite.search.quantity_text import format_change, format_quantity
from martensite.search.uncertainty import Uncertainty, estimate_uncertainty
from martensite.search.whiteness import LEAST_SAMPLES, Whiteness, assess_whiteness

TRAINING, HELD_OUT = "training", "held-out"
BOUND_DISTANCE = 1e-4
"""Fraction of a range within which a value counts as at its bound."""
COVERED = ("temperature", "stress")
"""Outputs whose range limits the validity of fitted values."""


@dataclass(frozen=True)
class ComparedOutput:
    """Output of a record compared with the fitted model, in SI."""

    experiment: Experiment
    output: str
    description: Output
    """Unit, name and symbol of the output."""
    times: Any
    """(rows,) [s]"""
    measured: Any
    """(rows,); NaN for missing samples."""
    model: Any
    """(rows,), with the offset of the record."""
    training_rows: Any
    """(rows,): True for fitted samples."""
    raw: Any = None
    """(rows,) of a held-out record, without parameters fitted to this record; None if there are no such parameters."""

    @property
    def record(self) -> str:
        """Return the name of the record."""
        return self.experiment.name

    @property
    def column(self) -> str:
        """Return the name of the compared column of the record."""
        return self.experiment.columns[self.output]

    @property
    def residuals(self) -> Any:
        """(rows,): model minus measurement; NaN for missing samples."""
        return self.model - self.measured

    @property
    def held_out_rows(self) -> Any:
        """(rows,): True for held-out samples."""
        return np.isfinite(self.measured) & ~self.training_rows

    @property
    def missing(self) -> int:
        """Return the rows without a measured value."""
        return int(np.sum(~np.isfinite(self.measured)))

    def score(self) -> Iterator[Score]:
        """Yield the errors of `training` rows, and of `held-out` rows if there are any."""
        for part, rows in ((TRAINING, self.training_rows), (HELD_OUT, self.held_out_rows)):
            if rows.any():
                score = score_model(
                    self.times[rows],
                    self.measured[rows],
                    self.model[rows],
                    record=self.record,
                    output=self.output,
                    part=part,
                    unit=self.description.unit,
                )
                yield replace(score, place=self.experiment.describe_row(score.maximum_at))

    @property
    def raw_rms(self) -> float:
        """Return the error without parameters fitted to this record alone; NaN without such parameters."""
        return math.nan if self.raw is None else float(np.sqrt(np.nanmean((self.raw - self.measured) ** 2)))

    def rms(self, part: str) -> float:
        """Return the root-mean-square error of `training` or `held-out` rows; NaN if there are none."""
        return compute_rms([self], part)


def list_compared(fit: Fit) -> list[ComparedOutput]:
    """Return all records and outputs of a fit, fitted records before held-out records."""
    return list(_iterate_compared(fit))


def compute_rms(rows: Iterable[ComparedOutput], part: str) -> float:
    """Return the root-mean-square error of all `training` or `held-out` rows; NaN without rows."""
    pieces = [one.residuals[one.training_rows if part == TRAINING else one.held_out_rows] for one in rows]
    errors = np.concatenate(pieces) if pieces else np.zeros(0)
    return math.sqrt(float(np.mean(errors**2))) if errors.size else math.nan


def _iterate_compared(fit: Fit) -> Iterator[ComparedOutput]:
    problem = fit.problem
    triples = zip(problem.experiments, fit.evaluation.fitted_records, problem.training_rows, strict=True)
    for one, fitted, used in triples:
        yield from _split_outputs(one, fitted.model, used)
    for held_out_record in fit.held_out_records:
        yield from list_held_out(held_out_record)


def list_held_out(held_out_record: HeldOutRecord) -> list[ComparedOutput]:
    """Return all outputs of a held-out record, with their predictions."""
    raw = held_out_record.raw if held_out_record.numbers else None
    return list(
        _split_outputs(
            held_out_record.experiment, held_out_record.model, np.zeros(held_out_record.model.shape, bool), raw
        )
    )


def _split_outputs(one: Experiment, model: Any, used: Any, raw: Any = None) -> Iterator[ComparedOutput]:
    outputs = one.describe_outputs()
    for k, name in enumerate(one.outputs):
        bare = None if raw is None else raw[:, k]
        yield ComparedOutput(one, name, outputs[name], one.times, one.measured[:, k], model[:, k], used[:, k], bare)


def find_covered_range(fit: Fit) -> dict[str, tuple[float, float]]:
    """Return the least and largest temperature [K] and stress [Pa] of the elements in the fitted runs."""
    ranges: dict[str, tuple[float, float]] = {}
    for k, one in enumerate(fit.problem.experiments):
        system = fit.system(k)
        for name in COVERED:
            outputs = [system.label(port, name) for port in system.actuators()]
            rows = one.sample_outputs(system, outputs, fit.problem.training_rows[k].any(axis=1), fit.problem.step)
            ends = [float(rows.min()), float(rows.max()), *ranges.get(name, ())]
            ranges[name] = min(ends), max(ends)
    return ranges


@dataclass(frozen=True)
class HeldOutRecord:
    """Held-out record with its prediction by the fit."""

    experiment: Experiment
    model: Any
    """(rows, outputs) in SI."""
    numbers: dict[str, float]
    """Separate parameters of the record, such as a sensor offset, fitted to it [SI]."""
    raw: Any = None
    """(rows, outputs) in SI, without the parameters that are fitted to the record."""


@dataclass(frozen=True)
class Fit:
    """Fitted parameters."""

    problem: Problem
    """Problem with the fitted records."""
    values: tuple[float, ...]
    """Values of the free parameters, as fractions of their ranges."""
    evaluation: Evaluation
    """Residuals and Jacobian at the optimum."""
    method: str
    loss: str
    reason: str
    """Stop reason: converged, stalled, cap, interrupted, …"""
    simulations: int
    """Number of runs of single experiments in the search."""
    jacobians: int
    """Number of runs with derivatives in all directions."""
    seconds: float
    history: tuple[tuple[int, float], ...]
    """(runs, cost) at each improvement."""
    held_out_records: tuple[HeldOutRecord, ...] = ()
    """Held-out records."""
    transfer: tuple[HeldOutRecord, ...] = ()
    """Predictions of each record by a fit to all other records."""
    scenario: Scenario | None = None
    """Scenario of the first log before the fit; for fits to logs only."""
    notes: tuple[str, ...] = ()
    """Remarks on the logs before the search."""
    cautions: tuple[str, ...] = ()
    """Effects of halved steps at the optimum, if noticeable."""
    input_noise: tuple[FollowedNoise, ...] = ()
    """Noise of drive columns, if it affects parameters and intervals."""

    @property
    def numbers(self) -> dict[str, float]:
        """Return the free parameters in SI."""
        return self.problem.numbers(self.values)

    def __getitem__(self, name: str) -> float:
        """Return a fitted parameter in SI."""
        return self.numbers[name]

    @property
    def cost(self) -> float:
        """Return the mean of the squared residuals, in units of noise or range."""
        return self.evaluation.cost

    def system(self, record: int = 0) -> Any:
        """Return the system of an experiment with the fitted parameters."""
        return self.problem.system(record, self.values)

    def at_bound(self) -> list[str]:
        """Return the parameters at a bound of their search."""
        pairs = zip(self.problem.names, self.values, strict=True)
        return [name for name, u in pairs if not BOUND_DISTANCE < u < 1.0 - BOUND_DISTANCE]

    @cached_property
    def undetermined(self) -> dict[str, str]:
        """Return the undetermined parameters with the reason."""
        reasons = {
            free.name: self._refuse_number(free, u) for free, u in zip(self.problem.free, self.values, strict=True)
        }
        return {name: why for name, why in reasons.items() if why}

    def _refuse_number(self, free: FreeNumber, u: float) -> str:
        low, high = self.uncertainty.widen_interval(free.name)
        if not math.isfinite(high - low):
            return "the data give it no interval"
        if free.name in self.at_bound():
            end = free.low if u < 0.5 else free.high
            return f"it lies on its bound, {format_quantity(end, free.unit)}"
        wide = format_change(0.5 * (high - low), free.unit, 3)
        if high - low > free.high - free.low:
            return f"its 95 % interval, ± {wide}, is wider than the range in which it was searched"
        least, most = self._find_bounds(free)
        finite = math.isfinite(most - least) and high - low < 0.5 * (most - least)
        if (low < least or high > most) and not finite:
            return f"its 95 % interval, ± {wide}, reaches values that it cannot have"
        return ""

    def _find_bounds(self, free: FreeNumber) -> tuple[float, float]:
        """Return the declared bounds of a parameter; separate parameters of records are unbounded."""
        leaves = () if is_nuisance(free.path) or free.base else self.system().leaves()
        return next((leaf.declared.bounds for leaf in leaves if free.moves(leaf.path)), (-math.inf, math.inf))

    @cached_property
    def scores(self) -> tuple[Score, ...]:
        """Return the errors per record and output, with separate errors of held-out rows."""
        return tuple(score for one in list_compared(self) for score in one.score())

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """Return the errors and correlations of the parameters, from the Jacobian at the optimum."""
        weights = self.weights
        return estimate_uncertainty(
            weights * self.evaluation.residuals,
            weights[:, None] * self.evaluation.jacobian,
            self.problem.names,
            values=list(self.numbers.values()),
            scales=self._scales,
            lengths=self.problem.lengths,
            uneven=bool(self.input_noise),
        )

    @property
    def weights(self) -> Any:
        """(n,): square roots of the weights of the squared residuals by the loss."""
        residuals = self.evaluation.residuals
        if self.loss == "linear":
            return np.ones_like(residuals)
        return np.sqrt(find_loss(self.loss).weights(residuals, estimate_scale(residuals)))

    @cached_property
    def identifiability(self) -> Identifiability:
        """Return the combinations of parameters that the data do not determine."""
        noise = self.uncertainty.noise
        assessment = assess_identifiability(
            self.evaluation.jacobian,
            self.problem.names,
            values=list(self.numbers.values()),
            scales=self._scales,
            units=[free.unit for free in self.problem.free],
            noise=noise if noise > 0.0 else 1.0,
        )
        return replace(assessment, refused=tuple(self.undetermined))

    @cached_property
    def whiteness(self) -> tuple[Whiteness, ...]:
        """Return the whiteness test of the residuals of every record and output."""
        rows = [one for one in list_compared(self) if one.training_rows.any()]
        parts = [one.residuals[one.training_rows] for one in rows]
        if self.input_noise:  # uneven scatter before whitening
            parts = np.split(self.evaluation.residuals, np.cumsum(self.problem.lengths)[:-1])
        return tuple(
            assess_whiteness(part, f"{one.record}, {one.output}")
            for one, part in zip(rows, parts, strict=True)
            if len(part) >= LEAST_SAMPLES
        )

    @property
    def _scales(self) -> list[float]:
        pairs = zip(self.problem.free, self.values, strict=True)
        return [free.slope(u) for free, u in pairs]
