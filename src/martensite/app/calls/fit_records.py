"""The columns of a mapped table over time, to be looked at and cut.

{"key": …, "columns": [{at, name, unit}], "interval": null, "drop": false, "cuts": [] }
-> {"begin": 0, "end": …, "rows": …, "columns": [{name, times, values, unit, shown, …}], "cuts":
[{name, rows, refused}]}: curves thinned so that lows and highs stay; times in s, values in SI.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from martensite.app.identify.mapped import cuts_told, record_of
from martensite.app.identify.shown import shown
from martensite.app.identify.thin import envelope
from martensite.app.worker import Desk

DRAWN = 800


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Read the table with its columns mapped."""
    record = record_of(request, desk)
    columns: list[dict[str, Any]] = []
    for name, column in record.columns.items():
        if name == "time":
            continue
        rows = envelope(column, DRAWN)
        columns.append(
            {
                "name": name,
                "times": [record.times[row] for row in rows],
                "values": [column[row] for row in rows],
                "missing": sum(map(math.isnan, column)),
                **shown(name, record.units[name]),
            }
        )
    return {
        "begin": record.times[0],
        "end": record.times[-1],
        "rows": len(record),
        "dropped": record.dropped,
        "columns": columns,
        "cuts": cuts_told(request, desk),
    }
