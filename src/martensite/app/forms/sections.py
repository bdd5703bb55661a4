"""The sections of a form: element, environment, mechanism, drive, actuators, bench, run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.mechanisms.base import MECHANISMS
from martensite.app.forms import controls, documents
from martensite.app.forms.control_tree import ControlWalk, Paths, build_group, flatten_controls, join_path, place_units
from martensite.app.forms.controls import EntrySpot
from martensite.app.forms.form_types import FormNode, GroupNode, MaterialNode, ScenarioForm, SingleNode
from martensite.base.files import toml_document
from martensite.base.parameters import REQUIRED, FieldDeclaration, Parametrised
from martensite.physics.electrical.base import SOURCES
from martensite.physics.materials.base import load_material, material_names
from martensite.scenario.assemble import GROUP, MODEL, SIGNALS, scenario_path, waveform_path
from martensite.scenario.catalogue import list_named, list_registries
from martensite.scenario.run_section import Run
from martensite.scenario.scenario import Scenario
from martensite.scenario.sections import BENCH, PERIOD, RUN, SUPERVISOR
from martensite.signals.base import WAVEFORMS
from martensite.simulate.drive_waveforms import by_name

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

MATERIAL = "element.material"
NO_MATERIAL = ""
COOLING = "environment.cooling"
ELEMENT, ENVIRONMENT, MECHANISM, SUPPLY, DRIVE, ACTUATORS = (
    "Material and element",
    "Environment",
    "Mechanism",
    "Supply",
    "Drive",
    "Actuators",
)
CONTROL = "Control and sensing"
TITLE_ENTRY = FieldDeclaration("text", "what the scenario is called", REQUIRED)


def describe_scenario(scenario: Scenario) -> ScenarioForm:
    """Return the form of a scenario."""
    return {
        "text": scenario.text,
        "title": scenario.title,
        "sections": FormSections(scenario).all(),
        "registries": {kind: list_named(one) for kind, one in list_registries().items()},
        "notes": [],
        "assumed": [],
        "missing": [],
        "refused": "",
    }


class FormSections:
    """Builder of the form of a scenario."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.document = toml_document(scenario.text)
        self.prefix = "plant." if scenario.bench is not None else ""
        places = scenario.places
        self.walk = ControlWalk(
            self.document, scenario.origins, places.path, places.path, places.unit, is_skipped=places.is_copy
        )

    def all(self) -> list[GroupNode]:
        """Return all sections."""
        if MODEL in self.document:
            sections = [self._model(), self._drive_alone()]
        else:
            driven = [self._drive()] if self.scenario.system.actuators() else []
            sections = [*self._actuator(), *self._mechanism(), *driven, *self._actuators()]
        loops = describe_bench(self.scenario, self.walk)
        return [*sections, *loops, describe_run(self.scenario, self.walk)]

    def _actuator(self) -> Iterator[GroupNode]:
        if not self.scenario.system.actuators():
            return  # a mechanism alone, such as a beam with its motor
        port, common = self._describe_common()
        element = common.group(
            port.element, f"{self._port_prefix}element", "element", "what is made of the alloy", ELEMENTS
        )
        items: list[FormNode] = [self._material(), *element["items"]]
        yield {**element, "title": ELEMENT, "items": items, "note": self._shared_note}
        yield self._environment(port, replace(common, material=None))

    def _mechanism(self) -> Iterator[GroupNode]:
        system = self.scenario.system
        yield {
            **self.walk.group(system.mechanism, f"{self.prefix}mechanism", MECHANISM, "what it pulls on", MECHANISMS),
            "title": MECHANISM,
        }
        if (supply := getattr(system, "supply", None)) is not None:
            yield {**self.walk.group(supply, f"{self.prefix}supply", SUPPLY, "what all sources share"), "title": SUPPLY}

    def _environment(self, port: Any, walk: ControlWalk) -> GroupNode:
        """Return the environment; a drive that sets the temperature needs no heat-loss model."""
        node = walk.group(port.environment, f"{self._port_prefix}environment", ENVIRONMENT)
        node["note"] = self._shared_note
        idle = documents.find_entry(self.document, COOLING) is None
        if port.source.sets_temperature and idle:
            node["items"] = [one for one in node["items"] if one["path"] != COOLING]
            node["note"] = "The drive sets the temperature: no heat balance is solved."
        return node

    @property
    def _port_prefix(self) -> str:
        return "" if self._has_ports else self.prefix

    @property
    def _has_ports(self) -> bool:
        return hasattr(self.scenario.system, "group")

    @property
    def _shared_note(self) -> str:
        return "The same at every port; [actuators] says what is different." if (self._has_ports) else ""

    def _describe_common(self) -> tuple[Any, ControlWalk]:
        """Return an actuator and the walk of the common sections.

        For several ports it is the actuator with the fewest settings of its port.
        """
        actuators = self.scenario.system.actuators()
        own = documents.find_table(self.document, GROUP)
        drive = self.scenario.places.drive
        if not self._has_ports:
            element = next(iter(actuators.values()))
            return element, replace(self.walk, material=self.scenario.material)
        port = min(actuators, key=lambda name: len(_list_paths(own.get(name, {}), drive)))
        different = set(_list_paths(own.get(port, {}), drive))
        walk = replace(
            self.walk,
            document_path=lambda path: scenario_path(path, drive),
            origin_path=lambda path: scenario_path(f"group.{port}.{path}", drive),
            unit=lambda leaf: leaf.declared.unit,
            material=self.scenario.material,
            is_skipped=lambda path: False,
            paths_with_control=different,
        )
        return actuators[port], walk

    def _material(self) -> MaterialNode:
        given = documents.find_entry(self.document, MATERIAL)
        materials = _list_materials()
        own = {} if given is None or given in materials else {given: "a file of your own"}
        declared = FieldDeclaration("option", "where numbers come from that the scenario leaves out", "")
        spot = EntrySpot(MATERIAL, "material", declared, "default" if given is None else "scenario")
        names = {NO_MATERIAL: "none: every number is given here", **materials, **own}
        material = self.scenario.material
        return {
            **spot.common(),
            "sort": "material",
            "value": given or NO_MATERIAL,
            "materials": [{"name": name, "summary": about} for name, about in names.items()],
            "about": "" if material is None else material.summary,
            "limits": "" if material is None else material.limits,
        }

    def _drive(self) -> GroupNode:
        port, common = self._describe_common()
        group = replace(common, material=None).group(
            port.source, f"{self._port_prefix}source", DRIVE, "what heats the element", SOURCES
        )
        name = self.scenario.places.drive
        node: GroupNode = {**group, "path": name, "title": DRIVE, "note": self._shared_note}
        if node["kind"]:
            spot = self.walk.spots.pop(node["kind"]["path"])
            node["kind"]["path"] = f"{name}.kind"
            self.walk.spots[f"{name}.kind"] = spot
        if not self._has_ports:
            node["items"] += self._waveforms()
        return node

    def _drive_alone(self) -> GroupNode:
        return build_group(self.scenario.places.drive, DRIVE, list(self._waveforms()))

    def _waveforms(self, only: str | None = None) -> Iterator[GroupNode]:
        system, scenario = self.scenario.system, self.scenario
        units = {drive.name: drive.unit for drive in system.drives()}
        for name, waveform in by_name(system, scenario.waveform).items():
            if only not in (None, name):
                continue
            begin = self._begin(name)
            place = partial(join_path, begin)
            unit = place_units(units[name])
            walk = replace(self.walk, document_path=place, origin_path=place, unit=unit, is_skipped=lambda path: False)
            signal = begin.startswith(SIGNALS)
            yield walk.group(waveform, "", f"signal {name}" if signal else "waveform", f"in {units[name]}", WAVEFORMS)

    def _begin(self, name: str) -> str:
        """Return the path of a drive's waveform; a model of one input can have it in [drive]."""
        drive = self.scenario.places.drive
        path = waveform_path(self.scenario.system, name, drive)
        there = documents.find_entry(self.document, path.removesuffix(".")) is not None
        return path if there or MODEL not in self.document else f"{drive}.waveform."

    def _actuators(self) -> Iterator[GroupNode]:
        if not self._has_ports:
            return
        node = build_group(GROUP, ACTUATORS, note="Settings of each port.")
        system, drive = self.scenario.system, self.scenario.places.drive
        for port, actuator in system.actuators().items():
            place = f"{GROUP}.{port}"
            group = build_group(place, port.replace("_", " "), list(self._waveforms(port)))
            own = set(_list_paths(documents.find_table(self.document, place), drive))
            group["items"] += self._describe_different(port, actuator, own)
            if group["items"]:
                node["items"].append(group)
        signals = [n for n in system.signals() if n in by_name(system, self.scenario.waveform)]
        node["items"] += [one for name in signals for one in self._waveforms(name)]
        if node["items"]:
            yield node

    def _describe_different(self, port: str, actuator: Parametrised, own: set[str]) -> list[SingleNode]:
        begin, drive = f"{GROUP}.{port}.", self.scenario.places.drive
        place = partial(_is_member, port, drive)
        walk = replace(
            self.walk,
            document_path=place,
            origin_path=place,
            material=self.scenario.material,
            unit=lambda leaf: leaf.declared.unit,
        )
        items = walk.group(actuator, "", port)["items"]
        return [one for one in flatten_controls(items) if one["path"].removeprefix(begin) in own]

    def _model(self) -> GroupNode:
        file = documents.find_entry(self.document, f"{MODEL}.file")
        note = f"A model of blocks from the file `{file}`: its parameters are in the file."
        return build_group(MODEL, "Model", note=note)


