"""Searches: from a problem to the parameters of least cost.

    trf          trust-region least squares within bounds (Branch, Coleman and Li; SciPy), with
                 exact Jacobians: a Levenberg–Marquardt method that respects bounds
    coordinate   coordinate search of the least cost, for comparison
    evolution    differential evolution (SciPy) in batches, then trf from its best point

Starts and trf keep numbers in the order that a law declares (`ordered_numbers`); a start at which nothing transforms
is left for others.

With `starts`, trf begins from the scenario and from the best of a Sobol' sequence of points over
the bounds, all evaluated in batches.
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
"""Sobol' points tried for each start."""
OTHERS = 4
"""Starts tried where nothing transforms at the first."""
REFINING = 20
"""Evaluations of a search in one round of the correction for noise in what drives."""
SPECIMEN = "specimen"
"""The kind of group whose records are kept back together."""
FIRST_NOISE = 0.02
"""Noise as a share of the range with which spreads are first weighed, where it is not known."""
ROUNDS, BALANCED = 6, 0.05
"""Fits in which it is found, and the relative change that ends them."""


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
    """Find the free parameters of a problem.

    An interruption (KeyboardInterrupt) ends the search and keeps the best point so far.

    Args:
        problem: what to fit to what.
        method: trf, coordinate, or evolution.
        loss: linear, soft-l1, huber, or cauchy.
        starts: further local searches, from the best of many points within the bounds.
        seed: of those points.
        most: evaluations of one local search.
        tell: called after every evaluation.
        state: a file in which the search is kept, and taken up again.
        inputs: whether noise in columns that drive counts (`input_noise`).

    Raises:
        InputError: an unknown method or loss, or a state of another problem.
        SolveError: the runs fail at the start, and at every point tried.
    """
    require_known("method", method, METHODS)
    if problem.training.spreads and problem.prior_scale == 1.0 and not problem.knows_noise:
        how = {"method": method, "loss": loss, "starts": starts, "seed": seed, "most": most, "tell": tell}
        problem = _balance_spreads(problem, lambda one: solve_problem(one, **how, inputs=False))
    if starts < 0:
        raise InputError(f"Argument `starts` must be at least 0, but is {starts}.")
    training = problem.training
    chosen, watch = find_loss(loss), SearchMonitor(training, tell, state)
    begun = time.monotonic()
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
        time.monotonic() - begun,
        tuple(watch.history),
        tuple(_predict_held_out(problem, one, end.point) for one in problem.experiments if one.held_out),
        input_noise=end.noise,
        notes=end.notes,
    )


class _CorrectedEnd(NamedTuple):
    """End of a search, corrected for noise in the drives where that counts."""

    problem: Problem
    point: Any
    evaluation: Evaluation
    noise: tuple[FollowedNoise, ...] = ()
    notes: tuple[str, ...] = ()


def _correct_end(end: _CorrectedEnd, loss: Loss) -> _CorrectedEnd:
    """Return the end of a search with the noise of the drives; unchanged if that search fails or is interrupted."""
    try:
        problem, point, noise, notes = correct_for_inputs(*end[:2], _make_descent(loss, end.evaluation))
    except (KeyboardInterrupt, SolveError):
        accept_interrupt()
        note = "The noise of columns that drive was not taken into account: that search did not end."
        return end._replace(notes=(note,))
    evaluation = end.evaluation
    if noise:
        again, found = (one.evaluate(point.tolist(), slopes=True) for one in (end.problem, problem))
        if again is not None and found is not None:
            evaluation = Evaluation(again.fitted, found.residuals, found.jacobian)
    return _CorrectedEnd(problem, point, evaluation, tuple(noise), tuple(notes))


