"""The map of a sizing: feasible wires for forces and strokes around a request."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from martensite.app.calls.sizing import read_fields, read_request
from martensite.app.messages import JsonTable, Request
from martensite.app.worker import Desk
from martensite.design.sizing.candidates import Candidate, judge_candidate, list_sizes, rank_candidates
from martensite.design.sizing.request import WireRequest
from martensite.physics.materials.wires import WireCatalogue, WireSize, load_wires

SPAN = 4.0
"""Largest ratio of forces and strokes to the request."""
FORCES, STROKES = 9, 5
TOO_SLOW = 1.5
"""Return time of a wire that is not simulated again, in periods."""


def list_levels(middle: float, count: int) -> list[float]:
    """Return logarithmically spaced levels around a value."""
    return [middle * SPAN ** (2.0 * k / (count - 1) - 1.0) for k in range(count)]


def list_cells() -> list[tuple[int, int]]:
    """Return columns and rows of the map, from its centre outwards."""
    middle = ((FORCES - 1) / 2, (STROKES - 1) / 2)
    return sorted(product(range(FORCES), range(STROKES)), key=lambda cell: math.dist(cell, middle))


@dataclass
class _Jury:
    """Judge of all wires, which uses the results of earlier cells.

    Force and stroke hardly change the current of a strand and its time of return: the current is the next guess, and a
    wire that is far too slow is not simulated again.
    """

    catalogue: WireCatalogue
    currents: dict[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    slow: dict[tuple[str, str], Candidate] = field(default_factory=dict[tuple[str, str], Candidate])

    def judge_all(self, cell_wish: WireRequest) -> Iterator[Candidate]:
        """Yield every size and alloy, judged."""
        for alloy in cell_wish.alloys():
            for size in list_sizes(cell_wish, self.catalogue):
                yield self._judge(cell_wish, size, alloy)

    def _judge(self, cell_wish: WireRequest, size: WireSize, alloy: str) -> Candidate:
        key = size.name, alloy
        if key in self.slow:
            return self.slow[key]
        candidate = judge_candidate(cell_wish, size, alloy, self.currents.get(key))
        if candidate.cycle is not None:
            self.currents[key] = candidate.cycle.current
            if candidate.cycle.cooling is None or candidate.cycle.cooling > TOO_SLOW * cell_wish.period:
                self.slow[key] = candidate
        return candidate


def map_wishes(request: Request, desk: Desk) -> JsonTable:
    """Assess all wires for forces and strokes around a request. Long work; after a stop it returns the finished cells.

    {"fields": {"force": "8 N", …}} -> {"asked": {…}, "forces": [N], "strokes": [m], "cells": [{…}]}

    Notes: {"done": cells, "of": cells, "cell": the newest}, from the centre outwards.
    """
    wish, catalogue = read_request(request), load_wires()
    forces, strokes = list_levels(wish.force, FORCES), list_levels(wish.stroke, STROKES)
    places = list_cells()
    entries: list[JsonTable] = []
    jury = _Jury(catalogue)
    desk.tell({"done": 0, "of": len(places), "cell": None, "forces": forces, "strokes": strokes})
    for column, row in places:
        if desk.stop.is_set():
            break
        cell_wish = wish.with_values({"force": forces[column], "stroke": strokes[row]})
        entries.append({"column": column, "row": row, **_describe_cell(cell_wish, jury)})
        desk.tell({"done": len(entries), "of": len(places), "cell": entries[-1], "forces": forces, "strokes": strokes})
    return {"asked": read_fields(request), "forces": forces, "strokes": strokes, "cells": entries, "of": len(places)}


def _describe_cell(cell_wish: WireRequest, jury: _Jury) -> JsonTable:
    """Return the numbers of feasible and robust wires, the best wire, or the reason against the nearest."""
    candidates = sorted(jury.judge_all(cell_wish), key=rank_candidates)
    good = [one for one in candidates if one.feasible]
    return {
        "does": len(good),
        "robust": sum(not one.frail for one in good),
        "best": _name_candidate(good[0]) if good else None,
        "reason": "" if good else f"{candidates[0].size.name}, {candidates[0].alloy} °C: {candidates[0].reasons[0]}",
    }


def _name_candidate(candidate: Candidate) -> dict[str, Any]:
    return {"size": candidate.size.name, "alloy": candidate.alloy, "count": int(candidate.statics.count)}