@cache
def _list_materials() -> dict[str, str]:
    return {name: load_material(name).title for name in material_names()}


def _is_member(port: str, drive: str, path: str) -> str:
    return scenario_path(f"group.{port}.{path}", drive) if path else f"{GROUP}.{port}"


def _list_paths(table: Any, drive: str, prefix: str = "") -> list[str]:
    entries: list[str] = []
    for key, value in table.items() if isinstance(table, dict) else ():
        path = f"{prefix}{key}"
        if path == f"{drive}.waveform":
            continue
        entries += _list_paths(value, drive, f"{path}.") if isinstance(value, dict) else [path]
    return entries


def describe_bench(scenario: Scenario, walk: ControlWalk) -> Iterator[GroupNode]:
    """Yield the section around the system, if any."""
    bench = scenario.bench
    if bench is None:
        return
    items = _list_settings(scenario, walk, bench)
    for name in ("sensors", "observers", "controllers", "faults"):
        for key, one in getattr(bench, name).members().items():
            items.append(_describe_part(walk, one, f"{name}.{key}", f"{name[:-1]} {key}"))
    if bench.supervisor is not None:
        items.append(_describe_part(walk, bench.supervisor, SUPERVISOR, SUPERVISOR))
    yield build_group(BENCH, CONTROL, items)


