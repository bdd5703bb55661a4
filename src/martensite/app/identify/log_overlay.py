"""Several records in one figure: one axis, one line per record and quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.app.identify.log_kinds import find_experiment
from martensite.app.identify.preparation import interpolate_column
from martensite.app.messages import JsonTable
from martensite.app.views.columns import choose_rows, describe_conversion, describe_display
from martensite.base.errors import ParameterError
from martensite.signals.records import Record

ALIGNED = {"start": "time from the start of each", "clock": "time as each clock counts"}
GRID = 500
"""Points of a line over time."""
DOTS = 250
"""Points of a loop."""
MOST_QUANTITIES = 8


def draw_overlay(records: Sequence[Record], align: str) -> JsonTable:
    """Return the lines of all records; see the call `overlay_logs`."""
    if align not in ALIGNED:
        raise ParameterError(f"Records are aligned by {' or '.join(ALIGNED)}, not by {align!r}.")
    experiment = find_experiment(records)
    axis = experiment.kind.axis if experiment else ""
    loops = bool(axis) and all(axis in one.columns for one in records)
    names = [name for name in dict.fromkeys(n for one in records for n in one.columns) if name not in ("time", axis)]
    lines = _draw_loops(records, axis, names) if loops else _draw_times(records, align, names)
    unit = next(one.units[axis] for one in records) if loops else "s"
    how = describe_display(axis, unit) if loops else describe_conversion("s", "s")
    return {
        "records": [one.name for one in records],
        "axis": {"name": axis if loops else ALIGNED[align], **how},
        "loops": loops,
        **lines,
    }


def _describe_lines(records: Sequence[Record], name: str, lines: list[list[float]]) -> JsonTable:
    unit = next(one.units[name] for one in records if name in one.columns)
    return {"name": name, "lines": lines, **describe_display(name, unit)}


def _draw_times(records: Sequence[Record], align: str, names: Sequence[str]) -> JsonTable:
    zeros = [one.times[0] if align == "start" else 0.0 for one in records]
    begin = min(one.times[0] - zero for one, zero in zip(records, zeros, strict=True))
    end = max(one.times[-1] - zero for one, zero in zip(records, zeros, strict=True))
    x = np.linspace(begin, end, GRID).tolist()
    quantities = [
        _describe_lines(
            records,
            name,
            [
                interpolate_within(one.times, one.columns.get(name, np.full(len(one), np.nan)), [t + zero for t in x])
                for one, zero in zip(records, zeros, strict=True)
            ],
        )
        for name in names[:MOST_QUANTITIES]
    ]
    return {"x": x, "quantities": quantities}


def _draw_loops(records: Sequence[Record], axis: str, names: Sequence[str]) -> JsonTable:
    """Return dots over the driving quantity, since a loop has several values at each."""
    dots = [(one, choose_rows(len(one), DOTS)) for one in records]
    places = sorted((float(one[axis][row]), k, row) for k, (one, rows) in enumerate(dots) for row in rows)
    places = [place for place in places if math.isfinite(place[0])]
    quantities = [
        _describe_lines(
            records,
            name,
            [
                [one[name][row] if k == at and name in one.columns else math.nan for _, k, row in places]
                for at, one in enumerate(records)
            ],
        )
        for name in names[:MOST_QUANTITIES]
    ]
    return {"x": [place[0] for place in places], "quantities": quantities}


def interpolate_within(times: Any, values: Any, wanted: Sequence[float]) -> list[float]:
    """Return linearly interpolated values; NaN outside and next to missing samples."""
    places = np.asarray(wanted, float)
    inside = (places >= times[0]) & (places <= times[-1])
    return np.where(inside, interpolate_column(places, times, values), np.nan).tolist()
