"""Search methods for the parameters of least cost.

    trf          trust-region least squares within bounds (Branch, Coleman and Li; SciPy), with
                 exact Jacobians: a Levenberg–Marquardt method that respects bounds
    coordinate   coordinate search of the least cost, for comparison
    evolution    differential evolution (SciPy) in batches, then trf from its best point

Starts and trf keep the order constraints of laws (`ordered_numbers`). A start without transformation is replaced.
With `starts`, trf begins from the scenario and from the best points of a Sobol' sequence, evaluated in batches.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import InputError, SolveError, require_known
from martensite.base.interrupts import accept_interrupt
from martensite.fit.column_noise import FollowedNoise
from martensite.fit.descents import (
    CONVERGED,
    INTERRUPTED,
    MOST_EVALUATIONS,
    OUT_OF_TIME,
    RESUMED,
    ROUNDING,
    run_descents,
    verify_optimum,
)
from martensite.fit.evaluation import Evaluation
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit, HeldOutRecord
from martensite.fit.input_noise import Descend, correct_for_inputs
from martensite.fit.losses import Loss, estimate_scale, find_loss
from martensite.fit.problem import Problem
from martensite.fit.search_monitor import SearchMonitor, Tell
from martensite.fit.start_checks import detect_transformation, find_idle
from martensite.search.coordinate_search import search_coordinates
from martensite.search.least_squares import descend_squares
from martensite.search.quantity_text import format_quantity, join_phrases
from martensite.search.starts import evolve_start, find_starts
from martensite.search.time_box import OutOfTimeError

METHODS = ("trf", "coordinate", "evolution")
SPREAD = 32
"""Number of Sobol' points per start."""
OTHERS = 4
"""Number of other starts if nothing transforms at the first."""
REFINING = 20
"""Evaluations of a search in one round of the correction for drive noise."""
SPECIMEN = "specimen"
"""Kind of group whose records are held out together."""
FIRST_NOISE = 0.02
"""First guess of unknown noise for the weight of spreads, as a fraction of the range."""
ROUNDS, BALANCED = 6, 0.05
"""Largest number of fits to find this noise, and the relative change that ends them."""


def solve_problem(
    problem: Problem,
    *,
    method: str = "trf",
    loss: str = "linear",
    starts: int = 0,
    seed: int = 0,
    most: int = MOST_EVALUATIONS,
    tell: Tell | None = None,
    state: Path | None = None,
    inputs: bool = True,
) -> Fit:
    """Fit the free parameters of a problem.

    An interruption (KeyboardInterrupt) ends the search and returns the best point.

    Args:
        problem: experiments and free parameters.
        method: trf, coordinate, or evolution.
        loss: linear, soft-l1, huber, or cauchy.
        starts: number of further local searches, from the best of many points within the bounds.
        seed: seed of these points.
        most: largest number of evaluations of one local search.
        tell: callback after every evaluation.
        state: file that stores the search, so that it can be resumed.
        inputs: True to include noise of drive columns (`input_noise`).

    Raises:
        InputError: an unknown method or loss, or a state of another problem.
        SolveError: the runs fail at the start and at all points tried.
    """
    require_known("method", method, METHODS)
    if problem.training.spreads and problem.prior_scale == 1.0 and not problem.knows_noise:
        how = {"method": method, "loss": loss, "starts": starts, "seed": seed, "most": most, "tell": tell}
        problem = _balance_spreads(problem, lambda one: solve_problem(one, **how, inputs=False))
    if starts < 0:
        raise InputError(f"Argument `starts` must be at least 0, but is {starts}.")
    training = problem.training
    chosen, watch = find_loss(loss), SearchMonitor(training, tell, state)
    start_time = time.monotonic()
    reason = CONVERGED
    try:
        watch.resume()
        reason = _run_search(watch, method, chosen, starts, seed, most)
        reason = _judge_end(watch, chosen, reason, most)
    except KeyboardInterrupt as end:
        if watch.best is None:
            raise
        accept_interrupt()
        reason = OUT_OF_TIME if isinstance(end, OutOfTimeError) else INTERRUPTED
    watch.save()
    if watch.best is None:
        raise SolveError(
            "The runs fail at the start of the fit and wherever else it was tried; run the "
            "scenario alone to see why, or start from other values."
        )
    plain = training.evaluate(watch.best, slopes=True)
    if plain is None:
        raise SolveError("The run at the best point fails when it is repeated.")
    end = _CorrectedEnd(training, np.array(watch.best), plain)
    if inputs and reason not in (INTERRUPTED, OUT_OF_TIME):
        end = _correct_end(end, chosen)
    return Fit(
        end.problem,
        tuple(map(float, end.point)),
        end.evaluation,
        method,
        loss,
        reason,
        watch.simulations,
        watch.jacobians,
        time.monotonic() - start_time,
        tuple(watch.history),
        tuple(_predict_held_out(problem, one, end.point) for one in problem.experiments if one.is_held_out),
        input_noise=end.noise,
        notes=end.notes,
    )


