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

from martensite.base.errors import require_known
from martensite.fit.experiment import Experiment
from martensite.fit.free_parameters import DELAY, OFFSET, build_free_numbers
from martensite.search.free_numbers import FreeNumber, SearchRange

LONGEST_DELAY = 0.05
"""Longest delay either way, as a share of the record."""
LARGEST_OFFSET = 2.0
"""Largest offset either way, in measured ranges."""


def build_own_parameters(ranges: Sequence[SearchRange], experiments: Sequence[Experiment]) -> list[FreeNumber]:
    """Free parameters that every experiment has for itself.

    `offset` alone stands for all outputs that are compared.

    Raises:
        ParameterError: an unknown name, or bounds that are none.
        UnknownNameError: an offset of an output that is not compared.
    """
    found: list[FreeNumber] = []
    for wanted in ranges:
        for experiment in experiments:
            found += _list_own(wanted, experiment)
    return found


def _list_own(wanted: SearchRange, experiment: Experiment) -> list[FreeNumber]:
    name, record = wanted.name, experiment.name
    if name == DELAY:
        latest = LONGEST_DELAY * float(experiment.times[-1] - experiment.times[0])
        return [_build_own(wanted, DELAY, "s", latest, record, "delay of the record")]
    head, _, output = name.partition(".")
    if head != OFFSET:
        return build_free_numbers([wanted], [experiment.system], record)
    outputs = [output] if output else list(experiment.outputs)
    return [_build_offset(wanted, one, experiment) for one in outputs]


def _build_offset(wanted: SearchRange, output: str, experiment: Experiment) -> FreeNumber:
    require_known("compared output", output, experiment.outputs)
    column = experiment.measured[:, experiment.outputs.index(output)]
    reach = LARGEST_OFFSET * float(np.nanmax(column) - np.nanmin(column))
    unit = experiment.system.outputs()[output].unit
    return _build_own(wanted, f"{OFFSET}.{output}", unit, reach, experiment.name, f"zero of {output}")


def _build_own(wanted: SearchRange, path: str, unit: str, reach: float, record: str, doc: str) -> FreeNumber:
    low = -reach if wanted.low is None else wanted.low
    high = reach if wanted.high is None else wanted.high
    start = min(max(0.0, low), high) if wanted.start is None else wanted.start
    return FreeNumber(f"{path}@{record}", path, unit, start, low, high, record=record, doc=doc)


def delay_model(times: Any, model: Any, slopes: Any, delay: float, slope: float, place: int) -> tuple[Any, Any]:
    """What is seen `delay` [s] late, and its derivatives."""
    first, last = times[0], times[-1]
    at = np.clip(times - delay, first, last)
    curve = _interpolate_rows(times, model)
    if slopes is not None:
        turned = _interpolate_rows(times, slopes)(at)
        inside = (at > first) & (at < last)
        turned[:, :, place] -= slope * np.where(inside[:, None], curve(at, 1), 0.0)
        slopes = turned
    return curve(at), slopes


def _interpolate_rows(times: Any, rows: Any) -> Any:
    """Smooth columns through rows: cubic Hermite pieces, so that their slopes are exact."""
    made = import_module("scipy.interpolate").CubicHermiteSpline
    return made(times, rows, np.gradient(rows, times, axis=0))
