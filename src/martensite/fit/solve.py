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
from typing import Any

import numpy as np

from martensite.base.errors import InputError, SolveError, require_known
from martensite.base.interrupts import accept_interrupt
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit, HeldOutRecord
from martensite.fit.input_noise import Descend, correct_for_inputs
from martensite.fit.losses import Loss, estimate_scale, find_loss
from martensite.fit.problem import Evaluation, Problem
from martensite.fit.search_monitor import SearchMonitor, Tell
from martensite.fit.start_checks import detect_transformation, find_idle
from martensite.search.coordinate_search import search_coordinates
from martensite.search.least_squares import SETTLED, Descended, descend_squares
from martensite.search.quantity_text import format_quantity, join_phrases
from martensite.search.starts import evolve_start, find_starts

METHODS = ("trf", "coordinate", "evolution")
SPREAD = 32
"""Sobol' points tried for each start."""
OTHERS = 4
"""Starts tried where nothing transforms at the first."""
RESUMED = "best so far"
CONVERGED, INTERRUPTED, NOT_STATIONARY = "converged", "interrupted", "not at a stationary point"
BOUNDED = "stopped at bounds"
POLISHES = 5
"""Number of restarts from an end that is not stationary."""
STATIONARY = 0.1
"""Step that the derivatives still ask for, in standard errors, below which a point is stationary."""
LINE = (1.0, 0.3, 0.1, 0.03)
"""Parts of such a step that are tried."""
REFINING = 20
"""Evaluations of a search in one round of the correction for noise in what drives."""
AT_BOUND = 1e-4
"""Distance from a bound that counts as none."""
ROUNDING = 1e-7
"""Share of range or noise below which residuals are those of rounding."""
SPECIMEN = "specimen"
"""The kind of group whose records are kept back together."""
FIRST_NOISE = 0.02
"""Noise as a share of the range with which spreads are first weighed, where it is not known."""
ROUNDS, BALANCED = 6, 0.05
"""Fits in which it is found, and the relative change that ends them."""
MOST_EVALUATIONS = 200
"""Evaluations of one local search."""


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
        if watch.best is not None and (idle := _find_unmoved(training, watch.best)):
            reason = _describe_rest(training, watch.best, idle)
        elif reason == CONVERGED:
            reason = _verify_optimum(watch, chosen, most)
    except KeyboardInterrupt:
        if watch.best is None:
            raise
        accept_interrupt()
        reason = INTERRUPTED
    watch.save()
    if watch.best is None:
        raise SolveError(
            "The runs fail at the start of the fit and wherever else it was tried; run the "
            "scenario alone to see why, or start from other values."
        )
    end, plain = np.array(watch.best), training.evaluate(watch.best, slopes=True)
    if plain is None:
        raise SolveError("The run at the best point fails when it is repeated.")
    noise, notes = (), list[str]()
    if inputs and reason != INTERRUPTED:
        try:
            training, end, noise, notes = correct_for_inputs(training, end, _make_descent(chosen, plain))
        except (KeyboardInterrupt, SolveError):
            accept_interrupt()
            notes.append("The noise of columns that drive was not taken into account: that search did not end.")
    evaluation = plain
    if noise:
        point = end.tolist()
        again, found = watch.problem.evaluate(point), training.evaluate(point, slopes=True)
        if again is not None and found is not None:
            evaluation = Evaluation(again.fitted, found.residuals, found.jacobian)
    return Fit(
        training,
        tuple(map(float, end)),
        evaluation,
        method,
        loss,
        reason,
        watch.simulations,
        watch.jacobians,
        time.monotonic() - begun,
        tuple(watch.history),
        tuple(_predict_held_out(problem, one, end) for one in problem.experiments if one.held_out),
        input_noise=tuple(noise),
        notes=tuple(notes),
    )


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
        if fit.reason == INTERRUPTED or abs(scale - before) <= BALANCED * before:
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
        if fit.reason == INTERRUPTED:
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
        raise SolveError(f"The run of record `{one.name}`, which was kept back, fails.")
    raw = found.fitted[0].model
    if own:  # fitted to it, everything else as found
        alone = replace(one, held=(), system=whole.system(0, at))
        fit = solve_problem(replace(problem, experiments=(alone,), free=own, later=()), inputs=False)
        return HeldOutRecord(one, fit.evaluation.fitted[0].model, fit.numbers, raw)
    return HeldOutRecord(one, raw, {}, raw)


def _run_search(watch: SearchMonitor, method: str, loss: Loss, starts: int, seed: int, most: int) -> str:
    problem = watch.problem
    size = len(problem.free)
    if method == "coordinate":
        watch.stage = "coordinate search"
        begin = problem.start if watch.best is None else np.array(watch.best)

        def cost(u: Sequence[float]) -> float:
            found = watch.evaluate(u)
            return math.inf if found is None else found.cost

        return search_coordinates(cost, begin.tolist())[1]
    begins = [("scenario", problem.start)]

    def costs(points: Any) -> Any:
        return watch.costs(np.array([problem.order.find_shares(v) for v in points]))

    if method == "evolution" and "evolution" not in watch.done:
        watch.stage = "differential evolution"
        begins = [("best of evolution", problem.order.find_shares(evolve_start(costs, size, seed=seed).values))]
        watch.finished("evolution")
    if watch.best is not None:
        begins = [(RESUMED, np.array(watch.best))]
    if starts:
        watch.stage = f"{SPREAD * starts} points"
        if watch.best is None:  # something to show, should the points be interrupted
            watch.evaluate(problem.start.tolist())
        spread = find_starts(costs, size, count=SPREAD * starts, keep=starts, seed=seed)
        begins += [(f"start {k}", problem.order.find_shares(s.values)) for k, s in enumerate(spread, start=1)]
    elif watch.best is None and _find_unmoved(problem, problem.start) != []:
        watch.stage = "other starts: at the first runs fail, or nothing transforms"
        watch.evaluate(problem.start.tolist())  # which is kept where no point is better
        try:
            spread = find_starts(costs, size, count=SPREAD, keep=OTHERS, seed=seed)
        except SolveError:
            spread = ()
        moving = [u for u in (problem.order.find_shares(s.values) for s in spread) if not _find_unmoved(problem, u)]
        begins = [(f"start {k}", u) for k, u in enumerate(moving, start=1)] or begins
    return _run_descents(watch, begins, loss, most)


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