def _balance_spreads(problem: Problem, solve: Callable[[Problem], Fit]) -> Problem:
    """Return the problem with spreads weighed against the noise that a fit with them leaves, s² = Σ r²/(n - tr H).

    n are measurements, and tr H is the sum of their leverages: what of the free numbers they hold.
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
        problem: all records, none of them kept back.
        how: method, loss and so on, as for `solve_problem`.
        tell: called after every evaluation.

    Raises:
        SolveError: the runs of one of the fits fail.
    """
    wholes = [one.groups.get(SPECIMEN, one.name) for one in problem.experiments]
    found = list[HeldOutRecord]()
    for whole in dict.fromkeys(wholes):
        names = [one.name for one, of in zip(problem.experiments, wholes, strict=True) if of == whole]
        fit = solve_problem(problem.hold_out(names), **how, tell=tell, inputs=False)
        if fit.reason in (INTERRUPTED, OUT_OF_TIME):
            break
        found += fit.kept
    return tuple(found)


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
    whole = replace(problem, experiments=(replace(one, held=()),), free=free, later=())
    at = [u for f, u in zip(problem.free, end, strict=True) if f.record in labels]
    own = tuple(f for f in problem.later if f.record in one.labels)
    found = whole.evaluate(at)
    if found is None:
        raise SolveError(f"The run of record `{one.name}`, which was held out, fails.")
    raw = found.fitted[0].model
    if own:  # fitted to it, everything else as found
        alone = replace(one, held=(), system=whole.system(0, at))
        fit = solve_problem(replace(problem, experiments=(alone,), free=own, later=()), inputs=False)
        return HeldOutRecord(one, fit.evaluation.fitted[0].model, fit.numbers, raw)
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
        watch.finished("evolution")
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
        found = watch.evaluate(u)
        return math.inf if found is None else found.cost

    return search_coordinates(cost, begin.tolist())[1]


def _count_costs(watch: SearchMonitor) -> Callable[[Any], Any]:
    """Return the costs of points whose parameters keep the order of laws by construction."""
    return lambda points: watch.costs(np.array([watch.problem.order.find_shares(v) for v in points]))


def _find_points(watch: SearchMonitor, keep: int, count: int, seed: int) -> list[Any]:
    """Return the best of a Sobol' sequence of points."""
    found = find_starts(_count_costs(watch), len(watch.problem.free), count=count, keep=keep, seed=seed)
    return [watch.problem.order.find_shares(one.values) for one in found]


def _find_moving_starts(watch: SearchMonitor, seed: int) -> list[tuple[str, Any]]:
    """Return starts at which something transforms; empty if all runs fail."""
    watch.stage = "other starts: at the first runs fail, or nothing transforms"
    watch.evaluate(watch.problem.start.tolist())  # which is kept where no point is better
    try:
        found = _find_points(watch, OTHERS, SPREAD, seed)
    except SolveError:
        return []
    return _name_starts([u for u in found if not _find_unmoved(watch.problem, u)])


def _name_starts(points: Sequence[Any]) -> list[tuple[str, Any]]:
    return [(f"start {k}", u) for k, u in enumerate(points, start=1)]


def _judge_end(watch: SearchMonitor, loss: Loss, reason: str, most: int) -> str:
    """Return how a search ended, after a test of its end for parameters without effect and for being stationary."""
    if watch.best is not None and (idle := _find_unmoved(watch.problem, watch.best)):
        return _describe_rest(watch.problem, watch.best, idle)
    return verify_optimum(watch, loss, most) if reason == CONVERGED else reason


def _find_unmoved(problem: Problem, u: Any) -> list[int] | None:
    """Places of numbers that move nothing where all are so, or nothing transforms; None where a run fails."""
    found = problem.evaluate(u, slopes=True)
    if found is None:
        return None
    idle = find_idle(problem, found)
    if not idle or len(idle) == len(problem.free):
        return idle
    return [] if detect_transformation(problem, u) else idle


def _describe_rest(problem: Problem, u: Any, idle: Sequence[int]) -> str:
    """Describe the end of a search at which the parameters in the places `idle` have no effect."""
    numbers = [format_quantity(problem.free[i].value(float(u[i])), problem.free[i].unit) for i in idle]
    where = join_phrases([f"{problem.names[i]} = {number}" for i, number in zip(idle, numbers, strict=True)])
    what = "nothing that is compared changes" if detect_transformation(problem, u) else "nothing transforms"
    return f"{what} at {where}; the fit did not move"
