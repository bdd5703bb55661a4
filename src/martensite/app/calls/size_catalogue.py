"""The model beside the maker's table of wires. Long work; stopped, it ends with the rows so far.

{"fields": {"stress": …, "ambient": …, "alloy": …}} -> {"columns": […], "rows": [[…]], …}

Notes: {"done": rows, "of": rows}.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.calls._sizing import read, typed
from martensite.app.worker import Desk
from martensite.base.errors import ParameterError
from martensite.design.sizing.catalogue_check import AMBIENT, STRESS, check_catalogue
from martensite.design.sizing.request import ALLOYS
from martensite.show.reports import catalogue_check as words

FIELDS = ("stress", "ambient", "alloy")


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Predict every row."""
    given = {name: text for name, text in typed(request).items() if name in FIELDS}
    found, refused = read(given)
    if refused:
        raise ParameterError(" ".join(refused.values()))
    alloy = found.get("alloy", "any")
    stress, ambient = found.get("stress", STRESS), found.get("ambient", AMBIENT)
    rows = check_catalogue(
        alloys=ALLOYS if alloy == "any" else (alloy,),
        stress=stress,
        ambient=ambient,
        progress=lambda done, of: desk.tell({"done": done, "of": of}),
        stop=desk.stop.is_set,
    )
    return {
        "asked": given,
        "conditions": words.conditions(stress, ambient),
        "columns": [" ".join(name.split("\n")).strip() for name in words.COLUMNS],
        "rows": [words.cells(row) for row in rows],
        "spread": words.spread_sentences(rows),
        "doubt": words.DOUBT,
    }
