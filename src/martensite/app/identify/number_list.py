"""All numbers of a scenario that could be free, with what is declared about each."""

from __future__ import annotations

import math
from collections.abc import Iterator

from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_conversion
from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.base.parameters import Leaf
from martensite.fit.free_parameters import build_free_numbers
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import SearchRange


def list_numbers(scenario: Scenario) -> list[JsonTable]:
    """One entry per number, or per numbers of one name and value, which then move together."""
    leaves = [leaf for leaf in scenario.system.leaves() if _can_be_free(leaf)]
    endings: dict[str, list[Leaf]] = {}
    for leaf in leaves:
        endings.setdefault(leaf.path.rpartition(".")[2], []).append(leaf)
    return [entry for name, group in endings.items() for entry in _list_entries(scenario, name, group)]


def _can_be_free(leaf: Leaf) -> bool:
    return leaf.declared.unit not in units.OF_READINGS and math.isfinite(leaf.value)


def _list_entries(scenario: Scenario, name: str, group: list[Leaf]) -> Iterator[JsonTable]:
    if len({(leaf.value, leaf.declared.unit) for leaf in group}) == 1:
        yield _describe_entry(scenario, name, group)
    else:
        yield from (_describe_entry(scenario, leaf.path, [leaf]) for leaf in group)


def _describe_entry(scenario: Scenario, name: str, group: list[Leaf]) -> JsonTable:
    leaf = group[0]
    path, declared = scenario.places.path(leaf.path), leaf.declared
    spelling = units.choose_familiar_unit(leaf.value, declared.unit)
    low, high = _find_bounds(scenario, name)
    return {
        "name": name,
        "group": path.rpartition(".")[0],
        "places": len(group),
        "value": leaf.value,
        "low": low,
        "high": high,
        "allowed": declared.allowed(),
        "doc": declared.doc,
        "origin": scenario.origins.get(path, ""),
        **describe_conversion(declared.unit, spelling),
    }


def _find_bounds(scenario: Scenario, name: str) -> tuple[float | None, float | None]:
    """The bounds that a fit would choose; none where it has to be told."""
    try:
        (free,) = build_free_numbers([SearchRange(name)], [scenario.system])
    except ParameterError:
        return None, None
    return free.low, free.high