def _describe_part(walk: ControlWalk, part: Parametrised, path: str, title: str) -> GroupNode:
    from martensite.scenario.catalogue import list_registries

    name = path.partition(".")[0].removesuffix("s")
    return walk.group(part, path, title, "", None if name == "sensor" else list_registries()[name])


def _list_settings(scenario: Scenario, walk: ControlWalk, bench: Bench) -> list[FormNode]:
    """Return the settings of the bench; its period can be in another section."""
    from martensite.scenario.bench import BenchSettings

    table = documents.find_table(walk.document, BENCH)
    given: dict[str, Any] = {name: value for name, value in table.items() if name in BenchSettings.declarations}
    given[PERIOD] = bench.period
    whole = BenchSettings(**given)
    return _list_controls(walk, whole, partial(_place_setting, scenario.places.path(PERIOD)))


def _place_setting(period: str, path: str) -> str:
    return period if path == PERIOD else join_path(f"{BENCH}.", path)


def describe_run(scenario: Scenario, walk: ControlWalk) -> GroupNode:
    """Return the form of a run: duration, tolerance, samples, and the title."""
    table = documents.find_table(walk.document, RUN)
    values = Run(**{name: value for name, value in table.items() if name in Run.declarations})
    spot = EntrySpot("title", "title", TITLE_ENTRY, "scenario")
    items = _list_controls(walk, values, partial(join_path, f"{RUN}."))
    return build_group(RUN, "Run", [*items, controls.describe_text(spot, scenario.title)])


def _list_controls(walk: ControlWalk, part: Parametrised, place: Paths) -> list[FormNode]:
    """Return the controls of a component that the scenario does not store."""
    own = replace(
        walk,
        document_path=place,
        origin_path=place,
        unit=lambda leaf: leaf.declared.unit,
        is_skipped=lambda path: False,
    )
    return own.group(part, "", "")["items"]
