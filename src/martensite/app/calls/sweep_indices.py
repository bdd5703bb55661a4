"""How much of the variance of a measure every varied number explains.

{"key": …, "measure": "stroke"}
-> {"method", "used", "names": […], "indices": {kind: {"values": […], "wide": […]}}, "remarks"}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.messages import wanted
from martensite.app.sweeping.shelf import Shelf
from martensite.app.worker import Desk
from martensite.design.sweep.indices import sensitivity
from martensite.design.sweep.reading import read_sweep


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Estimate the indices of one measure."""
    table = read_sweep(Shelf(desk.folder).path(wanted(request, "key", str)))
    (found,) = sensitivity(table, [wanted(request, "measure", str)])
    kinds = found.indices if found.deviation else {}
    return {
        "measure": found.measure,
        "method": found.method,
        "used": found.used,
        "names": [found.names[k] for k in found.order],
        "indices": {
            kind: {"values": one.values[found.order], "wide": one.wide[found.order]}
            for kind, one in kinds.items()
        },
        "remarks": found.remarks,
    }
