"""Variants one after another on plain floats, for machines without a compiler."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.status import Status
from martensite.simulate.compiled import bind_march
from martensite.simulate.envelope import envelope_of
from martensite.simulate.grid import TimeGrid
from martensite.simulate.lane_grid import LaneGrid
from martensite.simulate.march import Border, march_floats

if TYPE_CHECKING:
    from martensite.simulate.variants import Values, VariantSetup

REPORTS = {
    Status.OK: (0.0, 0.0, 0.0),
    Status.LONG_STEP: (0.0, 1.0, 0.0),
    Status.UNSOLVED: (1.0, 0.0, 0.0),
    Status.OUT_OF_ENVELOPE: (0.0, 0.0, 0.0),
}
"""Worst reports that stand for a status."""
BROKEN = (np.inf, 0.0, 0.0)


def march_on_steps(
    course: VariantSetup, values: Values, grid: TimeGrid | LaneGrid, runs: int
) -> tuple[list[Any], Any, Any]:
    """Columns (runs, samples), reports (3, runs), and when runs left the envelope (runs,).

    A failed run has a report above the limit.
    """
    columns = np.full((len(course.outputs), runs, course.samples), np.nan)
    reports, left = np.zeros((3, runs)), np.full(runs, np.inf)
    for run in range(runs):
        system = course.system.rebuilt({path: float(v[run]) for path, v in values.items()})
        one = grid if isinstance(grid, TimeGrid) else grid.lane(run)
        try:
            functions, size = bind_march(system)
            border = Border(course.compiled, functions, envelope_of(system))
            track = march_floats(functions, size, one, border)
        except ArithmeticError:  # what follows from parameters alone is no number
            reports[:, run] = BROKEN
            continue
        reports[:, run] = REPORTS.get(track.status, BROKEN)
        if track.status is Status.OUT_OF_ENVELOPE:
            left[run] = track.status_time
        rows = np.asarray(track.rows)[:, list(course.places)].T
        columns[:, run, : rows.shape[1]] = rows
    return list(columns), reports, left
