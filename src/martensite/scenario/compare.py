"""Deviation of a run from a record in every common quantity.

The run is interpolated linearly at the times of the record and never extrapolated. Missing samples (NaN) are ignored.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from martensite.base.errors import DataError
from martensite.signals.records import Record

if TYPE_CHECKING:
    from martensite.simulate.result import Result

ROUNDING = 1e-9
"""Share of the run by which a measured time may lie outside."""


@dataclass(frozen=True)
class Agreement:
    """Deviation between the computed and the measured values of one quantity."""

    quantity: str
    unit: str
    """SI unit of all numbers but the time."""
    rms: float
    """Root mean square of computed minus measured."""
    maximum: float
    """Largest deviation."""
    time: float
    """Time of the largest deviation [s]."""
    range: float
    """Largest minus smallest measured value."""


def compare_with_record(result: Result, record: Record) -> list[Agreement]:
    """Return the deviation of a run from a record for every common column.

    Raises:
        DataError: there is no common column, a unit differs, or times are outside the run.
    """
    names = list_common(result, record)
    if not names:
        raise DataError(
            f"Record `{record.name}` and the run have no column in common: the record holds "
            f"{_list_names(record.columns)}, the run {_list_names(result.columns)}."
        )
    for name in names:
        if record.units[name] != result.unit(name):
            raise DataError(
                f"Column `{name}` of record `{record.name}` is in {record.units[name]}, "
                f"but that of the run in {result.unit(name)}."
            )
    times = result.times.tolist()
    _refuse_outside(times, record)
    places = [_locate_time(times, time) for time in record.times.tolist()]
    return [_measure_agreement(name, result, record, places) for name in names]


def list_common(result: Result, record: Record) -> list[str]:
    """Return the common columns of a run and a record that are not empty."""
    return [
        name for name, column in record.columns.items() if name in result.columns and any(map(math.isfinite, column))
    ]


def _measure_agreement(name: str, result: Result, record: Record, places: list[tuple[int, float]]) -> Agreement:
    computed: list[float] = result[name].tolist()
    values: list[float] = record[name].tolist()
    measured = list(filter(math.isfinite, values))
    apart = {
        time: (1.0 - share) * computed[i] + share * computed[i + 1] - value
        for time, (i, share), value in zip(record.times.tolist(), places, values, strict=True)
        if math.isfinite(value)
    }
    worst = max(apart, key=lambda time: abs(apart[time]))
    return Agreement(
        quantity=name,
        unit=result.unit(name),
        rms=math.sqrt(math.fsum(d * d for d in apart.values()) / len(apart)),
        maximum=abs(apart[worst]),
        time=worst,
        range=max(measured) - min(measured),
    )


def _locate_time(times: list[float], time: float) -> tuple[int, float]:
    i = min(max(bisect_right(times, time) - 1, 0), len(times) - 2)
    share = (time - times[i]) / (times[i + 1] - times[i])
    return i, min(max(share, 0.0), 1.0)


def _refuse_outside(times: list[float], record: Record) -> None:
    first, last, hair = times[0], times[-1], ROUNDING * (times[-1] - times[0])
    if min(record.times) < first - hair or max(record.times) > last + hair:
        raise DataError(
            f"Record `{record.name}` goes from {min(record.times):.6g} to {max(record.times):.6g} s, but the run from "
            f"{first:.6g} to {last:.6g} s; the run must cover the record."
        )


def _list_names(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names if name != "time") or "none but `time`"
