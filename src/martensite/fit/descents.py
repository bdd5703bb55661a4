"""Descents of a fit: trust-region searches from every start, and a test of stationarity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.fit.evaluation import Evaluation
from martensite.fit.losses import Loss, estimate_scale
from martensite.fit.search_monitor import SearchMonitor
from martensite.search.least_squares import SETTLED, DescentEnd, descend_squares

RESUMED = "best so far"
CONVERGED, INTERRUPTED, NOT_STATIONARY = "converged", "interrupted", "not at a stationary point"
OUT_OF_TIME = "time box used up"
BOUNDED = "stopped at bounds"
POLISHES = 5
"""Number of restarts from an end that is not stationary."""
STATIONARY = 0.1
"""Gauss-Newton step, in standard errors, below which a point is stationary."""
LINE = (1.0, 0.3, 0.1, 0.03)
"""Tried fractions of such a step."""
AT_BOUND = 1e-4
"""Distance within which a point counts as at a bound."""
ROUNDING = 1e-7
"""Fraction of range or noise below which residuals are rounding errors."""
MOST_EVALUATIONS = 200
"""Evaluations of one local search."""


def run_descents(watch: SearchMonitor, begins: Sequence[tuple[str, Any]], loss: Loss, most: int) -> str:
    """Run a local search from every start, and return the stop reason of the best."""
    reason, least = "failed at the start", math.inf
    for k, (stage, begin) in enumerate(begins):
        if stage in watch.done:
            continue
        watch.stage, watch.share = stage, k / len(begins)
        ended = descend_from(watch, begin, loss, most)
        if stage != RESUMED:  # which is never far from its end
            watch.finish_stage(stage)
        if watch.cost < least:
            least, reason = watch.cost, ended
    return reason


def verify_optimum(watch: SearchMonitor, loss: Loss, most: int) -> str:
    """Continue the search while a Gauss-Newton step improves the cost, and return whether the end is stationary."""
    watch.stage = "verifying the optimum"
    for _ in range(POLISHES):
        point = np.array(watch.best)
        evaluation = watch.evaluate(point.tolist(), slopes=True)
        if evaluation is None:
            return NOT_STATIONARY
        weights = np.sqrt(loss.weights(evaluation.residuals, _scale_loss(loss, evaluation)))
        order, place = watch.problem.order, watch.problem.order.find_places(point)
        weighted = weights * evaluation.residuals, weights[:, None] * (evaluation.jacobian @ order.find_slopes(place))
        step, step_length = find_step(*weighted, place)
        if step_length <= STATIONARY:
            return CONVERGED if find_step(*weighted, 0.5 + 0.0 * point)[1] <= STATIONARY else BOUNDED
        if loss.name != "linear":
            return NOT_STATIONARY
        before = watch.cost
        for share in LINE:
            watch.evaluate(order.find_shares(np.clip(place + share * step, 0.0, 1.0)).tolist())
        if watch.cost >= before * (1.0 - SETTLED):  # a kink: the Gauss-Newton step does not help
            return CONVERGED
        descend_from(watch, np.array(watch.best), loss, most)
    return NOT_STATIONARY


def _scale_loss(loss: Loss, evaluation: Evaluation) -> float:
    return 1.0 if loss.name == "linear" else max(estimate_scale(evaluation.residuals), 1e-12)


def find_step(residuals: Any, jacobian: Any, point: Any) -> tuple[Any, float]:
    """Return the Gauss-Newton step within bounds, and its length in standard errors of the residuals.

    Args:
        residuals: (n,), weighted.
        jacobian: (n, free).
        point: fractions from 0 to 1.
    """
    gradient = jacobian.T @ residuals
    fixed_parameters = ((point <= AT_BOUND) & (gradient > 0.0)) | ((point >= 1.0 - AT_BOUND) & (gradient < 0.0))
    step, moving = np.zeros(len(point)), np.flatnonzero(~fixed_parameters)
    spare = max(len(residuals) - len(moving), 1)
    noise = math.sqrt(float(residuals @ residuals) / spare)
    if not len(moving) or noise <= ROUNDING:
        return step, 0.0
    step[moving] = -np.linalg.lstsq(jacobian[:, moving], residuals, rcond=1e-8)[0]
    return step, float(np.linalg.norm(jacobian @ step)) / noise / math.sqrt(len(moving))


def descend_from(watch: SearchMonitor, begin: Any, loss: Loss, most: int = MOST_EVALUATIONS) -> str:
    """Return one trust-region search; the monitor stores its points and costs."""
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
        watch.cost = math.inf  # another cost counts from here on
    descent = _descend_to_optimum(watch, begin, first, most, loss.scipy_name, scale)
    if loss.name != "linear":  # unweighted least squares are not the target
        watch.best = tuple(map(float, descent.shares))
    return CONVERGED if descent.converged else f"stopped after {most} evaluations"


def _descend_to_optimum(
    watch: SearchMonitor, begin: Any, first: Evaluation, most: int, loss: str, scale: float
) -> DescentEnd:
    order = watch.problem.order

    def evaluate(v: Any, slopes: bool) -> Evaluation | None:
        outcome = watch.evaluate(order.find_shares(v).tolist(), slopes=slopes)
        return order.turn_slopes(outcome, v) if slopes and outcome is not None else outcome

    place = order.find_places(begin)
    outcome = descend_squares(evaluate, place, order.turn_slopes(first, place), most=most, loss=loss, scale=scale)
    return outcome._replace(shares=order.find_shares(outcome.shares))
