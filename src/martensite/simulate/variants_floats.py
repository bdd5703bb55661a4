"""Variants one after another on plain floats, for machines without a compiler."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.simulate.compiled import bind_march
from martensite.simulate.grid import Grid
from martensite.simulate.lane_grid import LaneGrid
from martensite.simulate.march import march_floats
from martensite.status import Status

if TYPE_CHECKING:
    from martensite.simulate.variants import Course, Values

REPORTS = {
    Status.OK: (0.0, 0.0, 0.0),
    Status.LONG_STEP: (0.0, 1.0, 0.0),
    Status.UNSOLVED: (1.0, 0.0, 0.0),
}
"""Worst reports that stand for a status."""
BROKEN = (np.inf, 0.0, 0.0)


def march_one_by_one(
    course: Course, values: Values, grid: Grid | LaneGrid, runs: int
) -> tuple[list[Any], Any]:
    """Columns (runs, samples) and reports (3, runs); a failed run has a report above the limit."""
    columns = np.full((len(course.outputs), runs, course.samples), np.nan)
    reports = np.zeros((3, runs))
    for run in range(runs):
        system = course.system.rebuilt({path: float(v[run]) for path, v in values.items()})
        one = grid if isinstance(grid, Grid) else grid.lane(run)
        try:
            track = march_floats(*bind_march(system), one)
        except ArithmeticError:  # what follows from parameters alone is no number
            reports[:, run] = BROKEN
            continue
        reports[:, run] = REPORTS.get(track.status, BROKEN)
        rows = np.asarray(track.rows)[:, list(course.places)].T
        columns[:, run, : rows.shape[1]] = rows
    return list(columns), reports
