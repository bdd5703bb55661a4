"""The runs of a sweep that no other beats, as far as it is made.

{"key": …, "minimise": ["energy"], "maximise": ["stroke"]}
-> {"rows": […], "values": {name: [SI]}, "compared": …, "left_out": [[number, "why"]], "why": …}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.messages import BadMessageError, wanted
from martensite.app.sweeping.shelf import Shelf
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.design.sweep.pareto import pareto_front
from martensite.design.sweep.reading import read_sweep

MOST = 2000
"""Runs of a front that are listed."""
NONE: Mapping[str, Any] = {"rows": [], "values": {}, "count": 0, "compared": 0, "left_out": []}


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Find the front."""
    table = read_sweep(Shelf(desk.folder).path(wanted(request, "key", str)))
    try:
        front = pareto_front(table, _names(request, "minimise"), _names(request, "maximise"))
    except DataError as error:  # as long as no run is there
        return {**NONE, "why": str(error)}
    never = len(table.status) - table.missing - table.failed - front.compared
    counts = (
        (table.missing, "not made yet"),
        (table.failed, "failed"),
        (never, "what is wanted never happened"),
    )
    runs = front.runs[:: max(-(-len(front.runs) // MOST), 1)]
    return {
        "rows": runs.tolist(),
        "values": {name: one.values[runs].tolist() for name, one in front.columns(table).items()},
        "count": len(front.runs),
        "compared": front.compared,
        "left_out": [[count, why] for count, why in counts if count],
        "why": "",
    }


def _names(request: Mapping[str, Any], name: str) -> list[str]:
    given = wanted(request, name, list, [])
    if not all(isinstance(one, str) for one in given):
        raise BadMessageError(f"`{name}` must be a list of texts.")
    return given
