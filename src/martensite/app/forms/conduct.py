"""Sections of a form beside the system: what measures and controls it, and the run."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from martensite.app.forms import controls, documents
from martensite.app.forms.controls import Control, Spot
from martensite.app.forms.tree import Paths, Walk, bare, below
from martensite.base.parameters import REQUIRED, Declared, Parametrised
from martensite.scenario.scenario import Run, Scenario
from martensite.scenario.sections import BENCH, PERIOD, RUN, SUPERVISOR

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

CONTROL = "Control and sensing"
TITLE = Declared("text", "what the scenario is called", REQUIRED)


def bench_section(scenario: Scenario, walk: Walk) -> Iterator[Control]:
    """Everything around the system, if there is anything."""
    bench = scenario.bench
    if bench is None:
        return
    items = _bench_itself(scenario, walk, bench)
    for name in ("sensors", "observers", "controllers", "faults"):
        for key, one in getattr(bench, name).members().items():
            items.append(_chosen(walk, one, f"{name}.{key}", f"{name[:-1]} {key}"))
    for name, one in scenario.outside.items():
        items.append(_chosen(walk, one, f"controllers.{name}", f"controller of {name}"))
    if bench.supervisor is not None:
        items.append(_chosen(walk, bench.supervisor, SUPERVISOR, SUPERVISOR))
    yield {**bare(BENCH, CONTROL), "items": items}


def _chosen(walk: Walk, part: Parametrised, path: str, title: str) -> Control:
    """A part by its name; the kind of a sensor is that of what is mounted."""
    from martensite.scenario.catalogue import list_registries

    name = path.partition(".")[0].removesuffix("s")
    return walk.group(part, path, title, "", None if name == "sensor" else list_registries()[name])


def _bench_itself(scenario: Scenario, walk: Walk, bench: Bench) -> list[Control]:
    """How the bench runs; its period may stand in another section."""
    from martensite.scenario.bench import BenchSettings

    table = documents.table(walk.document, BENCH)
    given = {name: value for name, value in table.items() if name in BenchSettings.declarations}
    whole = BenchSettings(**{**given, PERIOD: bench.period})
    return _component(walk, whole, partial(_conduct_path, scenario.places.path(PERIOD)))


def _conduct_path(period: str, path: str) -> str:
    return period if path == PERIOD else below(f"{BENCH}.", path)


def run_section(scenario: Scenario, walk: Walk) -> Control:
    """How long, how accurately, how many samples; and the title."""
    table = documents.table(walk.document, RUN)
    values = Run(**{name: value for name, value in table.items() if name in Run.declarations})
    spot = Spot("title", "title", TITLE, "scenario")
    items = _component(walk, values, partial(below, f"{RUN}."))
    return {**bare(RUN, "Run"), "items": [*items, controls.text(spot, scenario.title)]}


def _component(walk: Walk, part: Parametrised, place: Paths) -> list[Any]:
    """Controls of a component that the scenario has not kept."""
    own = Walk(
        walk.document, walk.origins, place, place, lambda leaf: leaf.declared.unit, seen=walk.seen
    )
    return own.group(part, "", "")["items"]