class _CorrectedEnd(NamedTuple):
    """End of a search, corrected for drive noise if necessary."""

    problem: Problem
    point: Any
    evaluation: Evaluation
    noise: tuple[FollowedNoise, ...] = ()
    notes: tuple[str, ...] = ()


def _correct_end(end: _CorrectedEnd, loss: Loss) -> _CorrectedEnd:
    """Return the corrected end of a search; unchanged if the search fails or is interrupted."""
    try:
        problem, point, noise, notes = correct_for_inputs(*end[:2], _make_descent(loss, end.evaluation))
    except (KeyboardInterrupt, SolveError):
        accept_interrupt()
        note = "The noise of columns that drive was not taken into account: that search did not end."
        return end._replace(notes=(note,))
    evaluation = end.evaluation
    if noise:
        again, corrected_evaluation = (one.evaluate(point.tolist(), slopes=True) for one in (end.problem, problem))
        if again is not None and corrected_evaluation is not None:
            evaluation = Evaluation(again.fitted_records, corrected_evaluation.residuals, corrected_evaluation.jacobian)
    return _CorrectedEnd(problem, point, evaluation, tuple(noise), tuple(notes))


def _balance_spreads(problem: Problem, solve: Callable[[Problem], Fit]) -> Problem:
    """Return the problem with spreads weighed against the residual noise of a fit, s² = Σ r²/(n - tr H).

    n is the number of measurements, and tr H is the sum of their leverages.
    """
    scale = FIRST_NOISE
    for _ in range(ROUNDS):
        fit = solve(replace(problem, prior_scale=scale))
        count = len(fit.evaluation.residuals) - len(fit.problem.spreads)
        residuals, jacobian = fit.weights * fit.evaluation.residuals, fit.weights[:, None] * fit.evaluation.jacobian
        levers = np.sum((jacobian @ np.linalg.pinv(jacobian)).diagonal()[:count])
        before = scale
        scale = max(math.sqrt(float(residuals[:count] @ residuals[:count]) / max(count - levers, 1.0)), ROUNDING)
        if fit.reason in (INTERRUPTED, OUT_OF_TIME) or abs(scale - before) <= BALANCED * before:
            break
    return replace(problem, prior_scale=scale)


def predict_each(problem: Problem, how: Mapping[str, Any], tell: Tell | None = None) -> tuple[HeldOutRecord, ...]:
    """Predict each specimen (or record, without specimens) from a fit to all others.

    Args:
        problem: all records, without held-out records.
        how: method, loss and so on, as in `solve_problem`.
        tell: callback after every evaluation.

    Raises:
        SolveError: the runs of a fit fail.
    """
    wholes = [one.groups.get(SPECIMEN, one.name) for one in problem.experiments]
    held_out_records = list[HeldOutRecord]()
    for whole in dict.fromkeys(wholes):
        names = [one.name for one, of in zip(problem.experiments, wholes, strict=True) if of == whole]
        fit = solve_problem(problem.hold_out(names), **how, tell=tell, inputs=False)
        if fit.reason in (INTERRUPTED, OUT_OF_TIME):
            break
        held_out_records += fit.held_out_records
    return tuple(held_out_records)


def _make_descent(loss: Loss, evaluation: Evaluation) -> Descend:
    """Return a local search of a problem from a point, with the loss of a fit."""
    scale = 1.0
    if loss.name != "linear":
        scale = loss.tuning * max(estimate_scale(evaluation.residuals), 1e-12)

    def descend(problem: Problem, begin: Any, first: Evaluation) -> Any:
        def evaluate(u: Any, slopes: bool) -> Evaluation | None:
            return problem.evaluate(u, slopes=slopes)

        return descend_squares(evaluate, begin, first, most=REFINING, loss=loss.scipy_name, scale=scale).shares

    return descend


