"""A scenario beside a log: what follows which column, what is compared, and what could be free.

{the table as `identify.mapped` takes it, "text": TOML, "follow": {"path": …, "column": …}}
-> {"text": …, "title": …, "refused": "", "drives": […], "numbers": […], "outputs": […],
"records": […], "methods": {…}, "losses": {…}}

Where the scenario cannot be built with the log, `refused` says why, and the rest is what is known.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.identify.asked import scenario_for
from martensite.app.identify.followed import drives_of, following
from martensite.app.identify.mapped import records_of
from martensite.app.identify.numbers import numbers_of
from martensite.app.identify.shown import shown, shown_difference
from martensite.app.messages import wanted
from martensite.app.worker import Desk
from martensite.base.errors import MartensiteError
from martensite.base.files import toml_document
from martensite.fit.compared import columns_of, echoes
from martensite.fit.losses import LOSSES
from martensite.fit.solve import METHODS
from martensite.scenario.assemble import waveform_path
from martensite.scenario.overrides import as_toml
from martensite.scenario.scenario import Scenario
from martensite.signals.records import Record

METHOD_WORDS = {
    "trf": "least squares within bounds, with exact derivatives",
    "coordinate": "one parameter after the other, without derivatives",
    "evolution": "differential evolution over all bounds, then least squares",
}
LOSS_WORDS = {
    "linear": "squares: right where errors are noise",
    "soft-l1": "large errors count less",
    "huber": "large errors count by their size, not its square",
    "cauchy": "very large errors hardly count",
}


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Look at scenario and log together."""
    records = records_of(request, desk)
    text = wanted(request, "text", str)
    document = toml_document(text)
    follow = wanted(request, "follow", dict, {})
    if follow:
        column = wanted(follow, "column", str)
        records[0][column]  # refuses what is none
        path, unit = wanted(follow, "path", str), records[0].units[column]
        document = following(document, path, column, unit)
        text = as_toml(document)
    known = {
        "text": text,
        "drives": drives_of(document),
        "columns": {name: unit for name, unit in records[0].units.items() if name != "time"},
        "records": [one.name for one in records],
        "methods": {name: METHOD_WORDS.get(name, "") for name in METHODS},
        "losses": {name: LOSS_WORDS.get(name, "") for name in LOSSES},
    }
    try:
        scenario = scenario_for({"text": text}, records[0])
    except MartensiteError as error:
        return {**known, "title": "", "refused": str(error), "numbers": [], "outputs": []}
    return {**known, **_built(scenario, records[0]), "drives": _drives(document, scenario)}


def _drives(document: Mapping[str, Any], scenario: Scenario) -> list[dict[str, str]]:
    """What may follow a column, with the column that each follows."""
    section = scenario.places.drive
    followed = {
        waveform_path(scenario.system, name, section).removesuffix("."): column
        for name, column in scenario.follows.items()
    }
    return [one | {"column": followed.get(one["path"], "")} for one in drives_of(document)]


def _built(scenario: Scenario, record: Record) -> dict[str, Any]:
    system = scenario.system
    outputs, refused = list[dict[str, Any]](), ""
    try:
        found, _, notes = columns_of(record, system, (), scenario.follows)
        outputs = [{"name": name, **shown(name, system.outputs()[name].unit)} for name in found]
    except MartensiteError as error:
        refused, notes = str(error), []
    return {
        "title": scenario.title,
        "described": system.described(),
        "refused": refused,
        "follows": scenario.follows,
        "echoes": sorted(echoes(system)),
        "numbers": numbers_of(scenario),
        "outputs": [
            {**one, "difference": shown_difference(one["name"], one["unit"])} for one in outputs
        ],
        "notes": [*notes, *scenario.cautions],
    }
