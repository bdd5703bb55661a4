"""Cross-validation: held-out errors of a model, compared with baselines.

Every record is predicted from the others in turn. If the others are insufficient, parts of the record are left out
instead. `martensite.search.rivals` has the criterion of prediction.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.fit.baselines import predict_naively
from martensite.fit.descents import INTERRUPTED, OUT_OF_TIME
from martensite.fit.experiment import Experiment
from martensite.fit.experiment_kinds.base import AbstractExperimentKind
from martensite.fit.fit import ComparedOutput, Fit, list_compared
from martensite.fit.logs import ALL, AUTO, EACH, NONE, PARTS, choose_held_out
from martensite.fit.path_places import measure_places
from martensite.fit.problem import Problem
from martensite.fit.solve import solve_problem
from martensite.search.free_numbers import FreeNumber
from martensite.search.rivals import Prediction
from martensite.search.time_box import TimeBox

TAIL = 0.3
"""Fraction at the end of a single driven record that is held out."""
FOLD_EVALUATIONS = 40
"""Evaluations of one local search with a held-out record."""


@dataclass(frozen=True)
class OutputError(Prediction):
    """Errors in the held-out rows of one output, in SI."""

    output: str
    unit: str
    offset_rms: float
    """Error with an offset fitted to each held-out record; NaN without a fitted offset."""


@dataclass(frozen=True)
class HeldOutError(OutputError):
    """Held-out error of one record."""

    record: str
    whole: bool
    """True if the whole record was left out."""
    samples: int


@dataclass(frozen=True)
class PooledError(OutputError):
    """Held-out error over all records."""


def pool_errors(errors: Sequence[HeldOutError]) -> list[PooledError]:
    """Return the errors of every output over all records, with the common baselines."""
    pooled_errors: list[PooledError] = []
    for output in dict.fromkeys(one.output for one in errors):
        own = [one for one in errors if one.output == output]
        weights = np.array([one.samples for one in own], float)

        def pool(values: Sequence[float], weights: Any = weights) -> float:
            return math.sqrt(float(np.average(np.square(values), weights=weights)))

        shared = [name for name in own[0].rivals if all(name in one.rivals for one in own)]
        rivals = {name: pool([one.rivals[name] for one in own]) for name in shared}
        rms, spread, offset = (pool([getattr(one, n) for one in own]) for n in ("rms", "spread", "offset_rms"))
        pooled_errors.append(PooledError(rms, spread, rivals, output, own[0].unit, offset))
    return pooled_errors


def cross_validate(
    whole: Fit, start: Sequence[FreeNumber], *, kind: AbstractExperimentKind, box: TimeBox, hold_out: str = AUTO
) -> list[HeldOutError]:
    """Return the held-out errors of a model fitted to all records, as far as the time limit permits.

    Args:
        whole: fit to all records, near which the searches begin.
        start: proposed values of the free parameters, as a further start.
        kind: kind of the experiment.
        box: time limit.
        hold_out: held-out data, as in `choose_held_out`.

    Raises:
        KeyboardInterrupt: the tests were interrupted.
        InputError: `hold_out` is invalid.
    """
    errors: list[HeldOutError] = []
    folds = list(list_folds(whole.problem, kind, hold_out))
    for k, fold in enumerate(folds):
        watch = box.limit(box.share + (1.0 - box.share) / (len(folds) - k))
        begins = [whole.numbers]
        begins += [] if kind.axis else [{free.name: free.start for free in start}]  # loops have one optimum nearby
        fits = list[Fit]()
        for one in begins:
            fits.append(solve_problem(with_start(fold, one), most=FOLD_EVALUATIONS, inputs=False, tell=watch))
            if fits[-1].reason == INTERRUPTED:
                raise KeyboardInterrupt
        if any(fit.reason == OUT_OF_TIME for fit in fits):  # no true prediction: the start was fitted to held-out data
            continue
        errors += _judge_fold(min(fits, key=lambda fit: fit.cost), fold, kind.given_start)
    return errors


def list_folds(problem: Problem, kind: AbstractExperimentKind, hold_out: str = AUTO) -> Iterator[Problem]:
    """Yield the problem with every record left out in turn, with parts of all, or with the requested data."""
    names, one = [one.name for one in problem.experiments], problem.experiments[0]
    if hold_out == NONE:
        return
    if hold_out == EACH or (hold_out == AUTO and len(names) >= (3 if kind.axis else 2)):
        for name in names:
            yield _leave_out(problem, {name: ALL})
    elif hold_out == AUTO and not kind.own_zero and _shows_both_ways(one):
        yield _leave_out(problem, {one.name: ((one.times[-1] - TAIL * (one.times[-1] - one.times[0]), math.inf),)})
    else:
        rows = [one.times.tolist() for one in problem.experiments]
        places = [measure_places(one) for one in problem.experiments]
        rule = PARTS if hold_out == AUTO else hold_out
        yield _leave_out(problem, dict(zip(names, choose_held_out(rule, names, rows, places), strict=True)))


def _shows_both_ways(one: Experiment) -> bool:
    """Return whether the first output rises and falls by half its range before the tail: both transformations."""
    samples = one.measured[:, 0]
    finite_rows = np.isfinite(samples)
    before = samples[finite_rows & (one.times < one.times[-1] - TAIL * (one.times[-1] - one.times[0]))]
    if not before.size:
        return False
    half = 0.5 * float(np.ptp(samples[finite_rows]))
    rise = float(np.max(before - np.minimum.accumulate(before)))
    fall = float(np.max(np.maximum.accumulate(before) - before))
    return min(rise, fall) >= half


def _leave_out(problem: Problem, held_out_stretches: Mapping[str, Any]) -> Problem:
    experiments = tuple(
        replace(one, held_out_intervals=held_out_stretches.get(one.name, ())) for one in problem.experiments
    )
    held_out_names = {one.name for one in experiments if one.is_held_out}
    later = tuple(f for f in problem.free if f.record in held_out_names)
    return replace(
        problem,
        experiments=experiments,
        free=tuple(f for f in problem.free if f.record not in held_out_names),
        later=later,
    )


def with_start(problem: Problem, numbers: Mapping[str, float]) -> Problem:
    """Return the problem with other starts, kept within their bounds."""

    def move(free: FreeNumber) -> FreeNumber:
        return replace(free, start=min(max(numbers.get(free.name, free.start), free.low), free.high))

    return replace(problem, free=tuple(map(move, problem.free)))


def _judge_fold(fit: Fit, fold: Problem, given_start: bool) -> Iterator[HeldOutError]:
    """Yield the errors of a fold; if the start of a record is given, parameters fitted to it are part of the input."""
    rows = list_compared(fit)
    training = [one for one in fold.experiments if not one.is_held_out]
    for one in rows:
        held_out_rows = one.held_out_rows
        if not held_out_rows.any():
            continue
        fitted = [x for x in rows if x.training_rows.any() and x.output == one.output]
        plain = one.model if one.raw is None or given_start else one.raw + _predict_zero(fit, fitted, one)
        measured = one.measured[held_out_rows]
        rivals = {
            name: _compute_rms(guess[held_out_rows] - measured, centred=given_start)
            for name, guess in predict_naively(training, one.experiment, one.output).items()
        }
        yield HeldOutError(
            _compute_rms(plain[held_out_rows] - measured),
            float(np.std(measured)),
            rivals,
            one.output,
            one.description.unit,
            math.nan if one.raw is None or given_start else _compute_rms(one.model[held_out_rows] - measured),
            one.record,
            one.experiment.is_held_out,
            int(held_out_rows.sum()),
        )


def _predict_zero(fit: Fit, fitted: Sequence[ComparedOutput], one: ComparedOutput) -> float:
    """Return the predicted offset of a held-out record.

    It is the mean offset of the fitted records. If their smallest values agree better than their offsets, the offset
    gives the record the same smallest value.
    """
    zeros = [x for name, x in fit.numbers.items() if name.startswith(f"offset.{one.output}@")]
    lows = [float(np.min(x.model)) for x in fitted]
    if not zeros:
        return 0.0
    if len(lows) > 1 and np.std(lows) < np.std(zeros):
        return float(np.mean(lows)) - float(np.min(one.raw))
    return float(np.mean(zeros))


def _compute_rms(errors: Any, centred: bool = False) -> float:
    deviations = errors - np.mean(errors) if centred else errors
    return math.sqrt(float(np.mean(deviations**2)))
