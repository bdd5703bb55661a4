"""The scenario of one run of a sweep, with exactly its numbers.

{"key": …, "row": 12} -> {"text": TOML, "values": [SI], "status": …}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.gallery import built
from martensite.app.messages import wanted
from martensite.app.sweeping.shelf import Shelf
from martensite.app.sweeping.stored import asked_of, scenario_in
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.design.sweep.job import plan_of
from martensite.design.sweep.store import Store
from martensite.scenario.exact_text import exact_text


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Put the numbers of a run into the scenario of its sweep; it need not be made yet."""
    spec = Store(Shelf(desk.folder).path(wanted(request, "key", str))).spec
    row = wanted(request, "row", int)
    plan = plan_of(scenario_in(spec), asked_of(spec))
    if not 0 <= row < plan.size:
        raise DataError(f"There is no run {row} in this sweep of {plan.size:,} runs.")
    values = plan.values(range(row, row + 1))[0].tolist()
    changes = {
        one.target.name: exact_text(value, one.target.unit)
        for one, value in zip(plan.axes, values, strict=True)
    }
    scenario = built(spec["scenario"], changes)
    return {"text": scenario.text, "values": values, "changes": changes}
