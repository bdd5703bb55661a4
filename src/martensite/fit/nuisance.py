"""What a record has for itself: the zero of a sensor, the delay of its clock.

    offset.OUTPUT   added to what the model says, in the unit of the output
    delay           seconds by which the record lags behind the run

Any parameter of the system may be free for each record as well, such as `initial_fraction`.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from martensite.base.errors import UnknownNameError
from martensite.fit.experiment import Experiment
from martensite.fit.free import Free, Wish, free_parameters

OFFSET, DELAY = "offset", "delay"
LATE = 0.05
"""Longest delay either way, as a share of the record."""
FARTHEST = 2.0
"""Largest offset either way, in measured ranges."""


def own_parameters(wishes: Sequence[Wish], experiments: Sequence[Experiment]) -> list[Free]:
    """Free parameters that every experiment has for itself.

    `offset` alone stands for all outputs that are compared.

    Raises:
        ParameterError: an unknown name, or bounds that are none.
        UnknownNameError: an offset of an output that is not compared.
    """
    found: list[Free] = []
    for wish in wishes:
        for experiment in experiments:
            found += _own(wish, experiment)
    return found


def _own(wish: Wish, experiment: Experiment) -> list[Free]:
    name, record = wish.name, experiment.name
    if name == DELAY:
        latest = LATE * float(experiment.times[-1] - experiment.times[0])
        return [_free(wish, DELAY, "s", latest, record, "delay of the record")]
    head, _, output = name.partition(".")
    if head != OFFSET:
        return free_parameters([wish], [experiment.system], record)
    outputs = [output] if output else list(experiment.outputs)
    return [_offset(wish, one, experiment) for one in outputs]


def _offset(wish: Wish, output: str, experiment: Experiment) -> Free:
    if output not in experiment.outputs:
        raise UnknownNameError("compared output", output, experiment.outputs)
    column = experiment.measured[:, experiment.outputs.index(output)]
    reach = FARTHEST * float(np.nanmax(column) - np.nanmin(column))
    unit = experiment.system.outputs()[output].unit
    return _free(wish, f"{OFFSET}.{output}", unit, reach, experiment.name, f"zero of {output}")


def _free(wish: Wish, ending: str, unit: str, reach: float, record: str, doc: str) -> Free:
    low = -reach if wish.low is None else wish.low
    high = reach if wish.high is None else wish.high
    start = min(max(0.0, low), high) if wish.start is None else wish.start
    return Free(f"{ending}@{record}", ending, unit, start, low, high, False, record, doc)


def is_nuisance(free: Free) -> bool:
    """True for what belongs to the record and not to the system."""
    return free.ending == DELAY or free.ending.startswith(OFFSET + ".")


def delayed(
    times: Any, model: Any, slopes: Any, delay: float, slope: float, place: int
) -> tuple[Any, Any]:
    """What is seen `delay` [s] late, and its derivatives."""
    first, last = times[0], times[-1]
    at = np.clip(times - delay, first, last)
    curve = _curve(times, model)
    if slopes is not None:
        turned = _curve(times, slopes)(at)
        inside = (at > first) & (at < last)
        turned[:, :, place] -= slope * np.where(inside[:, None], curve(at, 1), 0.0)
        slopes = turned
    return curve(at), slopes


def _curve(times: Any, rows: Any) -> Any:
    """Smooth columns through rows: cubic Hermite pieces, so that their slopes are exact."""
    made = import_module("scipy.interpolate").CubicHermiteSpline
    return made(times, rows, np.gradient(rows, times, axis=0))