def _predict_held_out(problem: Problem, one: Experiment, end: Any) -> HeldOutRecord:
    labels = (None, *one.groups.values())  # a group may have other records, that were fitted
    free = tuple(f for f in problem.free if f.record in labels)
    whole = replace(problem, experiments=(replace(one, held_out_intervals=()),), free=free, later=())
    at = [u for f, u in zip(problem.free, end, strict=True) if f.record in labels]
    own = tuple(f for f in problem.later if f.record in one.labels)
    evaluation = whole.evaluate(at)
    if evaluation is None:
        raise SolveError(f"The run of record `{one.name}`, which was held out, fails.")
    raw = evaluation.fitted_records[0].model
    if own:  # fitted to it, everything else as found
        alone = replace(one, held_out_intervals=(), system=whole.system(0, at))
        fit = solve_problem(replace(problem, experiments=(alone,), free=own, later=()), inputs=False)
        return HeldOutRecord(one, fit.evaluation.fitted_records[0].model, fit.numbers, raw)
    return HeldOutRecord(one, raw, {}, raw)


def _run_search(watch: SearchMonitor, method: str, loss: Loss, starts: int, seed: int, most: int) -> str:
    if method == "coordinate":
        return _search_coordinates(watch)
    problem = watch.problem
    begins = [("scenario", problem.start)]
    if method == "evolution" and "evolution" not in watch.done:
        watch.stage = "differential evolution"
        best = evolve_start(_count_costs(watch), len(problem.free), seed=seed).values
        begins = [("best of evolution", problem.order.find_shares(best))]
        watch.finish_stage("evolution")
    if watch.best is not None:
        begins = [(RESUMED, np.array(watch.best))]
    if starts:
        watch.stage = f"{SPREAD * starts} points"
        if watch.best is None:  # something to show, should the points be interrupted
            watch.evaluate(problem.start.tolist())
        begins += _name_starts(_find_points(watch, starts, SPREAD * starts, seed))
    elif watch.best is None and _find_unmoved(problem, problem.start) != []:
        begins = _find_moving_starts(watch, seed) or begins
    return run_descents(watch, begins, loss, most)


def _search_coordinates(watch: SearchMonitor) -> str:
    watch.stage = "coordinate search"
    begin = watch.problem.start if watch.best is None else np.array(watch.best)

    def cost(u: Sequence[float]) -> float:
        evaluation = watch.evaluate(u)
        return math.inf if evaluation is None else evaluation.cost

    return search_coordinates(cost, begin.tolist())[1]


def _count_costs(watch: SearchMonitor) -> Callable[[Any], Any]:
    """Return the costs of points, mapped to ordered parameters."""
    return lambda points: watch.costs(np.array([watch.problem.order.find_shares(v) for v in points]))


def _find_points(watch: SearchMonitor, keep: int, count: int, seed: int) -> list[Any]:
    """Return the best points of a Sobol' sequence."""
    starts = find_starts(_count_costs(watch), len(watch.problem.free), count=count, keep=keep, seed=seed)
    return [watch.problem.order.find_shares(one.values) for one in starts]


def _find_moving_starts(watch: SearchMonitor, seed: int) -> list[tuple[str, Any]]:
    """Return starts with a transformation; empty if all runs fail."""
    watch.stage = "other starts: at the first runs fail, or nothing transforms"
    watch.evaluate(watch.problem.start.tolist())  # which is kept where no point is better
    try:
        points = _find_points(watch, OTHERS, SPREAD, seed)
    except SolveError:
        return []
    return _name_starts([u for u in points if not _find_unmoved(watch.problem, u)])


def _name_starts(points: Sequence[Any]) -> list[tuple[str, Any]]:
    return [(f"start {k}", u) for k, u in enumerate(points, start=1)]


def _judge_end(watch: SearchMonitor, loss: Loss, reason: str, most: int) -> str:
    """Return the stop reason, after tests of the end for idle parameters and stationarity."""
    if watch.best is not None and (idle := _find_unmoved(watch.problem, watch.best)):
        return _describe_rest(watch.problem, watch.best, idle)
    return verify_optimum(watch, loss, most) if reason == CONVERGED else reason


def _find_unmoved(problem: Problem, u: Any) -> list[int] | None:
    """Return the indices of idle parameters if all are idle or nothing transforms; None if a run fails."""
    evaluation = problem.evaluate(u, slopes=True)
    if evaluation is None:
        return None
    idle = find_idle(problem, evaluation)
    if not idle or len(idle) == len(problem.free):
        return idle
    return [] if detect_transformation(problem, u) else idle


def _describe_rest(problem: Problem, u: Any, idle: Sequence[int]) -> str:
    """Describe the end of a search with idle parameters at the indices `idle`."""
    numbers = [format_quantity(problem.free[i].value(float(u[i])), problem.free[i].unit) for i in idle]
    where = join_phrases([f"{problem.names[i]} = {number}" for i, number in zip(idle, numbers, strict=True)])
    what = "nothing that is compared changes" if detect_transformation(problem, u) else "nothing transforms"
    return f"{what} at {where}; the fit did not move"
