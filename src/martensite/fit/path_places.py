"""Position of each row of a record along its path, for the choice of held-out parts.

A stretch of time can contain a whole transformation. A twentieth of the path of drive and measured column cannot,
because a transformation is at least half the path of its cycle. Positions restart in every cycle, so that the same part
of all cycles is held out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.characterise.loop_paths import LoopPath, measure_arc, trace_loop
from martensite.fit.drive_lag import find_drive
from martensite.fit.experiment import Experiment


def measure_places(one: Experiment) -> Any:
    """Return the position of each compared row on the path of its cycle, (rows,), from 0 to 1.

    The path is over a drive that prescribes a state, such as temperature or strain; otherwise over time.
    """
    samples = one.measured[:, 0]
    finite_rows = np.isfinite(samples)
    rows = np.arange(len(samples))
    path = _trace_drive(one)
    arc = measure_arc(path, np.interp(rows, rows[finite_rows], samples[finite_rows]))
    places = np.zeros(len(rows))
    for first, last in path.cycles or [(0, len(rows) - 1)]:
        places[first : last + 1] = (arc[first : last + 1] - arc[first]) / ((arc[last] - arc[first]) or 1.0)
    return np.where(finite_rows, places, 0.0)


def _trace_drive(one: Experiment) -> LoopPath:
    drive = find_drive(one)
    late = {x.name for x in one.system.drives() if x.at_end}
    if drive in late:
        column = np.asarray(one.record[one.follows[drive]], float)[one.rows]
        if np.isfinite(column).all():
            return trace_loop(column)
    return LoopPath(one.times, (0, len(one.times) - 1), 0.0, 0)
