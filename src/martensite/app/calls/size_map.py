"""The map of a sizing: what does for forces and strokes around a wish."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import Any

from martensite.app.calls.sizing import read_fields, read_request
from martensite.app.messages import JsonTable, Request
from martensite.app.worker import Desk
from martensite.design.sizing.candidates import Candidate, judge_candidate, list_sizes, rank_candidates
from martensite.design.sizing.request import WireRequest
from martensite.physics.materials.wires import WireCatalogue, load_wires

SPAN = 4.0
"""The map reaches from a fourth of the wish to four times of it."""
FORCES, STROKES = 9, 7


def list_levels(middle: float, count: int) -> list[float]:
    """Return the levels around a number, equally far from one another in the logarithm."""
    return [middle * SPAN ** (2.0 * k / (count - 1) - 1.0) for k in range(count)]


def list_cells() -> list[tuple[int, int]]:
    """Return the columns and rows of the map, the wish first, then outwards."""
    middle = ((FORCES - 1) / 2, (STROKES - 1) / 2)
    return sorted(product(range(FORCES), range(STROKES)), key=lambda cell: math.dist(cell, middle))


def map_wishes(request: Request, desk: Desk) -> JsonTable:
    """Judge every wire for forces and strokes around a wish. Long work; stopped, it ends with the cells that are there.

    {"fields": {"force": "8 N", …}} -> {"asked": {…}, "forces": [N], "strokes": [m], "cells": [{…}]}

    Notes: {"done": cells, "of": cells, "cell": the newest}, the wish first, then outwards.
    """
    wish, catalogue = read_request(request), load_wires()
    forces, strokes = list_levels(wish.force, FORCES), list_levels(wish.stroke, STROKES)
    places = list_cells()
    found: list[JsonTable] = []
    desk.tell({"done": 0, "of": len(places), "cell": None, "forces": forces, "strokes": strokes})
    for column, row in places:
        if desk.stop.is_set():
            break
        asked = wish.with_values({"force": forces[column], "stroke": strokes[row]})
        found.append({"column": column, "row": row, **_describe_cell(asked, catalogue)})
        desk.tell({"done": len(found), "of": len(places), "cell": found[-1], "forces": forces, "strokes": strokes})
    return {"asked": read_fields(request), "forces": forces, "strokes": strokes, "cells": found, "of": len(places)}


def _describe_cell(asked: WireRequest, catalogue: WireCatalogue) -> JsonTable:
    """Return the numbers of feasible and robust wires, the best wire, or the reason against the nearest."""
    found = sorted(_judge_all(asked, catalogue), key=rank_candidates)
    good = [one for one in found if one.feasible]
    return {
        "does": len(good),
        "robust": sum(not one.frail for one in good),
        "best": _name_candidate(good[0]) if good else None,
        "reason": "" if good else f"{found[0].size.name}, {found[0].alloy} °C: {found[0].reasons[0]}",
    }


def _judge_all(asked: WireRequest, catalogue: WireCatalogue) -> Iterator[Candidate]:
    sizes = list_sizes(asked, catalogue)
    return (judge_candidate(asked, size, alloy) for alloy in asked.alloys() for size in sizes)


def _name_candidate(found: Candidate) -> dict[str, Any]:
    return {"size": found.size.name, "alloy": found.alloy, "count": int(found.statics.count)}
