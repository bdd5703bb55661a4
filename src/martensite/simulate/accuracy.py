"""A march to a tolerance, with a bound on what is left of its error.

A run is made twice, the second time to a local tolerance that is several times smaller. What the
two differ by, times `SURE`, bounds the error of the second; where it is above the tolerance, a
third one follows, and so on. To it comes what the means of drives leave out of ripple, which no run
shows. Runs may have an error in common, such as a kink that both meet with the same step: nothing
better than half of the tolerance is claimed. Between edges of a drive that cut all steps two runs
may take the same ones: hence all but the first split the last of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.marching import Marched, MarchPlan

LOCAL = {2: 0.15, 4: 0.6}
"""Accepted error of a step of the first run, as a share of the tolerance, by the order of a step:
one of order four takes the solution of order four, and its error is that of order three."""
SURE = 2.0
"""Bound on an error over the difference of two runs by which it is seen."""
FLOOR = 0.5
"""No better accuracy is claimed, as a share of the tolerance."""
FINER = 5.0
"""By what local tolerances go down from run to run."""
MOST = 5
"""Runs after the first one."""
FEW = 201
"""Samples at which runs are compared."""
LEAST = 1e-12
"""No accuracy is claimed below this."""

March = Callable[[MarchPlan], Marched]
Rows = Sequence[Sequence[float]]


def march_to(march: March, plan: MarchPlan, tolerance: float) -> tuple[Marched, float]:
    """The last run, and how far it may be off, as a share of the range of each judged output.

    Args:
        march: makes a run.
        plan: its `tolerance` does not count.
        tolerance: what accuracy is wanted.
    """
    compared = choose_samples(len(plan.times))
    local = LOCAL[plan.order] * tolerance
    some = replace(plan, times=[plan.times[k] for k in compared], recorded=False)
    found = march(replace(some, tolerance=local))
    rows, accuracy = found.rows, math.inf
    for _ in range(MOST):
        local /= FINER
        found = march(replace(plan, tolerance=local, ranges=found.ranges, parted=True))
        before, rows = rows, [found.rows[k] for k in compared if k < len(found.rows)]
        accuracy = max(bound_error(plan.compiled, before, rows, found), FLOOR * tolerance)
        if accuracy <= tolerance:
            break
    return found, accuracy


def choose_samples(count: int) -> list[int]:
    """Which of so many samples are compared: not many more than `FEW`, both ends among them."""
    every = max(1, math.ceil((count - 1) / (FEW - 1)))
    return sorted({*range(0, count, every), count - 1})


def bound_error(compiled: CompiledMarch, before: Rows, after: Rows, found: Marched) -> float:
    """Largest difference of what is judged, with what no run shows, as a share of ranges."""
    worst = 0.0
    for k, (name, least) in enumerate(compiled.convergence_scales):
        place, scale = compiled.outputs.index(name), max(found.ranges[k], least)
        pairs = zip(before, after, strict=False)
        apart = max((abs(a[place] - b[place]) for a, b in pairs), default=math.inf)
        worst = max(worst, apart / scale)
    heat = max(found.ranges[0], compiled.convergence_scales[0][1]) if compiled.convergence_scales else 1.0
    total = max(SURE * worst + found.ripple / heat, found.residual, LEAST)
    return total if math.isfinite(total) else math.inf
