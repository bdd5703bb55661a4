"""The form of a sweep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.util import find_spec

from martensite.app.documents import read_request_scenario
from martensite.app.messages import JsonTable, Request
from martensite.app.worker import Desk
from martensite.base import units
from martensite.base.errors import MartensiteError
from martensite.base.parameters import Declared
from martensite.design.backends.processes import count_cores
from martensite.design.sampling.samples import DESIGNS
from martensite.design.sweep.job import MEASURES as USUAL
from martensite.design.sweep.store import import_zarr
from martensite.design.sweep.subject import list_targets, list_waveforms
from martensite.scenario.catalogue import summarise_class
from martensite.scenario.exact_text import exact_text
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import Target
from martensite.simulate.measures.base import MEASURES, AbstractMeasure, parse_measure
from martensite.simulate.variants import RUNTIMES


def describe_sweep_form(request: Request, desk: Desk) -> JsonTable:
    """What can be asked of a sweep of a scenario: its numbers, samples, and measures.

    {"text": TOML} -> {"title", "targets": […], "designs": […], "measures": […], "outputs": […], …}
    """
    scenario = read_request_scenario(request, desk)
    return {
        "title": scenario.title,
        "text": scenario.text,
        "missing": _find_missing_extra(),
        "targets": list(_list_targets(scenario)),
        "designs": [{"name": n, "about": summarise_class(DESIGNS[n])} for n in _sort_grid_first(DESIGNS.names())],
        "measures": [_describe_measure(name, scenario) for name in MEASURES.names()],
        "outputs": [
            {"name": name, "about": one.long_name, "unit": units.choose_readable_unit(one.unit)}
            for name, one in scenario.whole.outputs().items()
        ],
        "usual": list(USUAL),
        "runtimes": list(RUNTIMES),
        "cores": count_cores(),
    }


def _find_missing_extra() -> str:
    """The sentence on what must be installed first; empty if nothing."""
    if find_spec("zarr") is not None:
        return ""
    try:
        import_zarr()
    except MartensiteError as error:
        return str(error)
    return ""


def _sort_grid_first(names: list[str]) -> list[str]:
    return sorted(names, key=lambda name: (name != "grid", name))


def _list_targets(scenario: Scenario) -> Iterator[JsonTable]:
    """Numbers that can be varied: value and bounds in a unit that people read."""
    leaves: dict[str | None, dict[str, Declared]] = {None: {one.path: one.declared for one in scenario.whole.leaves()}}
    for name, wave in list_waveforms(scenario).items():
        leaves[name] = {one.path: one.declared for one in wave.leaves()}
    for target in list_targets(scenario).values():
        yield _describe_target(target, leaves[target.drive][target.path])


def _describe_target(one: Target, declared: Declared) -> JsonTable:
    shown = units.choose_familiar_unit(one.value, one.unit)
    same = declared.unit == one.unit
    low, high = (declared.low, declared.high) if same else (-math.inf, math.inf)
    return {
        "name": one.name,
        "about": one.doc,
        "unit": "" if shown == "1" else shown,
        "value": units.from_si(one.value, shown, one.unit),
        "words": exact_text(one.value, one.unit),
        "low": units.from_si(low, shown, one.unit),
        "high": units.from_si(high, shown, one.unit),
        "open": declared.open_low,
    }


def _describe_measure(name: str, scenario: Scenario) -> JsonTable:
    """A measure: whether it needs an output, or stands alone."""
    kind = MEASURES[name]
    alone = True
    try:
        parse_measure(name).columns(scenario.whole)
    except MartensiteError:
        alone = False
    return {"name": name, "about": summarise_class(kind), "alone": alone, "usual": _find_usual(name, kind)}


def _find_usual(name: str, kind: type[AbstractMeasure]) -> str:
    """What is looked at if nothing is named."""
    return str(kind.declarations["of"].default or "the first coordinate")
