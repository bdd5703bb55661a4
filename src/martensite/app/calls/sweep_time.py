"""Estimate how long a sweep will take, from one block of its runs.

Request as of the job `sweep` -> {"seconds": …, "tried": runs of the block, "took": its time, …}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.documents import scenario_of
from martensite.app.sweeping.asked import how_of, sized, wanted_of
from martensite.app.sweeping.timing import timed
from martensite.app.worker import Desk
from martensite.design.backends.processes import cores
from martensite.design.sweep.job import prepared


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Choose the step, run a block, and multiply."""
    plan, asked = prepared(scenario_of(request, desk), wanted_of(request))
    one = timed(sized(plan))
    workers = how_of(request).workers or cores()
    return {
        "seconds": one.total(plan.size, workers),
        "tried": one.runs,
        "took": one.seconds,
        "workers": workers,
        "step": asked.step,
        "runtime": asked.runtime,
    }
