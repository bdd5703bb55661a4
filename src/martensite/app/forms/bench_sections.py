"""Sections of a form beside the system: what measures and controls it, and the run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from martensite.app.forms import controls, documents
from martensite.app.forms.control_tree import ControlWalk, Paths, build_group, join_path
from martensite.app.forms.controls import EntrySpot
from martensite.app.forms.form_types import FormNode, GroupNode
from martensite.base.parameters import REQUIRED, Declared, Parametrised
from martensite.scenario.scenario import Run, Scenario
from martensite.scenario.sections import BENCH, PERIOD, RUN, SUPERVISOR

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

SECTION_TITLE = "Control and sensing"
TITLE_ENTRY = Declared("text", "what the scenario is called", REQUIRED)


def describe_bench(scenario: Scenario, walk: ControlWalk) -> Iterator[GroupNode]:
    """Everything around the system, if there is anything."""
    bench = scenario.bench
    if bench is None:
        return
    items = _list_settings(scenario, walk, bench)
    for name in ("sensors", "observers", "controllers", "faults"):
        for key, one in getattr(bench, name).members().items():
            items.append(_describe_part(walk, one, f"{name}.{key}", f"{name[:-1]} {key}"))
    for name, one in scenario.outside.items():
        items.append(_describe_part(walk, one, f"controllers.{name}", f"controller of {name}"))
    if bench.supervisor is not None:
        items.append(_describe_part(walk, bench.supervisor, SUPERVISOR, SUPERVISOR))
    yield build_group(BENCH, SECTION_TITLE, items)


def _describe_part(walk: ControlWalk, part: Parametrised, path: str, title: str) -> GroupNode:
    """A part by its name; the kind of a sensor is that of what is mounted."""
    from martensite.scenario.catalogue import list_registries

    name = path.partition(".")[0].removesuffix("s")
    return walk.group(part, path, title, "", None if name == "sensor" else list_registries()[name])


def _list_settings(scenario: Scenario, walk: ControlWalk, bench: Bench) -> list[FormNode]:
    """How the bench runs; its period may stand in another section."""
    from martensite.scenario.bench import BenchSettings

    table = documents.find_table(walk.document, BENCH)
    given = {name: value for name, value in table.items() if name in BenchSettings.declarations}
    whole = BenchSettings(**{**given, PERIOD: bench.period})
    return _list_controls(walk, whole, partial(_place_setting, scenario.places.path(PERIOD)))


def _place_setting(period: str, path: str) -> str:
    return period if path == PERIOD else join_path(f"{BENCH}.", path)


def describe_run(scenario: Scenario, walk: ControlWalk) -> GroupNode:
    """How long, how accurately, how many samples; and the title."""
    table = documents.find_table(walk.document, RUN)
    values = Run(**{name: value for name, value in table.items() if name in Run.declarations})
    spot = EntrySpot("title", "title", TITLE_ENTRY, "scenario")
    items = _list_controls(walk, values, partial(join_path, f"{RUN}."))
    return build_group(RUN, "Run", [*items, controls.describe_text(spot, scenario.title)])


def _list_controls(walk: ControlWalk, part: Parametrised, place: Paths) -> list[FormNode]:
    """Controls of a component that the scenario has not kept."""
    own = replace(walk, written=place, noted=place, unit=lambda leaf: leaf.declared.unit, skipped=lambda path: False)
    return own.group(part, "", "")["items"]
