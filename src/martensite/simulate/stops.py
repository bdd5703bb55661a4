"""End of a run at the envelope, with one time for rows, balances and messages.

A step may end far outside the envelope. The crossing is located between the last sample inside and the end of that
step. The run is then repeated to this time, so that all results end together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import BudgetError, SolveError
from martensite.base.status import Status
from martensite.simulate.envelope import Envelope, rows_inside
from martensite.simulate.marching import MarchPlan, MarchResult, Row, RunLimits

Remarch = Callable[[MarchPlan], tuple[MarchResult, float | None]]
"""Function that repeats a run from its start, with its accuracy."""
PARTS = 64
"""Parts of a sample interval in the search for the crossing."""
SHARES = (0.999, 0.99, 0.9)
"""Trial fractions of the interval from the last sample inside to the crossing."""


def end_at_envelope(
    system: AbstractSystem, plan: MarchPlan, run: MarchResult, accuracy: float | None, remarch: Remarch
) -> tuple[MarchPlan, MarchResult, float | None]:
    """Return the plan, run and accuracy up to the exit from the envelope.

    Args:
        system: simulated system.
        plan: plan of the run.
        run: the run; a run that stays inside is returned unchanged.
        accuracy: accuracy of the run, None without an estimate.
        remarch: function that simulates another plan of the same system.
    """
    if run.status is not Status.OUT_OF_ENVELOPE:
        return plan, run, accuracy
    inside = list(rows_inside(system, run.rows))
    samples = list(plan.times[: len(inside)])
    far = min([run.time, *plan.times[len(inside) : len(inside) + 1]])
    crossing = _find_crossing(system, plan, samples, far, remarch) if far > samples[-1] else samples[-1]
    ends = [[*samples, samples[-1] + share * (crossing - samples[-1])] for share in SHARES if crossing > samples[-1]]
    for times in [*ends, samples]:
        again = _try_run(remarch, plan, times)
        if again is None or len(list(rows_inside(system, again[0].rows))) < len(times):
            continue
        stopped = replace(
            again[0], status=Status.OUT_OF_ENVELOPE, time=times[-1], place=run.place, value=_bound(plan, run)
        )
        return plan._replace(times=times), stopped, again[1]
    return plan._replace(times=samples), replace(run, rows=inside, time=samples[-1]), accuracy


def _try_run(remarch: Remarch, plan: MarchPlan, times: list[float]) -> tuple[MarchResult, float | None] | None:
    """Return a run without envelope to the last given time [s]; None if it fails or no time is given."""
    free = RunLimits(*((end * float("inf"),) * len(plan.limits.low) for end in (-1.0, 1.0)))
    if len(times) < 2:
        return None
    try:
        return remarch(plan._replace(times=times, limits=free, extremes=((), ())))
    except BudgetError:
        raise
    except SolveError:
        return None


def _find_crossing(
    system: AbstractSystem, plan: MarchPlan, samples: list[float], far: float, remarch: Remarch
) -> float:
    """Return the exit time [s] between the last sample inside and a time outside."""
    between = [samples[-1] + (far - samples[-1]) * k / PARTS for k in range(1, PARTS + 1)]
    again = _try_run(remarch, plan, [*samples, *between])
    rows: list[Row] = [] if again is None else [tuple(row) for row in again[0].rows[len(samples) - 1 :]]
    envelope, begin = Envelope(system), samples[-1]
    for before, after, end in zip(rows, rows[1:], between, strict=False):
        crossing = envelope.find_exit(after)
        if crossing is not None:
            return begin + _share_inside(envelope, before, after, crossing.place) * (end - begin)
        begin = end
    return begin


def _share_inside(envelope: Envelope, before: Row, after: Row, place: int) -> float:
    """Return the fraction of a straight line between two rows that is inside a bound."""
    first, last = before[envelope.places[place]], after[envelope.places[place]]
    bound = envelope.limits.high[place] if last > first else envelope.limits.low[place]
    return min(max((bound - first) / (last - first), 0.0), 1.0) if last != first else 0.0


def _bound(plan: MarchPlan, run: MarchResult) -> float:
    """Return the exceeded bound of a run."""
    high = run.value > plan.limits.low[run.place]
    return (plan.limits.high if high else plan.limits.low)[run.place]
