"""Cross-validation: held-out errors of a model, compared with predictions without a model.

Every record is left out in turn and predicted from the others. If the others are insufficient, parts of the record are
left out instead. A model is predictive only if these errors beat the best naive prediction by a margin and explain most
of the variation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.fit.baselines import predict_naively
from martensite.fit.experiment_kinds.base import AbstractExperimentKind
from martensite.fit.fit import Fit, list_compared
from martensite.fit.logs import ALL, choose_held_out
from martensite.fit.problem import Problem
from martensite.fit.solve import solve_problem
from martensite.search.free_numbers import FreeNumber

BETTER = 0.8
"""Error over that of the best naive prediction from which on a model is better."""
EXPLAINED = 0.75
"""Share of what varies that must be explained: 1 - error/standard deviation."""
TAIL = 0.3
"""Part of a single driven record that is kept back, its end."""
FOLD_EVALUATIONS = 40
"""Evaluations of one local search where a record is left out."""


@dataclass(frozen=True)
class OutputError:
    """Errors in the held-out rows of one output, in SI."""

    output: str
    unit: str
    rms: float
    """Root-mean-square error of the prediction, with the fitted zero of the record if it has a separate zero."""
    raw_rms: float
    """With the mean zero of the records that were fitted, or none."""
    spread: float
    """Standard deviation of what was measured."""
    naive: Mapping[str, float]
    """Prediction without a model -> its error."""

    @property
    def fit_percent(self) -> float:
        """100 % for a perfect prediction, 0 % for one that errs by as much as is measured to vary."""
        return 100.0 * (1.0 - self.rms / self.spread) if self.spread > 0.0 else math.nan


@dataclass(frozen=True)
class HeldOutError(OutputError):
    """Held-out error of one record."""

    record: str
    own_zero: bool
    """True if the zero of the record was fitted to it."""
    whole: bool
    """True if the whole record was left out."""
    samples: int


@dataclass(frozen=True)
class PooledError(OutputError):
    """Over all records."""

    @property
    def best_naive(self) -> str:
        """Return the naive prediction with the least error."""
        return min(self.naive, key=self.naive.__getitem__)

    @property
    def beats_naive(self) -> bool:
        """Return whether the error is clearly below that of all naive predictions."""
        return self.rms < BETTER * self.naive[self.best_naive]

    @property
    def predicts(self) -> bool:
        """Return whether the model is said to predict this output."""
        return self.beats_naive and self.fit_percent >= 100.0 * EXPLAINED


def pool_errors(errors: Sequence[HeldOutError]) -> list[PooledError]:
    """Return the errors of every output over all records; naive predictions that all records have."""
    found: list[PooledError] = []
    for output in dict.fromkeys(one.output for one in errors):
        own = [one for one in errors if one.output == output]
        weights = np.array([one.samples for one in own], float)

        def pool(values: Sequence[float], weights: Any = weights) -> float:
            return math.sqrt(float(np.average(np.square(values), weights=weights)))

        shared = [name for name in own[0].naive if all(name in one.naive for one in own)]
        naive = {name: pool([one.naive[name] for one in own]) for name in shared}
        rms, raw, spread = (pool([getattr(one, n) for one in own]) for n in ("rms", "raw_rms", "spread"))
        found.append(PooledError(output, own[0].unit, rms, raw, spread, naive))
    return found


def cross_validate(
    whole: Fit, start: Sequence[FreeNumber], *, kind: AbstractExperimentKind, own_zero: bool
) -> list[HeldOutError]:
    """Return the held-out errors of a model that was fitted to all records.

    Args:
        whole: the fit to all records, near which the searches begin.
        start: the free numbers as proposed, where they begin as well.
        kind: kind of the experiment.
        own_zero: whether the zero of a left-out record is fitted to it.
    """
    problem = whole.problem
    found: list[HeldOutError] = []
    for fold in list_folds(problem, kind):
        fit = _solve_fold(fold, whole, start)
        found += list(_judge_fold(fit, fold, own_zero))
    return found


def list_folds(problem: Problem, kind: AbstractExperimentKind) -> Iterator[Problem]:
    """Yield the problem with every record left out in turn, or with stretches of all."""
    names = [one.name for one in problem.experiments]
    least = 3 if kind.axis else 2
    if len(names) >= least:
        for name in names:
            yield _leave_out(problem, {name: ALL})
        return
    if kind.own_zero:
        rows = [one.times.tolist() for one in problem.experiments]
        yield _leave_out(problem, dict(zip(names, choose_held_out("auto", names, rows), strict=True)))
        return
    one = problem.experiments[0]
    yield _leave_out(problem, {one.name: ((one.times[-1] - TAIL * (one.times[-1] - one.times[0]), math.inf),)})


def _leave_out(problem: Problem, held: Mapping[str, Any]) -> Problem:
    made = tuple(replace(one, held=held.get(one.name, ())) for one in problem.experiments)
    gone = {one.name for one in made if one.held_out}
    later = tuple(f for f in problem.free if f.record in gone)
    return replace(problem, experiments=made, free=tuple(f for f in problem.free if f.record not in gone), later=later)


def with_start(problem: Problem, numbers: Mapping[str, float]) -> Problem:
    """Return the problem with other starts, kept within their bounds."""

    def move(free: FreeNumber) -> FreeNumber:
        return replace(free, start=min(max(numbers.get(free.name, free.start), free.low), free.high))

    return replace(problem, free=tuple(map(move, problem.free)))


def _solve_fold(fold: Problem, whole: Fit, start: Sequence[FreeNumber]) -> Fit:
    begins = (whole.numbers, {free.name: free.start for free in start})
    fits = [solve_problem(with_start(fold, one), most=FOLD_EVALUATIONS, inputs=False) for one in begins]
    return min(fits, key=lambda fit: fit.cost)


def _judge_fold(fit: Fit, fold: Problem, own_zero: bool) -> Iterator[HeldOutError]:
    training = [one for one in fold.experiments if not one.held_out]
    for one in list_compared(fit):
        rows = one.held
        if not rows.any():
            continue
        measured, whole = one.measured[rows], one.experiment.held_out
        zeros = [x for name, x in fit.numbers.items() if name.startswith(f"offset.{one.output}@")]
        raw = one.model if one.raw is None else one.raw + (0.0 if own_zero or not zeros else float(np.mean(zeros)))
        own = own_zero and one.raw is not None
        naive = {
            name: _compute_rms(guess[rows] - measured, centred=own)
            for name, guess in predict_naively(training, one.experiment, one.output).items()
        }
        model = one.model if own else raw
        yield HeldOutError(
            one.output,
            one.description.unit,
            _compute_rms(model[rows] - measured),
            _compute_rms(raw[rows] - measured),
            float(np.std(measured)),
            naive,
            one.record,
            own,
            whole,
            int(rows.sum()),
        )


def _compute_rms(errors: Any, centred: bool = False) -> float:
    found = errors - np.mean(errors) if centred else errors
    return math.sqrt(float(np.mean(found**2)))