def _run_descents(watch: SearchMonitor, begins: Sequence[tuple[str, Any]], loss: Loss, most: int) -> str:
    """Return a local search from every start; how the best of them ended."""
    reason, least = "failed at the start", math.inf
    for k, (stage, begin) in enumerate(begins):
        if stage in watch.done:
            continue
        watch.stage, watch.share = stage, k / len(begins)
        ended = descend_from(watch, begin, loss, most)
        if stage != RESUMED:  # which is never far from its end
            watch.finished(stage)
        if watch.cost < least:
            least, reason = watch.cost, ended
    return reason


def _verify_optimum(watch: SearchMonitor, loss: Loss, most: int) -> str:
    """Return whether the derivatives ask for no further step that helps; the search goes on as long as they do."""
    watch.stage = "verifying the optimum"
    for _ in range(POLISHES):
        point = np.array(watch.best)
        found = watch.evaluate(point.tolist(), slopes=True)
        if found is None:
            return NOT_STATIONARY
        weights = np.sqrt(loss.weights(found.residuals, _scale_loss(loss, found)))
        order, place = watch.problem.order, watch.problem.order.find_places(point)
        weighted = weights * found.residuals, weights[:, None] * (found.jacobian @ order.find_slopes(place))
        step, asked = find_step(*weighted, place)
        if asked <= STATIONARY:
            return CONVERGED if find_step(*weighted, 0.5 + 0.0 * point)[1] <= STATIONARY else BOUNDED
        if loss.name != "linear":
            return NOT_STATIONARY
        before = watch.cost
        for share in LINE:
            watch.evaluate(order.find_shares(np.clip(place + share * step, 0.0, 1.0)).tolist())
        if watch.cost >= before * (1.0 - SETTLED):  # a kink: the step that is asked for does not help
            return CONVERGED
        descend_from(watch, np.array(watch.best), loss, most)
    return NOT_STATIONARY


def _scale_loss(loss: Loss, found: Evaluation) -> float:
    return 1.0 if loss.name == "linear" else max(estimate_scale(found.residuals), 1e-12)


def find_step(residuals: Any, jacobian: Any, point: Any) -> tuple[Any, float]:
    """Return the step of Gauss and Newton that bounds allow, and its length in standard errors of the residuals.

    Args:
        residuals: (n,), weighted.
        jacobian: (n, free).
        point: shares from 0 to 1.
    """
    gradient = jacobian.T @ residuals
    held = ((point <= AT_BOUND) & (gradient > 0.0)) | ((point >= 1.0 - AT_BOUND) & (gradient < 0.0))
    step, moving = np.zeros(len(point)), np.flatnonzero(~held)
    spare = max(len(residuals) - len(moving), 1)
    noise = math.sqrt(float(residuals @ residuals) / spare)
    if not len(moving) or noise <= ROUNDING:
        return step, 0.0
    step[moving] = -np.linalg.lstsq(jacobian[:, moving], residuals, rcond=1e-8)[0]
    return step, float(np.linalg.norm(jacobian @ step)) / noise / math.sqrt(len(moving))


def descend_from(watch: SearchMonitor, begin: Any, loss: Loss, most: int = MOST_EVALUATIONS) -> str:
    """Return one trust-region search; its points and costs are kept by the watch."""
    first = watch.evaluate(begin, slopes=True)
    if first is None:
        return "failed at the start"
    if not first.jacobian.any():
        return "no derivative at the start"
    scale = 1.0
    if loss.name != "linear":
        _descend_to_optimum(watch, begin, first, most, "linear", scale)
        now = watch.evaluate(watch.best or begin)
        scale = loss.tuning * max(estimate_scale((now or first).residuals), 1e-12)
        begin = np.array(watch.best)
        watch.cost = math.inf  # what counts is another cost from here on
    found = _descend_to_optimum(watch, begin, first, most, loss.scipy_name, scale)
    if loss.name != "linear":  # the least squares on the way are not what is looked for
        watch.best = tuple(map(float, found.shares))
    return CONVERGED if found.converged else f"stopped after {most} evaluations"


def _descend_to_optimum(
    watch: SearchMonitor, begin: Any, first: Evaluation, most: int, loss: str, scale: float
) -> Descended:
    order = watch.problem.order

    def evaluate(v: Any, slopes: bool) -> Evaluation | None:
        found = watch.evaluate(order.find_shares(v).tolist(), slopes=slopes)
        return order.turn_slopes(found, v) if slopes and found is not None else found

    place = order.find_places(begin)
    found = descend_squares(evaluate, place, order.turn_slopes(first, place), most=most, loss=loss, scale=scale)
    return found._replace(shares=order.find_shares(found.shares))
